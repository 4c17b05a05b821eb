// Guideline 36 as written, with dampers.

#include <gtest/gtest.h>

#include <vector>

#include "airside/demand/zone_guideline36.hpp"

namespace {

using namespace airside;

struct Zones {
  std::vector<double> room, set, damper;
  explicit Zones(std::size_t n) : room(n, 24.0), set(n, 24.0), damper(n, 0.5) {}
  ZoneSignals signals() const { return {room, set, damper}; }
};

Guideline36Settings every_two_minutes() {
  Guideline36Settings s = guideline36_as_written(18);
  s.period_s = 120;
  return s;
}

double run(ZoneGuideline36& g, const Zones& zones, int steps, double outdoor = 10,
           std::span<const double> importance = {}) {
  double setpoint = 0;
  for (int i = 0; i < steps; ++i)
    setpoint = g.setpoint_degc(every_two_minutes(), zones.signals(), outdoor, true, importance);
  return setpoint;
}

TEST(ZoneGuideline36, HoldsSp0ForTenMinutesThenAnswersOpenDampers) {
  ZoneGuideline36 g;
  Zones zones(4);
  zones.damper.assign(4, 0.97);
  EXPECT_DOUBLE_EQ(run(g, zones, 5), 18.0);
  EXPECT_DOUBLE_EQ(run(g, zones, 1), 18.0 - 0.4);  // 4 requests, 2 ignored, 0.2 K each
  EXPECT_DOUBLE_EQ(g.requests(), 4);
}

TEST(ZoneGuideline36, NeverGoesDownByMoreThanItsLargestStep) {
  ZoneGuideline36 g;
  Zones zones(10);
  zones.damper.assign(10, 1.0);
  (void)run(g, zones, 5);
  EXPECT_NEAR(run(g, zones, 1), 18.0 - 0.6, 1e-12);
}

TEST(ZoneGuideline36, ADamperAsksUntilBelow85Percent) {
  ZoneGuideline36 g;
  Zones zones(1);
  zones.damper[0] = 0.96;
  (void)run(g, zones, 1);
  zones.damper[0] = 0.90;
  (void)run(g, zones, 1);
  EXPECT_DOUBLE_EQ(g.requests(), 1);
  zones.damper[0] = 0.84;
  (void)run(g, zones, 1);
  EXPECT_DOUBLE_EQ(g.requests(), 0);
  zones.damper[0] = 0.90;
  (void)run(g, zones, 1);
  EXPECT_DOUBLE_EQ(g.requests(), 0);
}

TEST(ZoneGuideline36, AWarmZoneAsksTwiceAndThreeTimes) {
  ZoneGuideline36 g;
  Zones zones(1);
  zones.room[0] = 26.1;
  (void)run(g, zones, 2);
  EXPECT_DOUBLE_EQ(g.requests(), 2);
  zones.room[0] = 27.1;
  (void)run(g, zones, 2);
  EXPECT_DOUBLE_EQ(g.requests(), 3);
}

TEST(ZoneGuideline36, AChangedSetpointSilencesTheTemperatureForAWhile) {
  ZoneGuideline36 g;
  Zones zones(1);
  (void)run(g, zones, 1);
  zones.set[0] = 21.0;  // 3 K: 27 min
  (void)run(g, zones, 10);
  EXPECT_DOUBLE_EQ(g.requests(), 0);
  (void)run(g, zones, 10);
  EXPECT_DOUBLE_EQ(g.requests(), 3);
}

TEST(ZoneGuideline36, ImportanceMultipliesRequests) {
  ZoneGuideline36 g;
  Zones zones(2);
  zones.damper.assign(2, 1.0);
  const std::vector<double> importance{0.0, 2.0};
  (void)run(g, zones, 1, 10, importance);
  EXPECT_DOUBLE_EQ(g.requests(), 2);
}

TEST(ZoneGuideline36, AWarmDayPinsTheMinimum) {
  ZoneGuideline36 g;
  const Zones zones(2);
  EXPECT_DOUBLE_EQ(run(g, zones, 3, 25), 12.0);
  EXPECT_NEAR(run(g, zones, 1, 18.35), 15.0, 1e-9);
}

TEST(ZoneGuideline36, StartsAnewAfterTheFanRested) {
  ZoneGuideline36 g;
  Zones zones(4);
  zones.damper.assign(4, 1.0);
  EXPECT_LT(run(g, zones, 20), 15);
  (void)g.setpoint_degc(every_two_minutes(), zones.signals(), 10, false);
  EXPECT_DOUBLE_EQ(run(g, zones, 1), 18.0);
}

TEST(ZoneGuideline36, AZoneWithoutSignalsAsksForNothing) {
  ZoneGuideline36 g;
  Zones zones(2);
  zones.room.assign(2, std::nan(""));
  (void)run(g, zones, 3);
  EXPECT_DOUBLE_EQ(g.requests(), 0);
}

}  // namespace
