#pragma once
// What the objective "band" sees, what it may choose from, and what it expects of its choice.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "airside/civil_time.hpp"
#include "airside/demand/zone_signals.hpp"

namespace airside {

/// What the objective sees at one row. NaN: not there.
struct DemandReading {
  CivilTime time;
  ZoneSignals zones;
  std::span<const double> power_kw;                               ///< one a meter
  double supply_degc = std::numeric_limits<double>::quiet_NaN();  ///< measured, else the setpoint
  double outdoor_degc = std::numeric_limits<double>::quiet_NaN();
  double flow_m3_s = std::numeric_limits<double>::quiet_NaN();  ///< of the supply fan
  bool flows = true;     ///< air does; of a row that is learned from: and nothing in it is held or doubted
  bool doubted = false;  ///< air flows, though `flows` is false
  bool coldest = false;  ///< the setpoint applied until now is the lowest that may be chosen
  bool warmest = false;  ///< and the highest
};

/// At least half of the zones show temperature, setpoint and damper, and the supply temperature is known.
inline bool shows_band(const DemandReading& at) {
  std::size_t seen = 0;
  const std::size_t n = std::min(at.zones.count(), max_zones);
  for (std::size_t i = 0; i < n; ++i) seen += zone_is_seen(at.zones, i) ? 1u : 0u;
  return n > 0 && 2 * seen >= n && std::isfinite(at.supply_degc);
}

/// What was expected of the chosen setpoint.
struct DemandForecast {
  double setpoint_degc = std::numeric_limits<double>::quiet_NaN();
  double power_kw = std::numeric_limits<double>::quiet_NaN();
  double most_open = 0;  ///< damper wanted by the neediest zone
  double cost_kw = 0;
};

/// The setpoints to choose from, and what the site had before.
struct DemandChoice {
  double min_degc = 12, max_degc = 18, step_k = 0.1;
  double schedule_degc = 14;  ///< savings are counted against it
  double last_degc = std::numeric_limits<double>::quiet_NaN();
};

}  // namespace airside
