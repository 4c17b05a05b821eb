// The room whose boxes modulate behaves as such rooms do.

#include <gtest/gtest.h>

#include "hal/text/input_error.hpp"
#include "sim/rc/modulating_plant.hpp"
#include "sim/weather/synthetic_weather.hpp"

namespace {

using namespace airside;
using namespace airside::sim;

ModulatingPlant plant_of(const char* scenario, int month, std::uint64_t seed = 1) {
  const ModulatingRoom room = modulating_room(scenario, seed);
  return {room, synthetic_weather(seed + 77, room.climate), civil_midnight(2021, month, 1), seed};
}

struct Week {
  ModulatingEnergy energy;
  ZoneComfort comfort;
};

Week week_at(const char* scenario, int month, double setpoint_degc) {
  ModulatingPlant plant = plant_of(scenario, month);
  plant.set_setpoint(setpoint_degc);
  plant.advance_to({plant.time().seconds + 7 * seconds_per_day});
  return {plant.energy(), plant.comfort()};
}

TEST(ModulatingPlant, WarmerAirTakesMoreFlowAndOpensDampers) {
  const Week cold = week_at("mild", 7, 12), warm = week_at("mild", 7, 16);
  EXPECT_GT(warm.energy.fan_kwh, 1.5 * cold.energy.fan_kwh);
  EXPECT_GT(warm.comfort.saturated_h, cold.comfort.saturated_h);
  EXPECT_GT(warm.comfort.above_degch, cold.comfort.above_degch);
}

TEST(ModulatingPlant, AnEconomizerMakesWarmerAirCheaperToCoolInMildWeather) {
  EXPECT_LT(week_at("mild", 10, 15).energy.cooling_kwh, 0.8 * week_at("mild", 10, 12).energy.cooling_kwh);
}

TEST(ModulatingPlant, AHighMinimumFlowIsReheated) {
  const Week cold = week_at("reheat", 4, 12), warm = week_at("reheat", 4, 15);
  EXPECT_GT(cold.energy.reheat_kwh, 1.3 * warm.energy.reheat_kwh);
  EXPECT_EQ(week_at("humid", 7, 12).energy.reheat_kwh, 0);
}

TEST(ModulatingPlant, BoxesHoldTheirZonesWhereTheAirSuffices) {
  ModulatingPlant plant = plant_of("mild", 7);
  plant.set_setpoint(12);
  plant.advance_to({plant.time().seconds + 3 * seconds_per_day + 11 * 3600});
  for (std::size_t z = 0; z < plant.zone_temp_degc().size(); ++z) {
    EXPECT_NEAR(plant.zone_temp_degc()[z], plant.boxes().zone_setpoint_degc[z], 1.5) << z;
    EXPECT_GE(plant.boxes().damper[z], 0.14);
    EXPECT_LE(plant.boxes().damper[z], 1.0);
  }
  EXPECT_GT(plant.boxes().supply_flow_m3_s, 0.2);
  EXPECT_EQ(plant.boxes().occupied, 1);
}

TEST(ModulatingPlant, AtNightTheFanRests) {
  ModulatingPlant plant = plant_of("mild", 7);
  plant.advance_to({plant.time().seconds + seconds_per_day + 2 * 3600});
  EXPECT_EQ(plant.boxes().fan_runs, 0);
  EXPECT_EQ(plant.boxes().supply_flow_m3_s, 0);
  EXPECT_EQ(plant.sensors().power_kw[0], 0);
}

TEST(ModulatingPlant, OneSeedIsOneRunAndACopyIsABranch) {
  ModulatingPlant a = plant_of("reheat", 4), b = plant_of("reheat", 4);
  const CivilTime then{a.time().seconds + seconds_per_day};
  a.advance_to(then);
  b.advance_to({then.seconds - 43200});
  ModulatingPlant branch = b;
  branch.set_setpoint(18);
  branch.advance_to(then);
  b.advance_to(then);
  EXPECT_EQ(a.energy().total_kwh(), b.energy().total_kwh());
  EXPECT_EQ(a.sensors().room_temp_degc, b.sensors().room_temp_degc);
  EXPECT_NE(branch.energy().fan_kwh, b.energy().fan_kwh);
}

TEST(ModulatingPlant, SeedsAreOtherBuildings) {
  EXPECT_NE(modulating_room("mild", 1).air.flow_max_m3_s, modulating_room("mild", 2).air.flow_max_m3_s);
  EXPECT_EQ(modulating_room("mild", 0).air.cooling_degc.front(), 24.0);
}

TEST(ModulatingPlant, AnUnknownScenarioIsRefused) { EXPECT_THROW((void)modulating_room("attic", 1), hal::InputError); }

}  // namespace
