#include "tools/baselines/guideline36.hpp"

#include <algorithm>
#include <cmath>

#include "airside/expert.hpp"

namespace airside::tools {

Guideline36Settings guideline36_as_written(double sp_max_degc) {
  Guideline36Settings s;
  s.sp_max_degc = sp_max_degc;
  return s;
}

Guideline36Settings guideline36_on_site(const ControllerSettings& site, int ignored_requests) {
  Guideline36Settings s;
  s.sp_min_degc = site.action_min_degc;
  s.sp_max_degc = std::min(site.expert_off_degc, site.action_max_degc);
  s.ignored_requests = ignored_requests;
  s.oat_reset = false;
  s.clamp_to_site = true;
  return s;
}

int Guideline36Baseline::zone_requests(Zone& zone, double error_k, bool open, double dt_h) const {
  if (!open || !std::isfinite(error_k)) {
    zone = {};
    return 0;
  }
  double loop = 1.0;
  if (settings_.loop == CoolingLoop::zone_pi) {
    zone.integral = std::clamp(zone.integral + settings_.loop_integral_per_kh * error_k * dt_h, 0.0, 1.0);
    loop = std::clamp(settings_.loop_gain_per_k * error_k + zone.integral, 0.0, 1.0);
  }
  if (loop > 0.95) zone.calls = true;
  if (loop < 0.85) zone.calls = false;
  if (error_k >= 3) return 3;
  if (error_k >= 2) return 2;
  return zone.calls ? 1 : 0;
}

double Guideline36Baseline::bounded(double setpoint_degc) const {
  if (settings_.clamp_to_site) return admissible_setpoint_degc(setpoint_degc, site_);
  return std::round(setpoint_degc / site_.round_k) * site_.round_k;
}

double Guideline36Baseline::decide(const CycleObservation& now) {
  const double dt_h = settings_.period_s / 3600.0;
  const auto& rooms = now.sensors.room_temp_degc;
  const auto open = [&](std::size_t i) { return i >= now.sensors.vav_on.size() || now.sensors.vav_on[i] > 0.5; };
  zones_.resize(rooms.size());
  requests_ = 0;
  bool fan = rooms.empty();
  for (std::size_t i = 0; i < rooms.size(); ++i) {
    fan = fan || open(i);
    requests_ += zone_requests(zones_[i], rooms[i] - now.target_degc, open(i), dt_h);
  }

  if (!in_working_hours(site_, now.time) || !fan) {
    reset_degc_ = settings_.sp_max_degc;
    running_s_ = pending_s_ = 0;
    was_occupied_ = false;
    const bool soon = in_working_hours(site_, CivilTime{now.time.seconds + settings_.cooldown_s});
    if (soon && room_mean_degc(now.sensors) > now.target_degc) return bounded(settings_.sp_min_degc);
    return bounded(site_.expert_off_degc);
  }
  if (was_occupied_) {
    // The requests seen now stand for the time since the last decision.
    const int before_s = running_s_;
    running_s_ += settings_.period_s;
    pending_s_ += running_s_ - std::max(before_s, std::min(settings_.delay_s, running_s_));
    for (; pending_s_ >= settings_.step_s; pending_s_ -= settings_.step_s) {
      const int excess = requests_ - settings_.ignored_requests;
      const double step =
          excess <= 0 ? settings_.trim_k : -std::min(settings_.respond_k * excess, settings_.respond_max_k);
      reset_degc_ = std::clamp(reset_degc_ + step, settings_.sp_min_degc, settings_.sp_max_degc);
    }
  }
  was_occupied_ = true;
  if (!settings_.oat_reset || !std::isfinite(now.sensors.outdoor_temp_degc)) return bounded(reset_degc_);
  const double warm = std::clamp(
      (now.sensors.outdoor_temp_degc - settings_.oat_min_degc) / (settings_.oat_max_degc - settings_.oat_min_degc), 0.0,
      1.0);
  return bounded(reset_degc_ + warm * (settings_.sp_min_degc - reset_degc_));
}

}  // namespace airside::tools
