#include "tools/cli/probe/sheet.hpp"

#include <fmt/format.h>

#include <stdexcept>

#include "hal/points/register_codec.hpp"
#include "hal/text/input_error.hpp"
#include "tools/cli/probe/connection.hpp"

namespace airside::tools {

double expected_fingerprint(const hal::PointMap& map) { return map.told_fingerprint(); }

namespace {

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
  row.has_no_value = !value && value.error() == Fault::not_finite;
  if (row.order_doubted) {
    row.verdict = fmt::format("makes no sense as {}", hal::order_text(p, p.byte_order, p.word_order));
  } else if (p.name == "map_fingerprint" && value && *value != expected_fingerprint(map)) {
    row.in_order = false;
    row.verdict = fmt::format("another device: the map expects {}", expected_fingerprint(map));
  } else if (p.name == "map_fingerprint" && value) {
    row.fits.clear();
    row.verdict = "the map's";
  } else if (!value && p.writable() && p.name != "setpoint") {
    row.in_order = row.is_unwritten = true;
    row.verdict = "nothing was written yet";
  } else if (value) {
    row.verdict = row.in_order ? "in range" : "next to nothing beside its limits";
  } else {
    row.verdict = row.has_no_value ? "the device has no value" : fmt::format("outside {} to {}", p.min, p.max);
  }
}

}  // namespace

hal::LinkResult<std::vector<std::uint16_t>> ProbedDevice::read(const hal::Point& point) {
  const std::tuple<int, int, int> key{point.fc, point.addr, point.width()};
  if (const auto known = known_.find(key); known != known_.end()) return known->second;
  std::vector<std::uint16_t> raw(static_cast<std::size_t>(point.width()));
  const hal::LinkResult<void> got = link_.read(point.fc, point.addr, raw);
  hal::LinkResult<std::vector<std::uint16_t>> answer = raw;
  if (!got) answer = tl::unexpected(got.error());
  lost_ = got || got.error().error == hal::LinkError::exception_answer ? 0 : lost_ + 1;
  known_.emplace(key, answer);
  return answer;
}

std::vector<ProbedPoint> probe_all(const hal::PointMap& map, ProbedDevice& device, const std::string& address,
                                   const hal::SiteFile& site) {
  std::vector<ProbedPoint> sheet;
  for (const hal::Point& p : map.points()) {
    ProbedPoint& row = sheet.emplace_back();
    row.point = &p;
    if (!p.readable()) {
      row.in_order = true;
      row.verdict = "write-only: not read";
      continue;
    }
    if (device.is_lost()) {
      row.verdict = "not asked";
      continue;
    }
    const auto got = device.read(p);
    if (got) {
      row.was_asked = true;
      row.raw = *got;
      judge_probe(row, map);
      continue;
    }
    row.was_asked = got.error().error == hal::LinkError::exception_answer;
    row.verdict = complaint_of(got.error());
    if (got.error().error == hal::LinkError::connect_failed) {
      const auto why = why_no_connection(site);
      throw hal::InputError(address, why ? fmt::format("{} ({})", row.verdict, why->found) : row.verdict,
                            "a Modbus device that answers",
                            why ? fmt::format("{}; host, port and device are in {}", why->remedy, site.path)
                                : fmt::format("try again: a connection is taken now; see who else is connected, since "
                                              "some devices take one or two, and host, port and device in {}",
                                              site.path));
    }
  }
  return sheet;
}

}  // namespace airside::tools
