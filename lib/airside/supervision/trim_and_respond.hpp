#pragma once
// Trim and respond, the reset of ASHRAE Guideline 36: the setpoint rises a little while few zones ask for cooling, and
// falls by how many more do. Shared by the rules that differ in where requests come from.

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "airside/supervision/guideline36_settings.hpp"

namespace airside {

/// Requests of one zone: 3 at 3 K above its setpoint, 2 at 2 K, 1 from 95 % cooling loop until below 85 %.
/// Plain bytes: part of the durable state.
class CoolingRequests {
 public:
  /// Requests now. Shape: `loop` 0..1. Errors: a loop that is not finite calls for nothing.
  int row(double loop, bool is_2k_above, bool is_3k_above) {
    if (loop > 0.95) calls_ = 1;
    if (!(loop >= 0.85)) calls_ = 0;
    if (is_3k_above) return 3;
    if (is_2k_above) return 2;
    return calls_ != 0 ? 1 : 0;
  }

 private:
  std::int64_t calls_ = 0;  ///< 1: between its two thresholds the loop counts as full
};

/// Each step of T, with R the sum of the zones' requests (either trim or respond):
///   Tmax = clamp(Tmax + (R <= I ? trim : -min(respond (R - I), respond_max)), SPmin, SPmax)
/// Units: degC. Plain bytes: part of the durable state.  Source: ASHRAE Guideline 36-2021, 5.1.14 and 5.16.2.
class TrimAndRespond {
 public:
  /// Begins anew at SP0: the fan has stopped, or has not run yet.
  void restart(const Guideline36Settings& s) {
    reset_degc_ = s.sp_max_degc;
    running_s_ = pending_s_ = 0;
  }

  /// A reading while the fan runs, once each `period_s`: its requests stand for the time since the reading before. The
  /// first steps come after the delay Td.
  void row(const Guideline36Settings& s, double requests) {
    const std::int32_t before_s = running_s_;
    running_s_ += s.period_s;
    pending_s_ += running_s_ - std::max(before_s, std::min<std::int32_t>(s.delay_s, running_s_));
    for (; pending_s_ >= s.step_s; pending_s_ -= s.step_s) {
      const double excess = requests - s.ignored_requests;
      const double change = excess <= 0 ? s.trim_k : -std::min(s.respond_k * excess, s.respond_max_k);
      reset_degc_ = std::clamp(reset_degc_ + change, s.sp_min_degc, s.sp_max_degc);
    }
  }

  /// The setpoint: Tmax below `oat_min_degc` outdoors, SPmin above `oat_max_degc`, linear between.
  /// Errors: without an outdoor temperature, or without that reset, Tmax.
  double setpoint_degc(const Guideline36Settings& s, double outdoor_temp_degc) const {
    if (!s.oat_reset || !std::isfinite(outdoor_temp_degc)) return reset_degc_;
    const double warm = std::clamp((outdoor_temp_degc - s.oat_min_degc) / (s.oat_max_degc - s.oat_min_degc), 0.0, 1.0);
    return reset_degc_ + warm * (s.sp_min_degc - reset_degc_);
  }
  double reset_degc() const { return reset_degc_; }

 private:
  double reset_degc_ = 0;       ///< Tmax
  std::int32_t running_s_ = 0;  ///< since the fan was proven on
  std::int32_t pending_s_ = 0;  ///< time not yet used up by steps
};

}  // namespace airside
