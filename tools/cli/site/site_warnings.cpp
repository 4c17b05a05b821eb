#include "tools/cli/site/site_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "hal/site/site_settings.hpp"

namespace airside::tools {

namespace {

/// How vendors number what one function reads: `first` is its address 0.
struct Numbering {
  int first, last, fc;
};
constexpr std::array<Numbering, 3> vendor_numbers = {{{10001, 19999, 2}, {30001, 39999, 4}, {40001, 49999, 3}}};

/// One warning for all points whose addresses lie in a vendor's range.
void warn_of_addresses(const hal::PointMap& points, const Numbering& numbers, std::vector<std::string>& out) {
  std::vector<const hal::Point*> found;
  for (const hal::Point& p : points.points()) {
    if (p.addr >= numbers.first && p.addr <= numbers.last) found.push_back(&p);
  }
  if (found.empty()) return;
  const bool other_function =
      std::any_of(found.begin(), found.end(), [&](const hal::Point* p) { return p->fc != numbers.fc; });
  out.push_back(fmt::format(
      "line {}: {} has address {}{}: in a vendor's table {} is usually register 0 of function {}; if these are such "
      "numbers, write the address less {}{}",
      found.front()->line, found.front()->name, found.front()->addr,
      found.size() == 1 ? "" : fmt::format(", and {} more points have such addresses", found.size() - 1), numbers.first,
      numbers.fc, numbers.first, other_function ? fmt::format(", with fc {}", numbers.fc) : ""));
}

bool is_status(const std::string& name) {
  return name == "rain" || name.starts_with("vav_on_") || name.starts_with("fcu_on_");
}

/// A status whose raw 1 is not on.
void warn_of_fractions(const hal::PointMap& points, std::vector<std::string>& out) {
  for (const hal::Point& p : points.points()) {
    if (p.is_bit() || !is_status(p.name) || std::abs(p.scale) == std::round(std::abs(p.scale))) continue;
    out.push_back(fmt::format(
        "line {}: {} has scale {:g}: a raw 1 then reads as {:g}, not as on; right only where the register holds a "
        "share, such as 0 to {:g} for 0 to 1",
        p.line, p.name, p.scale, p.scale + p.offset, (1 - p.offset) / p.scale));
  }
}

}  // namespace

std::vector<std::string> warnings_of(const hal::PointMap& points) {
  std::vector<std::string> out;
  for (const Numbering& numbers : vendor_numbers) warn_of_addresses(points, numbers, out);
  if (std::string heartbeat = hal::warning_of(points); !heartbeat.empty()) out.push_back(std::move(heartbeat));
  warn_of_fractions(points, out);
  return out;
}

std::vector<std::string> warnings_of(const hal::SiteFile& site) {
  std::vector<std::string> out;
  const auto within = [&](const char* key, double degc) {
    if (degc >= site.setpoint_min_degc && degc <= site.setpoint_max_degc) return;
    const bool below = degc < site.setpoint_min_degc;
    out.push_back(fmt::format(
        "expert.{} = {:g} is {} setpoint.{} = {:g}: the schedule will be held at that limit, and the controller never "
        "tries what the schedule does",
        key, degc, below ? "below" : "above", below ? "min_degc" : "max_degc",
        below ? site.setpoint_min_degc : site.setpoint_max_degc));
  };
  within("work_degc", site.expert_work_degc);
  within("off_degc", site.expert_off_degc);
  if (std::string mqtt = site.mqtt ? hal::warning_of(*site.mqtt) : ""; !mqtt.empty()) out.push_back(std::move(mqtt));
  return out;
}

}  // namespace airside::tools
