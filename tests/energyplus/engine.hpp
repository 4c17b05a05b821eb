#pragma once
// What the tests of this folder share: the skip, short options, one logged day.

#include <gtest/gtest.h>

#include <numeric>
#include <string>
#include <vector>

#include "sim/energyplus/install.hpp"
#include "sim/energyplus/plant.hpp"
#include "support/default_cycle.hpp"

#define AIRSIDE_NEEDS_ENGINE()                                                                  \
  if (!airside::sim::have_energyplus())                                                         \
  GTEST_SKIP() << "\n*** EnergyPlus is not installed: run tools/setup, or set AIRSIDE_VENV or " \
                  "AIRSIDE_ENERGYPLUS. This test checked nothing. ***"

namespace airside::sim {

inline EnergyPlusOptions one_day(const std::string& room = "twin") {
  EnergyPlusOptions options = energyplus_room(room);
  options.days = 1;
  return options;
}

inline double schedule_degc(CivilTime t) {
  const int minute = t.minute_of_day();
  return minute >= 7 * 60 && minute < 19 * 60 ? 20.5 : 25.0;
}

/// Every sensor after every cycle of a run on the expert schedule.
inline std::vector<double> log_of(EnergyPlusPlant& plant) {
  std::vector<double> log;
  while (plant.time() < plant.end()) {
    plant.set_setpoint(schedule_degc(plant.time()));
    plant.advance_to({plant.time().seconds + cycle_s});
    const Sensors& s = plant.sensors();
    for (const auto* group : {&s.room_temp_degc, &s.fcu_temp_degc, &s.vav_on, &s.fcu_on, &s.power_kw})
      log.insert(log.end(), group->begin(), group->end());
    log.insert(log.end(), {s.mau_temp_degc, s.outdoor_temp_degc, s.rain, s.supply_temp_degc, s.setpoint_degc});
  }
  return log;
}

inline std::vector<double> log_of(const EnergyPlusOptions& options) {
  EnergyPlusPlant plant(options);
  return log_of(plant);
}

/// Mean over the scored cycles (07:12 to 18:54 starts) of |mean room temperature - target| and of the temperature.
struct WorkingHours {
  double mean_degc = 0, dae_k = 0;
};

template <class Setpoint>
WorkingHours working_hours(EnergyPlusPlant& plant, Setpoint setpoint, double target_degc = 25.25) {
  WorkingHours result;
  int cycles = 0;
  while (plant.time() < plant.end()) {
    const int cycle = cycle_of_day(plant.time());
    plant.set_setpoint(setpoint(plant.time()));
    plant.advance_to({plant.time().seconds + cycle_s});
    if (cycle < 24 || cycle > 63) continue;
    const double mean = plant.true_mean_room_temp_degc();
    result.mean_degc += mean;
    result.dae_k += std::abs(mean - target_degc);
    ++cycles;
  }
  result.mean_degc /= cycles;
  result.dae_k /= cycles;
  return result;
}

/// The message of the exception that `act` throws, or empty.
template <class Act>
std::string message_of(Act act) {
  try {
    act();
  } catch (const std::exception& error) {
    return error.what();
  }
  return {};
}

}  // namespace airside::sim
