#pragma once
// What counts as discomfort of a zone: one definition for studies, reports and the operator's page.

namespace airside {

constexpr double comfort_slack_k = 0.5;  ///< beside a setpoint, which a thermostat's own swing takes

/// K by which a zone is above its cooling setpoint and the slack; 0 where either is NaN.
inline double too_warm_k(double room_degc, double cooling_degc) {
  const double k = room_degc - cooling_degc - comfort_slack_k;
  return k > 0 ? k : 0;
}

/// K by which it is below its heating setpoint and the slack; 0 where either is NaN.
inline double too_cold_k(double room_degc, double heating_degc) {
  const double k = heating_degc - comfort_slack_k - room_degc;
  return k > 0 ? k : 0;
}

}  // namespace airside
