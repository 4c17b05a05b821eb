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
#include "airside/supervision/guideline36.hpp"

namespace airside {

/// Each step of T = 2 min, with R the sum of importance times requests (either trim or respond):
///   Tmax = clamp(Tmax + (R <= I ? trim : -min(respond (R - I), respond_max)), SPmin, SPmax)
/// and the setpoint is Tmax below `oat_min_degc` outdoors, SPmin above `oat_max_degc`, linear between.
/// Requests of a zone: 3 when it was 3 K above its setpoint for 2 min, 2 at 2 K, 1 from 95 % cooling loop until below
/// 85 %; none for a while after its setpoint changed (9 min a K, at most 30). The loop is seen by the damper.
/// Plain bytes. Source: docs/method.md 17.7.
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
    step(settings);
    if (!settings.oat_reset || !std::isfinite(outdoor_temp_degc)) return reset_degc_;
    const double warm = std::clamp(
        (outdoor_temp_degc - settings.oat_min_degc) / (settings.oat_max_degc - settings.oat_min_degc), 0.0, 1.0);
    return reset_degc_ + warm * (settings.sp_min_degc - reset_degc_);
  }

  double requests() const { return requests_; }  ///< of the last reading
  double reset_degc() const { return reset_degc_; }

 private:
  struct Zone {
    double setpoint_degc = 0;
    double suppressed_s = 0;
    double above_3k_s = 0, above_2k_s = 0;
    std::int64_t calls = 0;
  };

  void restart(const Guideline36Settings& s) {
    reset_degc_ = s.sp_max_degc;
    running_s_ = pending_s_ = 0;
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
    if (damper > 0.95) zone.calls = 1;
    if (!(damper >= 0.85)) zone.calls = 0;
    if (zone.suppressed_s <= 0 && zone.above_3k_s >= 120) return 3;
    if (zone.suppressed_s <= 0 && zone.above_2k_s >= 120) return 2;
    return zone.calls != 0 ? 1 : 0;
  }

  void step(const Guideline36Settings& s) {
    const std::int32_t before_s = running_s_;
    running_s_ += s.period_s;
    pending_s_ += running_s_ - std::max(before_s, std::min<std::int32_t>(s.delay_s, running_s_));
    for (; pending_s_ >= s.step_s; pending_s_ -= s.step_s) {
      const double excess = requests_ - s.ignored_requests;
      const double change = excess <= 0 ? s.trim_k : -std::min(s.respond_k * excess, s.respond_max_k);
      reset_degc_ = std::clamp(reset_degc_ + change, s.sp_min_degc, s.sp_max_degc);
    }
  }

  std::array<Zone, max_rooms> zones_{};
  double reset_degc_ = 0;  ///< Tmax
  double requests_ = 0;
  std::int32_t running_s_ = 0;
  std::int32_t pending_s_ = 0;
  std::int32_t started_ = 0;
};

}  // namespace airside
