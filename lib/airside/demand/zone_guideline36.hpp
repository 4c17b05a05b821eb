#pragma once
// ASHRAE Guideline 36 supply-air temperature reset as written for boxes that modulate: requests from each zone's own
// setpoint and damper. What a modern site runs where dampers can be read, and what the objective "band" is judged by.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "airside/demand/zone_signals.hpp"
#include "airside/supervision/guideline36_settings.hpp"
#include "airside/supervision/trim_and_respond.hpp"

namespace airside {

/// The reset of trim_and_respond.hpp. A zone counts as 2 or 3 K above its setpoint when it was so for 2 min, and not
/// for a while after its setpoint changed (9 min a K, at most 30). Its cooling loop is seen by the damper.
/// Shape: at most max_zones zones. Plain bytes.  Source: docs/method.md 17.7.
class ZoneGuideline36 {
 public:
  static constexpr std::size_t max_rooms = max_zones;

  /// The setpoint from now until the next reading, degC. Called every `settings.period_s`.
  /// Shape: importance empty (1 each) or one a zone. Errors: a zone without a temperature or setpoint asks for nothing.
  double setpoint_degc(const Guideline36Settings& settings, const ZoneSignals& zones, double outdoor_temp_degc,
                       bool fan_runs, std::span<const double> importance = {}) {
    if (started_ == 0) restart(settings);
    started_ = 1;
    if (!fan_runs) {
      restart(settings);
      return settings.sp_max_degc;
    }
    requests_ = 0;
    const std::size_t rooms = std::min(zones.count(), max_rooms);
    for (std::size_t i = 0; i < rooms; ++i) {
      const double weight = i < importance.size() ? importance[i] : 1.0;
      requests_ += weight * zone_requests(settings, zones_[i], zones, i);
    }
    reset_.row(settings, requests_);
    return reset_.setpoint_degc(settings, outdoor_temp_degc);
  }

  double requests() const { return requests_; }  ///< of the last reading, importance included
  double reset_degc() const { return reset_.reset_degc(); }

 private:
  struct Zone {
    double setpoint_degc = 0;
    double suppressed_s = 0;
    double above_3k_s = 0, above_2k_s = 0;
    CoolingRequests cooling;
  };

  void restart(const Guideline36Settings& s) {
    reset_.restart(s);
    zones_ = {};
  }

  static int zone_requests(const Guideline36Settings& s, Zone& zone, const ZoneSignals& zones, std::size_t i) {
    const double error_k = zones.temp_degc[i] - zones.setpoint_degc[i];
    if (!std::isfinite(error_k)) {
      zone = {};
      return 0;
    }
    if (zone.setpoint_degc > 0 && zones.setpoint_degc[i] != zone.setpoint_degc) {
      zone.suppressed_s = std::min(1800.0, 540 * std::abs(zones.setpoint_degc[i] - zone.setpoint_degc));
    }
    zone.setpoint_degc = zones.setpoint_degc[i];
    zone.suppressed_s = std::max(0.0, zone.suppressed_s - s.period_s);
    zone.above_3k_s = error_k >= 3 ? zone.above_3k_s + s.period_s : 0;
    zone.above_2k_s = error_k >= 2 ? zone.above_2k_s + s.period_s : 0;
    const double damper = i < zones.damper.size() ? zones.damper[i] : 0;
    const bool counts = zone.suppressed_s <= 0;
    return zone.cooling.row(damper, counts && zone.above_2k_s >= 120, counts && zone.above_3k_s >= 120);
  }

  std::array<Zone, max_rooms> zones_{};
  TrimAndRespond reset_;
  double requests_ = 0;
  std::int32_t started_ = 0;
};

}  // namespace airside
