#pragma once
// The expert's schedule: what the AHU did before, and what it falls back to; and when its fan runs.

#include <cmath>

#include "airside/civil_time.hpp"
#include "airside/settings.hpp"

namespace airside {

/// Whether standard time t lies in working hours.  work_start <= local time of day < work_end, on working days.
constexpr bool in_working_hours(const ControllerSettings& s, CivilTime standard_time) {
  const CivilTime t = local_time(s, standard_time);
  if (s.weekday_only != 0 && t.weekday() >= 5) return false;
  const double h = t.second_of_day() / 3600.0;
  return h >= s.work_start_h && h < s.work_end_h;
}

/// Whether air flows at standard time t: what a point shows (1, 0, or NaN: there is none), else the fan's schedule.
inline bool air_flows(const ControllerSettings& s, CivilTime standard_time, double shown) {
  if (std::isfinite(shown)) return shown > 0.5;
  const CivilTime t = local_time(s, standard_time);
  if (s.fan_weekday_only != 0 && t.weekday() >= 5) return false;
  const double h = t.second_of_day() / 3600.0;
  return h >= s.fan_start_h && h < s.fan_end_h;
}

/// The schedule's setpoint, degC.  Source: docs/method.md 6.3, open point 19.
constexpr double expert_setpoint_degc(const ControllerSettings& s, CivilTime t) {
  return in_working_hours(s, t) ? s.expert_work_degc : s.expert_off_degc;
}

}  // namespace airside
