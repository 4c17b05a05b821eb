// What each zone asks of the supply air.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "airside/demand/zone_loads.hpp"
#include "support/default_cycle.hpp"

namespace {

using namespace airside;

constexpr DemandSettings settings;

/// A zone that answers by dT = b (q - u) a cycle, under a damper that goes up and down.
ZoneLoads learned_zone(double b, double q, int cycles = 200) {
  ZoneLoads loads;
  loads.reset(settings);
  for (int i = 0; i < cycles; ++i) {
    const double u = q + (i % 4 < 2 ? 0.8 : -0.8);
    loads.update(settings, 0, u, b * (q - u));
  }
  for (int i = 0; i < 10; ++i) loads.note_damper(0, 0.15);
  return loads;
}

TEST(ZoneLoads, FindsLoadAndGainOfAZone) {
  const ZoneLoads loads = learned_zone(0.2, 5);
  EXPECT_NEAR(loads.load_k(0), 5, 0.3);
  EXPECT_NEAR(loads.gain(0), 0.2, 0.06);
}

TEST(ZoneLoads, AirThatIsWarmerThanTheRoomLeavesNoLoadBelowNothing) {
  ZoneLoads loads;
  loads.reset(settings);
  for (const double u : {-1.5, -6.0, -0.2, -3.0}) {
    loads.update(settings, 0, u, 0.3);
    EXPECT_GE(loads.load_k(0), 0) << u;
  }
}

TEST(ZoneLoads, AWarmerSupplyNeedsAWiderDamper) {
  const ZoneLoads loads = learned_zone(0.2, 5);
  const std::vector<double> room{24.0}, set{24.0}, damper{0.5};
  const ZoneSignals zones{room, set, damper};
  double before = 0;
  for (int supply = 12; supply <= 20; ++supply) {
    const ZoneForecast f = loads.forecast(settings, zones, 0, supply, 1, 0);
    EXPECT_GT(f.wanted, before);
    EXPECT_LE(f.damper, 1.0);
    EXPECT_NEAR(f.wanted * (24 - supply), loads.load_k(0), 1e-9);
    before = f.wanted;
  }
}

TEST(ZoneLoads, AZoneAboveItsSetpointWantsMoreThanItsLoad) {
  const ZoneLoads loads = learned_zone(0.2, 5);
  const std::vector<double> set{24.0}, damper{0.5}, cool{24.0}, warm{25.0};
  EXPECT_GT(loads.forecast(settings, {warm, set, damper}, 0, 14, 1, 0).wanted,
            loads.forecast(settings, {cool, set, damper}, 0, 14, 1, 0).wanted);
}

TEST(ZoneLoads, AZoneThatStaysBelowItsSetpointAsksForNothing) {
  const ZoneLoads loads = learned_zone(0.2, 1.4);
  const std::vector<double> room{22.0}, set{24.0}, damper{0.15};
  const ZoneForecast f = loads.forecast(settings, {room, set, damper}, 0, 14, 1, 0);
  EXPECT_EQ(f.wanted, 0);
  EXPECT_NEAR(f.damper, 0.15, 0.01);
}

TEST(ZoneLoads, ASetpointThatUsedToFallIsForeseen) {
  ZoneLoads loads = learned_zone(0.2, 5);
  for (int i = 0; i < cycles_per_day; ++i) {
    loads.note_profile({i * cycle_s}, 1, i < 24 ? 28.0 : 24.0, i < 24);  // until 07:12
  }
  EXPECT_DOUBLE_EQ(loads.setpoint_fall_k({18 * cycle_s}, 28), 0);
  EXPECT_DOUBLE_EQ(loads.setpoint_fall_k({19 * cycle_s}, 28), -4);
  EXPECT_DOUBLE_EQ(loads.setpoint_fall_k({30 * cycle_s}, 24), 0);
}

TEST(ZoneLoads, AZoneThatIsNeverSetBackKeepsItsSetpointWhereOthersFall) {
  ZoneLoads loads = learned_zone(0.2, 5);
  EXPECT_DOUBLE_EQ(loads.expected_setpoint_degc(0, 28, -3), 28) << "no setpoint was seen yet";
  loads.note_setpoint(0, 24);
  EXPECT_DOUBLE_EQ(loads.expected_setpoint_degc(0, 28, -3), 25);
  EXPECT_DOUBLE_EQ(loads.expected_setpoint_degc(0, 28, -9), 24);
  EXPECT_DOUBLE_EQ(loads.expected_setpoint_degc(0, 24, -3), 24);
  const std::vector<double> room{24.0}, set{24.0}, damper{0.5};
  const ZoneSignals zones{room, set, damper};
  EXPECT_DOUBLE_EQ(loads.forecast(settings, zones, 0, 14, 1, -3).wanted,
                   loads.forecast(settings, zones, 0, 14, 1, 0).wanted);
}

TEST(ZoneLoads, ADayOffSaysNothingOfAWorkingDaysLoads) {
  ZoneLoads loads = learned_zone(0.2, 5);
  const CivilTime t{30 * cycle_s}, next{31 * cycle_s};
  loads.note_profile(t, 1, 24, false);
  loads.note_profile(next, 1, 24, false);
  EXPECT_DOUBLE_EQ(loads.growth(t), 1);
  for (int i = 0; i < 20; ++i) loads.update(settings, 0, 2.5, 0);  // half the load
  loads.note_profile(next, 1, 28, true);
  EXPECT_DOUBLE_EQ(loads.growth(t), 1);
  loads.note_profile(next, 1, 24, false);
  EXPECT_LT(loads.growth(t), 0.95);
}

TEST(ZoneLoads, AZoneThatTheColdestAirDoesNotCoolCountsLess) {
  ZoneLoads loads = learned_zone(0.2, 5);
  const std::vector<double> room{27.0}, set{24.0}, damper{1.0};
  const ZoneSignals zones{room, set, damper};
  for (int row = 0; row < 40; ++row) loads.note_reach(settings, zones, 0, true);  // 4 h
  EXPECT_NEAR(loads.weight(0), 0.5, 0.02);
  for (int row = 0; row < rows_per_day; ++row) loads.note_reach(settings, zones, 0, false);
  EXPECT_DOUBLE_EQ(loads.weight(0), 1);
}

TEST(ZoneLoads, InSetbackNoZoneIsThoughtToHeat) {
  ZoneLoads loads = learned_zone(0.2, 5);
  loads.note_setpoint(0, 24);
  EXPECT_TRUE(loads.is_set_back(0, 28));
  EXPECT_FALSE(loads.is_set_back(0, 24));
  EXPECT_EQ(loads.heating_share(0, 23, 28), 0);
  EXPECT_EQ(loads.heating_share(0, 21, 24), 1);
}

TEST(ZoneLoads, AZoneHeatsOnlyNearWhereItWasSeenToBeHeld) {
  ZoneLoads loads = learned_zone(0.2, 5);
  loads.note_setpoint(0, 24);
  EXPECT_EQ(loads.heating_share(0, 21.5, 24), 1) << "never seen to be held: by its cooling setpoint";
  loads.note_held(0, 20.0, 0.3, 0.15, 24);  // warms up
  loads.note_held(0, 20.0, 0.0, 0.60, 24);  // its damper is open
  loads.note_held(0, 20.0, 0.0, 0.15, 28);  // set back
  EXPECT_EQ(loads.heating_share(0, 21.5, 24), 1);
  loads.note_held(0, 21.0, 0.02, 0.15, 24);
  EXPECT_EQ(loads.heating_share(0, 21.0, 24), 1);
  EXPECT_EQ(loads.heating_share(0, 21.5, 24), 0) << "floats between its setpoints";
  for (int i = 0; i < 2 * cycles_per_day; ++i) loads.note_held(0, 23.0, 0.3, 0.15, 24);
  EXPECT_EQ(loads.heating_share(0, 21.5, 24), 1) << "forgotten after two days of running fan";
}

TEST(ZoneLoads, AZoneThatIsHardlyCooledAtAllIsNotHeatedForThat) {
  ZoneLoads loads = learned_zone(0.2, 5);
  loads.note_setpoint(0, 30);
  EXPECT_EQ(loads.heating_share(0, 24, 30), 0);
  EXPECT_EQ(loads.heating_share(0, 22, 30), 1);
}

/// A zone at rest between its setpoints, whose thermostat heats to 21.
ZoneLoads zone_with_heating(double q) {
  ZoneLoads loads = learned_zone(0.2, q);
  loads.note_setpoint(0, 24);
  loads.note_heating(0, 21, 24);
  loads.note_free_load(0, 0);
  return loads;
}

TEST(ZoneLoads, WhereTheHeatingSetpointIsShownAZoneHeatsThere) {
  const ZoneLoads loads = zone_with_heating(1);
  EXPECT_EQ(loads.heating_share(0, 21.0, 24), 1);
  EXPECT_EQ(loads.heating_share(0, 21.5, 24), 0);
  ZoneLoads hidden = learned_zone(0.2, 1);
  hidden.note_setpoint(0, 24);
  EXPECT_EQ(hidden.heating_share(0, 21.5, 24), 1) << "by its cooling setpoint, where no point shows the other";
}

TEST(ZoneLoads, AHeatingSetpointAboveTheCoolingOneIsNotBelieved) {
  const std::vector<double> room{22.0, 22.0}, set{24.0, 24.0}, damper{0.3, 0.3}, heats{24.0, 24.1};
  const ZoneSignals zones{room, set, damper, heats};
  EXPECT_EQ(zone_heating_degc(zones, 0), 24.0);
  EXPECT_TRUE(std::isnan(zone_heating_degc(zones, 1)));
  EXPECT_TRUE(std::isnan(zone_heating_degc({room, set, damper}, 0))) << "no point shows it";
}

TEST(ZoneLoads, AHeatingSetpointIsLearnedWhileTheZoneIsNotSetBack) {
  ZoneLoads loads = learned_zone(0.2, 1);
  loads.note_setpoint(0, 24);
  loads.note_heating(0, 21, 24);
  for (int row = 0; row < rows_per_day; ++row) loads.note_heating(0, row % 2 == 0 ? 16 : 25, 28);
  EXPECT_EQ(loads.heating_share(0, 21.0, 24), 1) << "remembered over the night";
  EXPECT_EQ(loads.heating_share(0, 21.5, 24), 0) << "a wrong one of the night is not";
  loads.note_heating(0, 23.9, 24);  // wrong, and believed
  EXPECT_EQ(loads.heating_share(0, 23.9, 24), 1);
  for (int row = 0; row < 3 * rows_per_day; ++row) loads.note_heating(0, 21, 24);
  EXPECT_EQ(loads.heating_share(0, 21.5, 24), 0) << "forgotten within three days";
}

TEST(ZoneLoads, ColderAirHeatsOnlyAZoneThatFallsToWhereItHeats) {
  // With a load of 2 K a damper at 0.3 floats at A + 6.7: above 21 it takes no heat.
  const ZoneLoads loads = zone_with_heating(2);
  const std::vector<double> room{22.0}, set{24.0}, damper{0.3}, heats{21.0};
  const ZoneSignals zones{room, set, damper, heats};
  EXPECT_EQ(loads.heat_k(zones, 0, 16, 0.3, 1), 0);
  EXPECT_NEAR(loads.heat_k(zones, 0, 12, 0.3, 1), 0.3 * (21 - 12) - loads.load_k(0), 1e-9);
}

TEST(ZoneLoads, OfAHeatedZoneTheLastFreeLoadIsBelievedLessAndLess) {
  ZoneLoads loads = zone_with_heating(2);
  const std::vector<double> room{21.0}, set{24.0}, damper{0.3}, heats{21.0};
  const ZoneSignals zones{room, set, damper, heats};
  const double at_once = loads.heat_k(zones, 0, 14, 0.3, 1);
  for (int i = 0; i < 80; ++i) loads.note_free_load(0, 1);
  EXPECT_GT(loads.heat_k(zones, 0, 14, 0.3, 1), at_once + 1);
  EXPECT_NEAR(loads.heat_k(zones, 0, 14, 0.3, 1), 0.3 * (21 - 14), 0.01);
}

TEST(ZoneLoads, HeatThatAZoneDidNotTakeForThreeDaysCountsOnlyWhereNightsCool) {
  ZoneLoads loads = zone_with_heating(1);
  const std::vector<double> room{24.0}, set{24.0}, damper{0.3}, heats{21.0};
  const ZoneSignals zones{room, set, damper, heats};
  const double heat_k = loads.heat_k(zones, 0, 12, 0.3, 1);
  EXPECT_GT(heat_k, 1);
  EXPECT_GT(loads.heat_k(zones, 0, 12, 0.3, 0), 0.99 * heat_k) << "not known yet";
  for (int i = 0; i < 2 * cycles_per_day; ++i) loads.note_free_load(0, 0);
  EXPECT_NEAR(loads.heat_k(zones, 0, 12, 0.3, 0), heat_k / 3, 0.01 * heat_k);
  for (int i = 0; i < 2 * cycles_per_day; ++i) loads.note_free_load(0, 0);
  EXPECT_EQ(loads.heat_k(zones, 0, 12, 0.3, 0), 0);
  EXPECT_NEAR(loads.heat_k(zones, 0, 12, 0.3, 0.5), heat_k / 2, 1e-9);
  EXPECT_NEAR(loads.heat_k(zones, 0, 12, 0.3, 1), heat_k, 1e-9);
  loads.note_free_load(0, 1);
  EXPECT_GT(loads.heat_k(zones, 0, 12, 0.3, 0), 0.99 * heat_k) << "once it is heated again";
}

TEST(ZoneLoads, AZoneThatIsTooColdWantsWarmerAir) {
  const ZoneLoads loads = zone_with_heating(1);
  const std::vector<double> cold{20.0}, held{21.0}, set{24.0}, damper{0.15}, heats{21.0};
  const ZoneSignals zones{cold, set, damper, heats};
  const double colder = loads.forecast(settings, zones, 0, 13, 1, 0).short_k;
  const double warmer = loads.forecast(settings, zones, 0, 17, 1, 0).short_k;
  EXPECT_GT(colder, warmer);
  EXPECT_GT(warmer, 0);
  EXPECT_EQ(loads.forecast(settings, {held, set, damper, heats}, 0, 13, 1, 0).short_k, 0);
  EXPECT_EQ(loads.forecast(settings, {cold, set, damper}, 0, 13, 1, 0).short_k, 0) << "no point shows where it heats";
}

TEST(ZoneLoads, AZoneThatTheWarmestAirDoesNotWarmCountsLess) {
  ZoneLoads loads = zone_with_heating(1);
  const std::vector<double> room{18.0}, set{24.0}, damper{0.15}, heats{21.0};
  const ZoneSignals zones{room, set, damper, heats};
  for (int i = 0; i < 40; ++i) loads.note_cold_reach(settings, zones, 0, true);
  EXPECT_NEAR(loads.cold_weight(0), 0.5, 0.02);
  for (int i = 0; i < rows_per_day; ++i) loads.note_cold_reach(settings, zones, 0, false);
  EXPECT_NEAR(loads.cold_weight(0), 1, 1e-9);
}

}  // namespace
