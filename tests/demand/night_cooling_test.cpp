// Nights in which the fan cycles to cool.

#include "airside/demand/night_cooling.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "demand/zone_fixture.hpp"

namespace {

using namespace airside;
using namespace airside::demand_test;

constexpr std::int64_t hour_s = 3600;

/// One zone of 24 °C by day and 28 °C at night, and the rows of its AHU.
struct Night {
  ZoneLoads loads;
  NightCooling cooling;
  CivilTime time{20 * hour_s};
  double outdoor_degc = 25;

  Night() {
    loads.reset({});
    loads.note_setpoint(0, 24);
  }
  void row(bool flows, double room_degc, double setpoint_degc = 28) {
    const std::vector<double> room{room_degc}, set{setpoint_degc}, damper{0.3};
    DemandReading at;
    at.time = time;
    at.zones = {room, set, damper};
    at.outdoor_degc = outdoor_degc;
    at.flows = flows;
    cooling.watch(loads, at);
    time = {time.seconds + row_s};
  }
  void held(double room_degc) {
    const std::vector<double> room{room_degc}, set{28}, damper{0.3};
    DemandReading at;
    at.time = time;
    at.zones = {room, set, damper};
    at.outdoor_degc = outdoor_degc;
    at.flows = false;
    at.doubted = true;
    cooling.watch(loads, at);
    time = {time.seconds + row_s};
  }
  void cycle(double room_degc) {
    row(false, room_degc);
    row(true, room_degc - 0.3);
    row(true, room_degc - 1.5);
    row(false, room_degc - 1);
  }
};

TEST(NightCooling, AFanThatCyclesWhileRoomsAreSetBackIsExpectedForTwoDays) {
  Night night;
  night.row(false, 27);
  EXPECT_FALSE(night.cooling.expects(night.time)) << "nothing is known yet";
  night.cycle(28);
  EXPECT_TRUE(night.cooling.expects(night.time)) << "at once";
  night.row(true, 25, 24);
  EXPECT_FALSE(night.cooling.expects(night.time)) << "by day it limits nothing";
  night.row(true, 25);
  EXPECT_TRUE(night.cooling.expects(night.time)) << "the next evening, from its first row on";
  EXPECT_TRUE(night.cooling.expects({night.time.seconds + 47 * hour_s}));
  EXPECT_FALSE(night.cooling.expects({night.time.seconds + 49 * hour_s}));
  EXPECT_FALSE(night.cooling.expects({night.time.seconds - 49 * hour_s})) << "a clock that was set back";
}

TEST(NightCooling, ARowThatIsHeldIsNoRest) {
  Night night;
  night.row(true, 25, 24);
  for (int i = 0; i < 3; ++i) {
    night.row(true, 27);
    night.held(27);
  }
  EXPECT_FALSE(night.cooling.expects(night.time)) << "the fan ran on";
}

TEST(NightCooling, AStartBeforeWorkAndARunAfterItAreNone) {
  Night morning;
  morning.row(false, 27.5);
  morning.row(true, 27.4);
  morning.row(true, 25, 24);
  morning.row(true, 24, 28);  // set back in the evening, the fan still runs
  morning.row(false, 24.5, 28);
  EXPECT_FALSE(morning.cooling.expects(morning.time));
}

TEST(NightCooling, AFanThatStartsFarFromTheSetpointOrUnderColdAirIsNone) {
  Night heats;
  heats.cycle(17);
  EXPECT_FALSE(heats.cooling.expects(heats.time)) << "it cycles to heat";
  Night cold;
  cold.outdoor_degc = 23;
  cold.cycle(28);
  EXPECT_FALSE(cold.cooling.expects(cold.time)) << "outdoor air cools, which costs little";
}

TEST(NightCooling, HeatLeftInTheRoomsHasItsPriceWhereSuchANightWasSeen) {
  Night night;
  night.outdoor_degc = 18;
  night.row(false, 27);
  night.outdoor_degc = 25;
  EXPECT_EQ(night.cooling.stored_heat_share(night.time, 32, 24), 0) << "no night is known";
  night.cycle(28);
  EXPECT_EQ(night.cooling.stored_heat_share(night.time, 32, 24), 1);
  EXPECT_EQ(night.cooling.stored_heat_share(night.time, 28, 24), 0.5);
  EXPECT_EQ(night.cooling.stored_heat_share(night.time, 23, 24), 0) << "outdoor air takes it";
  EXPECT_EQ(night.cooling.stored_heat_share({night.time.seconds + 49 * hour_s}, 32, 24), 0);
}

TEST(NightCooling, WhereNoNightWasFourKelvinColderAllHeatThatIsLeftHasItsPrice) {
  Night night;
  night.outdoor_degc = 24;
  night.row(false, 27);
  EXPECT_TRUE(night.cooling.is_hot(26));
  EXPECT_EQ(night.cooling.stored_heat_share(night.time, 34, 26), 0) << "nobody paid for it at night";
  night.cycle(28);
  EXPECT_TRUE(night.cooling.is_hot(26));
  EXPECT_EQ(night.cooling.stored_heat_share(night.time, 25, 26), 1) << "by night, too";
  EXPECT_FALSE(night.cooling.is_hot(30));
  EXPECT_EQ(night.cooling.stored_heat_share(night.time, 34, 30), 0.5);
}

TEST(NightCooling, AfterSuchANightTheObjectiveLeavesNoHeatInTheRoomsOfAHotDay) {
  FormulaBuilding building;
  BandObjective objective;
  objective.reset({});
  building.live({}, objective, 6);
  const CivilTime noon{6 * seconds_per_day + 43200};
  building.outdoor_degc = 36;
  building.room_degc.fill(23.5);  // below their setpoint, with dampers at their least: warmer air cools less
  for (double& q : building.load_k) q *= 0.2;
  const auto saving = [&] {
    const DemandReading at = building.read(noon);
    return objective.evaluate({}, at, {}, 12).cost_kw - objective.evaluate({}, at, {}, 15).cost_kw;
  };
  const double before = saving();
  ASSERT_GT(before, 0) << "less cooling by the hour";
  building.setpoint_degc = 28;
  building.room_degc.fill(27.5);
  for (int i = -100; i < -96; ++i) {
    DemandReading at = building.read({noon.seconds + i * row_s});
    at.flows = i == -99;
    objective.observe({}, at);
  }
  building.setpoint_degc = 24;
  building.room_degc.fill(23.5);
  EXPECT_LT(saving(), 0.5 * before);
}

TEST(NightCooling, TheObjectiveIsNoWarmerThanTheScheduleThen) {
  FormulaBuilding building;
  BandObjective objective;
  objective.reset({});
  building.live({}, objective, 6);
  building.outdoor_degc = 27;
  for (double& q : building.load_k) q *= 0.3;
  const CivilTime midnight{30 * rows_per_day * row_s};
  const DemandChoice choice{.min_degc = 12, .max_degc = 18, .schedule_degc = 13};
  building.setpoint_degc = 28;
  building.room_degc.fill(27.5);
  const auto row = [&](int i, bool flows) {
    DemandReading at = building.read({midnight.seconds + i * row_s});
    at.flows = flows;
    objective.observe({}, at);
    return objective.choose({}, at, choice).setpoint_degc;
  };
  row(0, false);
  ASSERT_GT(row(1, true), 13.5) << "warm air pays by the hour";
  row(2, false);
  EXPECT_LE(row(3, true), 13);
  EXPECT_GT(row(3 * rows_per_day, true), 13.5) << "forgotten";
}

TEST(NightCooling, OutdoorAirCoolsForNothingByTheColdestThatItWasOfLate) {
  Night night;
  night.outdoor_degc = 30;
  night.row(true, 24, 24);
  EXPECT_EQ(night.cooling.free_cooling_share(24), 0);
  night.outdoor_degc = 22;
  night.row(false, 26);
  EXPECT_NEAR(night.cooling.free_cooling_share(24), 0.5, 1e-6);
  EXPECT_EQ(night.cooling.free_cooling_share(22), 0);
  EXPECT_EQ(night.cooling.free_cooling_share(27), 1);
  night.outdoor_degc = 35;
  for (int row = 0; row < rows_per_day / 2; ++row) night.row(true, 24, 24);
  EXPECT_NEAR(night.cooling.coldest_outdoors_degc(), 23, 1e-3) << "remembered through the day";
  night.outdoor_degc = std::numeric_limits<double>::quiet_NaN();
  night.row(true, 24, 24);
  EXPECT_NEAR(night.cooling.coldest_outdoors_degc(), 23, 1e-3) << "a lost sensor changes nothing";
}

}  // namespace
