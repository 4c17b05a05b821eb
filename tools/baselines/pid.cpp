#include "tools/baselines/pid.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "airside/splitmix64.hpp"
#include "airside/supervision/schedule.hpp"

namespace airside::tools {
namespace {

/// Hours since the last decision. The first decision counts a cycle; a pause (a gap in the log) at most an
/// hour.
double hours_since(const std::optional<CivilTime>& last, CivilTime now, const ControllerSettings& site) {
  if (!last) return control_cycle(site).seconds() / 3600.0;
  return std::clamp(static_cast<double>(now.seconds - last->seconds) / 3600.0, 0.0, 1.0);
}

}  // namespace

double PidBaseline::decide(const CycleObservation& now) {
  const double error_k = now.target_degc - room_mean_degc(now.sensors);
  if (!std::isfinite(error_k)) return admissible_setpoint_degc(now.previous_setpoint_degc, site_);
  const double dt_h = hours_since(last_time_, now.time, site_);
  const double slope = last_time_ && dt_h > 0 ? (error_k - last_error_k_) / dt_h : 0.0;
  last_time_ = now.time;
  last_error_k_ = error_k;

  const auto output = [&](double integral_degch) {
    return offset_degc + gains_.kp * error_k + gains_.ki_per_h * integral_degch + gains_.kd_h * slope;
  };
  // A step that would leave the range goes only as far as its limit, and never backwards.
  double step = error_k * dt_h;
  if (gains_.ki_per_h > 0) {
    const double room_up = (site_.action_max_degc - output(integral_degch_)) / gains_.ki_per_h;
    const double room_down = (site_.action_min_degc - output(integral_degch_)) / gains_.ki_per_h;
    step = std::clamp(step, std::min(0.0, room_down), std::max(0.0, room_up));
  }
  integral_degch_ += step;
  return admissible_setpoint_degc(output(integral_degch_), site_);
}

std::string IntegralBaseline::name() const { return fmt::format("integral (Ki {:g}/h)", ki_per_h_); }

double IntegralBaseline::decide(const CycleObservation& now) {
  const double error_k = now.target_degc - room_mean_degc(now.sensors);
  if (!std::isfinite(error_k)) return admissible_setpoint_degc(now.previous_setpoint_degc, site_);
  const double dt_h = hours_since(last_time_, now.time, site_);
  last_time_ = now.time;
  return admissible_setpoint_degc(now.previous_setpoint_degc + ki_per_h_ * error_k * dt_h, site_);
}

double VariedBaseline::decide(const CycleObservation& now) {
  // What was applied holds the last offset, which the integral must not keep.
  double base = integral_.decide(now) - offset_k_;
  if (now.time.day() % schedule_every_days == 0) base = expert_setpoint_degc(site_, now.time);
  SplitMix64 draw(static_cast<std::uint64_t>(now.time.seconds));
  const double setpoint = admissible_setpoint_degc(base + range_k * draw.symmetric(), site_);
  offset_k_ = setpoint - base;
  return setpoint;
}

}  // namespace airside::tools
