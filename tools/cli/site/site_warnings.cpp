#include "tools/cli/site/site_warnings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "hal/site/site_settings.hpp"
#include "tools/cli/site/ask/vendor_numbers.hpp"

namespace airside::tools {

namespace {

/// One warning for all points whose addresses lie in a vendor's range.
void warn_of_addresses(const hal::PointMap& points, const VendorNumbers& numbers, std::vector<std::string>& out) {
  std::vector<const hal::Point*> found;
  for (const hal::Point& p : points.points()) {
    if (p.addr >= numbers.first && p.addr <= numbers.last) found.push_back(&p);
  }
  if (found.empty()) return;
  const bool other_function =
      std::any_of(found.begin(), found.end(), [&](const hal::Point* p) { return p->fc != numbers.fc; });
  out.push_back(
      fmt::format("line {}: {} has address {}{}: {}; if these are such numbers, write the address less {}{}",
                  found.front()->line, found.front()->name, found.front()->addr,
                  found.size() == 1 ? "" : fmt::format(", and {} more points have such addresses", found.size() - 1),
                  numbers.in_words(), numbers.first, other_function ? fmt::format(", with fc {}", numbers.fc) : ""));
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

/// Whether one is the other with a slip of at most two letters in one place.
bool is_slip_of(std::string_view one, std::string_view other) {
  while (!one.empty() && !other.empty() && one.front() == other.front()) {
    one.remove_prefix(1);
    other.remove_prefix(1);
  }
  while (!one.empty() && !other.empty() && one.back() == other.back()) {
    one.remove_suffix(1);
    other.remove_suffix(1);
  }
  return one.size() <= 2 && other.size() <= 2;
}

/// Points that a site may do without: nobody asks for one whose name was misspelt.
void warn_of_misspelt(const hal::PointMap& points, std::vector<std::string>& out) {
  for (const char* name : {"heartbeat", "device_heartbeat", "supply_temp", "ahu_on", "occupied", "supply_flow"}) {
    if (points.find(name) != nullptr) continue;
    for (const std::string& extra : points.extras()) {
      if (!is_slip_of(extra, name)) continue;
      out.push_back(fmt::format("line {}: \"{}\" means nothing to airside; if it is {}, correct its name",
                                points.at(extra).line, extra, name));
    }
  }
}

}  // namespace

std::vector<std::string> warnings_of(const hal::PointMap& points) {
  std::vector<std::string> out;
  for (const VendorNumbers& numbers : vendor_numbers) warn_of_addresses(points, numbers, out);
  if (std::string heartbeat = hal::warning_of(points); !heartbeat.empty()) out.push_back(std::move(heartbeat));
  warn_of_misspelt(points, out);
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
