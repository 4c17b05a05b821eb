#pragma once
// What zones with boxes that modulate show at one instant.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

namespace airside {

constexpr std::size_t max_zones = 32;  ///< boxes of one air handler

/// Shape: one entry a zone, all of one length; a missing signal is NaN. Units: degC; damper 0..1.
struct ZoneSignals {
  std::span<const double> temp_degc;
  std::span<const double> setpoint_degc;  ///< above which the box cools
  std::span<const double> damper;
  std::span<const double> heating_degc{};  ///< below which the box heats; may be empty
  std::size_t count() const { return temp_degc.size(); }
};

/// Whether zone i shows everything that its demand is computed from.
inline bool zone_is_seen(const ZoneSignals& zones, std::size_t i) {
  return i < zones.damper.size() && i < zones.setpoint_degc.size() && std::isfinite(zones.temp_degc[i]) &&
         std::isfinite(zones.setpoint_degc[i]) && std::isfinite(zones.damper[i]);
}

/// Mean of one value a zone over the zones that are seen; 0 where none is.
inline double mean_of_seen(const ZoneSignals& zones, std::span<const double> values) {
  double sum = 0;
  int seen = 0;
  for (std::size_t i = 0; i < std::min(zones.count(), max_zones); ++i) {
    if (zone_is_seen(zones, i)) sum += values[i], ++seen;
  }
  return seen > 0 ? sum / seen : 0.0;
}

/// Below which zone i is heated, degC; NaN where no point shows it, or shows what cannot be: more than it is cooled to.
inline double zone_heating_degc(const ZoneSignals& zones, std::size_t i) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  if (i >= zones.heating_degc.size()) return none;
  return zones.heating_degc[i] <= zones.setpoint_degc[i] ? zones.heating_degc[i] : none;
}

}  // namespace airside
