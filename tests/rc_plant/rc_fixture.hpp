#pragma once
// What the tests of the RC plant share: a July, the expert's schedule, a run at a rule.

#include <functional>

#include "sim/rc/rc_plant.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "support/default_cycle.hpp"

namespace airside::sim::test {

inline const CivilTime july = civil_midnight(2021, 7, 1);
constexpr double target_degc = 25.25;

inline std::shared_ptr<const Weather> hot_weather() {
  static const auto weather = synthetic_weather(1);
  return weather;
}

inline bool working(CivilTime t) { return t.minute_of_day() >= 7 * 60 && t.minute_of_day() < 19 * 60; }
inline double expert_degc(CivilTime t) { return working(t) ? 20.5 : 25.0; }

inline CivilTime later(CivilTime t, int seconds) { return {t.seconds + seconds}; }

/// Runs `days` in cycles of 18 min; `rule` gives the setpoint at a cycle's start, `look` sees the plant there.
inline void run_days(RcPlant& plant, int days, const std::function<double(const RcPlant&)>& rule,
                     const std::function<void(const RcPlant&)>& look = {}) {
  for (int cycle = 0; cycle < days * cycles_per_day; ++cycle) {
    if (look) look(plant);
    plant.set_setpoint(rule(plant));
    plant.advance_to(later(plant.time(), cycle_s));
  }
}

inline double expert_rule(const RcPlant& plant) { return expert_degc(plant.time()); }

inline double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

}  // namespace airside::sim::test
