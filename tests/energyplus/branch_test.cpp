#include <cmath>

#include "energyplus/engine.hpp"
#include "hal/text/input_error.hpp"
#include "support/default_cycle.hpp"

namespace airside::sim {
namespace {

TEST(EnergyPlusBranch, LeavesTheMainRunBitIdentical) {
  AIRSIDE_NEEDS_ENGINE();
  EnergyPlusPlant plant(one_day());
  std::vector<double> log;
  const std::vector<double> alone = log_of(one_day());
  EnergyPlusPlant branched(one_day());
  while (branched.time() < branched.end()) {
    if (cycle_of_day(branched.time()) % 8 == 0) {
      const CivilTime far{std::min(branched.time().seconds + 4 * cycle_s, branched.end().seconds)};
      branched.branch_mean_room_temp_degc(20.0, far);
      branched.branch_mean_room_temp_degc(26.0, {branched.time().seconds + cycle_s});
    }
    branched.set_setpoint(schedule_degc(branched.time()));
    branched.advance_to({branched.time().seconds + cycle_s});
    const Sensors& s = branched.sensors();
    for (const auto* group : {&s.room_temp_degc, &s.fcu_temp_degc, &s.vav_on, &s.fcu_on, &s.power_kw})
      log.insert(log.end(), group->begin(), group->end());
    log.insert(log.end(), {s.mau_temp_degc, s.outdoor_temp_degc, s.rain, s.supply_temp_degc, s.setpoint_degc});
  }
  EXPECT_EQ(alone, log);
}

TEST(EnergyPlusBranch, TellsWhatTheMainRunThenDoes) {
  AIRSIDE_NEEDS_ENGINE();
  EnergyPlusPlant plant(one_day());
  for (int cycle = 0; cycle < 60; ++cycle) {
    const CivilTime until{plant.time().seconds + cycle_s};
    const double setpoint = 20.0 + cycle % 6;
    const double predicted = plant.branch_mean_room_temp_degc(setpoint, until);
    plant.set_setpoint(setpoint);
    plant.advance_to(until);
    ASSERT_EQ(predicted, plant.true_mean_room_temp_degc()) << cycle;
  }
}

TEST(EnergyPlusBranch, IsWarmerWithAWarmerSetpoint) {
  AIRSIDE_NEEDS_ENGINE();
  EnergyPlusPlant plant(one_day());
  plant.advance_to({plant.time().seconds + 12 * 3600});
  const CivilTime until{plant.time().seconds + cycle_s};
  EXPECT_GT(plant.branch_mean_room_temp_degc(24, until), plant.branch_mean_room_temp_degc(22, until) + 0.5);
}

TEST(EnergyPlusBranch, FindsTheSetpointThatHitsTheTarget) {
  AIRSIDE_NEEDS_ENGINE();
  EnergyPlusPlant plant(one_day());
  const WorkingHours hours =
      working_hours(plant, [&plant](CivilTime) { return full_forecast_setpoint(plant, 25.25, 18, 28); });
  EXPECT_LT(hours.dae_k, 0.01);
}

TEST(EnergyPlusBranch, StaysWithinTheLimitsOfTheSearch) {
  AIRSIDE_NEEDS_ENGINE();
  EnergyPlusPlant plant(one_day());
  plant.advance_to({plant.time().seconds + 12 * 3600});
  EXPECT_EQ(full_forecast_setpoint(plant, 10.0, 20, 26), 20);
  EXPECT_EQ(full_forecast_setpoint(plant, 40.0, 20, 26), 26);
}

TEST(EnergyPlusBranch, RefusesATimeAfterTheEnd) {
  AIRSIDE_NEEDS_ENGINE();
  EnergyPlusPlant plant(one_day());
  EXPECT_THROW(plant.branch_mean_room_temp_degc(22, {plant.end().seconds + 180}), hal::InputError);
}

}  // namespace
}  // namespace airside::sim
