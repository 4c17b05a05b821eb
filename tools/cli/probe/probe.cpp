// airside probe: the point-checkout sheet, and what rows that make no sense should say. Nothing is written to the bus.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>

#include "hal/modbus/link.hpp"
#include "hal/points/word_order.hpp"
#include "hal/site/site_file.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/probe/corrected_map.hpp"
#include "tools/cli/probe/proposals.hpp"
#include "tools/cli/probe/sheet.hpp"

namespace airside::tools {

namespace {

struct ProbeCommand {
  std::string site_path;
  std::string write_path;
  bool force = false, as_json = false;

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

  void print_json(const std::vector<ProbedPoint>& sheet, const std::vector<Proposal>& proposals,
                  const std::string& device, std::size_t changed) const {
    nlohmann::json points = nlohmann::json::array(), proposed = nlohmann::json::array();
    for (const Proposal& p : proposals) proposed.push_back(json_of(p));
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
    fmt::print(
        "{}\n",
        nlohmann::json{
            {"device", device}, {"ok", all}, {"points", points}, {"proposals", proposed}, {"changed_rows", changed}}
            .dump());
  }

  static nlohmann::json json_of(const Proposal& proposal) {
    const hal::Point& stated = *proposal.probed->point;
    nlohmann::json readings = nlohmann::json::array();
    for (const OtherReading& r : proposal.readings) {
      nlohmann::json cells = nlohmann::json::object();
      for (const auto& [column, text] : changed_cells(stated, r.point)) cells[column] = text;
      readings.push_back({{"cells", cells},
                          {"value", std::isfinite(r.value) ? nlohmann::json(r.value) : nlohmann::json()},
                          {"changes", r.changes}});
    }
    return {{"name", stated.name},
            {"decided", proposal.is_decided()},
            {"readings", readings},
            {"evidence", proposal.evidence}};
  }

  /// Writes the decided proposals; returns how many rows changed.
  std::size_t write_corrected(const hal::PointMap& map, const std::vector<Proposal>& proposals) const {
    std::vector<CorrectedRow> rows;
    for (const Proposal& p : proposals) {
      if (!p.is_decided()) continue;
      rows.push_back({p.probed->point->line, changed_cells(*p.probed->point, p.readings.front().point)});
    }
    if (rows.empty()) return 0;
    write_map(write_path, corrected_map(hal::read_text_file(map.file(), "a point map in CSV"), map.file(), rows),
              force);
    return rows.size();
  }

  void print_proposals(const std::vector<Proposal>& proposals, const std::string& file) const {
    if (proposals.empty()) return;
    std::error_code none;
    const bool is_replaced = !write_path.empty() && std::filesystem::equivalent(write_path, file, none);
    fmt::print("proposals{}:\n", is_replaced ? "" : fmt::format(", {} is as it was", file));
    for (const Proposal& p : proposals) fmt::print("{}", text_of(p));
  }

  void run() const {
    const hal::SiteFile site = hal::read_site_file(site_path, hal::site_rules());
    if (!site.modbus) {
      throw hal::InputError(site_path + ": [modbus]", "no such section", "how to reach the AHU",
                            "add [modbus] with host or device and points");
    }
    const hal::PointMap map = hal::PointMap::load(site.modbus->points);
    if (!write_path.empty()) refuse_to_overwrite();
    constexpr double no_wait_s = 0;  // each point is asked once, whatever became of the one before
    hal::ModbusLink link(hal::link_settings(*site.modbus, no_wait_s, no_wait_s));
    ProbedDevice device(link);
    const std::vector<ProbedPoint> sheet = probe_all(map, device, link.description(), site);
    const std::vector<Proposal> proposals = device.is_lost() ? std::vector<Proposal>{} : propose(sheet, map, device);
    const std::size_t changed = write_path.empty() ? 0 : write_corrected(map, proposals);
    if (as_json) {
      print_json(sheet, proposals, link.description(), changed);
    } else {
      print_table(sheet, link.description());
      print_proposals(proposals, map.file());
      if (changed > 0) {
        fmt::print("wrote {} with {} row{} changed; compare with the device's manual, then name it as points in {}\n",
                   write_path, changed, changed == 1 ? "" : "s", site_path);
      } else if (!write_path.empty()) {
        fmt::print("nothing to propose: {} was not written\n", write_path);
      }
    }
    std::fflush(stdout);
    complain_of(sheet, proposals, map.file());
  }

  void refuse_to_overwrite() const {
    if (force || !std::filesystem::exists(write_path)) return;
    throw hal::InputError(write_path, "a file that is already there", "a new file for the corrected map",
                          "choose another name, or give --force to overwrite it");
  }

  /// Exit code 1 and a reason, unless every row that is not in order has been corrected in the new file.
  void complain_of(const std::vector<ProbedPoint>& sheet, const std::vector<Proposal>& proposals,
                   const std::string& file) const {
    const auto is_corrected = [&](const ProbedPoint& row) {
      return !write_path.empty() &&
             std::ranges::any_of(proposals, [&](const Proposal& p) { return p.probed == &row && p.is_decided(); });
    };
    std::string doubted, wrong;
    for (const ProbedPoint& row : sheet) {
      if (row.in_order || is_corrected(row)) continue;
      std::string& list = row.order_doubted ? doubted : wrong;
      list += fmt::format("{}{}", list.empty() ? "" : ", ", row.point->name);
    }
    if (!doubted.empty()) {
      throw std::runtime_error(
          fmt::format("{} would make sense in another order of bytes or words only; nothing was "
                      "changed: compare with the device's manual, then correct byte_order and "
                      "word_order in {}{}",
                      doubted, file, wrong.empty() ? "" : "; not in order too: " + wrong));
    }
    if (!wrong.empty()) throw std::runtime_error("not in order: " + wrong);
  }
};

}  // namespace

void add_probe(CLI::App& app) {
  auto self = std::make_shared<ProbeCommand>();
  CLI::App* c = app.add_subcommand(
      "probe",
      "read each point of a site over its bus and print the point-checkout sheet: address, raw registers, value,\n"
      "in range or not, and for 32-bit values the other orders of bytes and words that would make sense.\n"
      "Where a value is implausible it reads the neighbouring registers too, and says which scale, unit, order, type,\n"
      "function or address would fit, with the evidence. --write puts what is certain into a new points.csv; a row "
      "with\n"
      "several plausible readings stays as it is, and all are named.\n"
      "It never writes to the device, and may run beside airsided on Modbus TCP. Exit code 1 where a point is not in\n"
      "order (with --write: and has not been corrected in the new file).");
  c->add_option("site", self->site_path, "site file, such as /etc/airside/site.toml")->required();
  CLI::Option* write =
      c->add_option("--write", self->write_path, "new point map with the proposals, such as points.new.csv");
  c->add_flag("--force", self->force, "overwrite the file of --write, which may be the old map")->needs(write);
  c->add_flag("--json", self->as_json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
