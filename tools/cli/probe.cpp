// airside probe: the point-checkout sheet. Each point is read once over the bus; nothing is ever written.

#include <fmt/format.h>

#include <cmath>
#include <cstdio>

#include "hal/modbus/link.hpp"
#include "hal/points/register_codec.hpp"
#include "hal/points/word_order.hpp"
#include "hal/site/site_file.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/text/input_error.hpp"
#include "tools/cli/command.hpp"

namespace airside::tools {

namespace {

/// One row of the sheet.
struct ProbedPoint {
  const hal::Point* point;
  std::vector<std::uint16_t> raw;  ///< empty: nothing was read
  double value = std::nan("");
  std::string verdict;
  bool in_order = false;
  bool order_doubted = false;
  std::vector<hal::OrderGuess> fits;  ///< other orders in which it makes sense
};

std::string complaint_of(const hal::LinkFault& fault) {
  if (fault.error != hal::LinkError::exception_answer) return hal::text_of(fault.error);
  const char* meaning = "the device refuses";
  switch (fault.exception) {
    case 1: meaning = "it does not know the function: look at fc"; break;
    case 2: meaning = "it has no such register: look at addr"; break;
    case 3: meaning = "it does not take the count: look at type"; break;
    case 4: meaning = "the device has failed"; break;
    case 5:
    case 6: meaning = "the device is busy"; break;
    case 10:
    case 11: meaning = "a gateway does not reach it: look at unit_id"; break;
    default: break;
  }
  return fmt::format("exception {}: {}", fault.exception, meaning);
}

void judge_probe(ProbedPoint& row, const hal::PointMap& map) {
  const hal::Point& p = *row.point;
  const Expected<double> value = hal::decode(p, row.raw);
  hal::Point unlimited = p;
  unlimited.min = -HUGE_VAL;
  unlimited.max = HUGE_VAL;
  row.value = hal::decode(unlimited, row.raw).value_or(std::nan(""));
  const hal::OrderGuesses others = hal::other_orders(p, row.raw);
  for (int i = 0; i < others.count; ++i) {
    const hal::OrderGuess& g = others.guess[static_cast<std::size_t>(i)];
    if (std::isfinite(g.value) && g.value != row.value) row.fits.push_back(g);
  }
  row.order_doubted = hal::fits_other_order_only(p, row.raw);
  row.in_order = hal::makes_sense(p, row.raw);
  if (row.order_doubted) {
    row.verdict = fmt::format("makes no sense as {}", hal::order_text(p, p.byte_order, p.word_order));
  } else if (p.name == "map_fingerprint" && value && *value != map.told_fingerprint()) {
    row.in_order = false;
    row.verdict = fmt::format("another device: the map expects {}", map.told_fingerprint());
  } else if (p.name == "map_fingerprint" && value) {
    row.fits.clear();
    row.verdict = "the map's";
  } else if (!value && p.writable() && p.name != "setpoint") {
    row.in_order = true;
    row.verdict = "nothing was written yet";
  } else if (value) {
    row.verdict = row.in_order ? "in range" : "next to nothing beside its limits";
  } else {
    row.verdict =
        value.error() == Fault::not_finite ? "the device has no value" : fmt::format("outside {} to {}", p.min, p.max);
  }
}

struct ProbeCommand {
  std::string site_path;
  bool as_json = false;

  std::vector<ProbedPoint> read_all(const hal::PointMap& map, hal::ModbusLink& link) const {
    std::vector<ProbedPoint> sheet;
    int lost = 0;
    for (const hal::Point& p : map.points()) {
      ProbedPoint& row = sheet.emplace_back();
      row.point = &p;
      if (!p.readable()) {
        row.in_order = true;
        row.verdict = "write-only: not read";
        continue;
      }
      if (lost >= 3) {
        row.verdict = "not asked";
        continue;
      }
      row.raw.resize(static_cast<std::size_t>(p.width()));
      const hal::LinkResult<void> got = link.read(p.fc, p.addr, row.raw);
      if (got) {
        lost = 0;
        judge_probe(row, map);
        continue;
      }
      row.raw.clear();
      row.verdict = complaint_of(got.error());
      if (got.error().error == hal::LinkError::connect_failed) {
        throw hal::InputError(link.description(), row.verdict, "a Modbus device that answers",
                              fmt::format("look at host, port or device in {}, and at the cable", site_path));
      }
      lost = got.error().error == hal::LinkError::exception_answer ? 0 : lost + 1;
    }
    return sheet;
  }

  static std::string hex(const std::vector<std::uint16_t>& raw) {
    std::string text;
    for (const std::uint16_t word : raw) text += fmt::format("{}{:04x}", text.empty() ? "" : " ", word);
    return text;
  }

  void print_table(const std::vector<ProbedPoint>& sheet, const std::string& device) const {
    fmt::print("{}\n{:<18} {:>2} {:>5} {:<10} {:>5} {:>14} {:<6} {}\n", device, "name", "fc", "addr", "raw", "order",
               "value", "unit", "verdict");
    for (const ProbedPoint& row : sheet) {
      const hal::Point& p = *row.point;
      std::string also;
      if (p.width() == 2 || row.order_doubted) {
        for (const hal::OrderGuess& g : row.fits) {
          also += fmt::format("{} {} gives {:.6g}", also.empty() ? ";" : ",",
                              hal::order_text(p, g.byte_order, g.word_order), g.value);
        }
      }
      fmt::print("{:<18} {:>2} {:>5} {:<10} {:>5} {:>14} {:<6} {}{}\n", p.name, p.fc, p.addr, hex(row.raw),
                 hal::order_text(p, p.byte_order, p.word_order),
                 row.raw.empty() ? std::string("-") : fmt::format("{:.10g}", row.value), p.unit, row.verdict, also);
    }
  }

  void print_json(const std::vector<ProbedPoint>& sheet, const std::string& device) const {
    nlohmann::json points = nlohmann::json::array();
    bool all = true;
    for (const ProbedPoint& row : sheet) {
      const hal::Point& p = *row.point;
      nlohmann::json fits = nlohmann::json::array();
      for (const hal::OrderGuess& g : row.fits) {
        fits.push_back({{"order", hal::order_text(p, g.byte_order, g.word_order)},
                        {"byte_order", g.byte_order == hal::Endian::big ? "big" : "little"},
                        {"word_order", g.word_order == hal::Endian::big ? "big" : "little"},
                        {"value", g.value}});
      }
      nlohmann::json entry = {{"name", p.name},
                              {"unit", p.unit},
                              {"fc", p.fc},
                              {"addr", p.addr},
                              {"raw", row.raw},
                              {"order", hal::order_text(p, p.byte_order, p.word_order)},
                              {"verdict", row.verdict},
                              {"in_order", row.in_order},
                              {"order_doubted", row.order_doubted},
                              {"other_orders", fits}};
      entry["value"] = std::isfinite(row.value) ? nlohmann::json(row.value) : nlohmann::json();
      points.push_back(entry);
      all = all && row.in_order;
    }
    fmt::print("{}\n", nlohmann::json{{"device", device}, {"ok", all}, {"points", points}}.dump());
  }

  void run() const {
    const hal::SiteFile site = hal::read_site_file(site_path, hal::site_rules());
    if (!site.modbus) {
      throw hal::InputError(site_path + ": [modbus]", "no such section", "how to reach the AHU",
                            "add [modbus] with host or device and points");
    }
    const hal::PointMap points = hal::PointMap::load(site.modbus->points);
    constexpr double no_wait_s = 0;  // each point is asked once, whatever became of the one before
    hal::ModbusLink link(hal::link_settings(*site.modbus, no_wait_s, no_wait_s));
    const std::vector<ProbedPoint> sheet = read_all(points, link);
    if (as_json) {
      print_json(sheet, link.description());
    } else {
      print_table(sheet, link.description());
    }
    std::fflush(stdout);
    std::string doubted, wrong;
    for (const ProbedPoint& row : sheet) {
      std::string& list = row.order_doubted ? doubted : wrong;
      if (!row.in_order) list += fmt::format("{}{}", list.empty() ? "" : ", ", row.point->name);
    }
    if (!doubted.empty()) {
      throw std::runtime_error(
          fmt::format("{} would make sense in another order of bytes or words only; nothing was "
                      "changed: compare with the device's manual, then correct byte_order and "
                      "word_order in {}{}",
                      doubted, site.modbus->points, wrong.empty() ? "" : "; not in order too: " + wrong));
    }
    if (!wrong.empty()) throw std::runtime_error("not in order: " + wrong);
  }
};

}  // namespace

void add_probe(CLI::App& app) {
  auto self = std::make_shared<ProbeCommand>();
  CLI::App* c = app.add_subcommand(
      "probe",
      "read each point of a site once over its bus and print the point-checkout sheet: address, raw registers, value,\n"
      "in range or not, and for 32-bit values the other orders of bytes and words that would make sense.\n"
      "It never writes, and may run beside airsided on Modbus TCP. Exit code 1 where a point is not in order.");
  c->add_option("site", self->site_path, "site file, such as /etc/airside/site.toml")->required();
  c->add_flag("--json", self->as_json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
