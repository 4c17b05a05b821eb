// What each zone asks of the supply air.

#include <gtest/gtest.h>

#include <vector>

#include "airside/demand/zone_loads.hpp"

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
    loads.note_profile({i * cycle_s}, 1, i < 24 ? 28.0 : 24.0);  // until 07:12
  }
  EXPECT_DOUBLE_EQ(loads.setpoint_fall_k({20 * cycle_s}, 28), 0);
  EXPECT_DOUBLE_EQ(loads.setpoint_fall_k({22 * cycle_s}, 28), -4);
  EXPECT_DOUBLE_EQ(loads.setpoint_fall_k({30 * cycle_s}, 24), 0);
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

}  // namespace
