// Trim and respond, step by step, against the table of the guideline.

#include <gtest/gtest.h>

#include <cmath>

#include "airside/presets.hpp"
#include "baselines/first_order_plant.hpp"
#include "tools/baselines/guideline36.hpp"

namespace airside::tools {
namespace {

const ControllerSettings g36_site = paper_settings();

CycleObservation at(double hour, double room_degc, double outdoor_degc = 10) {
  FirstOrderPlant plant(0.0);
  plant.set_mean_degc(room_degc);
  CycleObservation now = plant.observe();
  now.time.seconds = 4 * 86400 + std::lround(hour * 3600);
  now.sensors.room_temp_degc.assign(5, room_degc);
  now.sensors.outdoor_temp_degc = outdoor_degc;
  return now;
}

TEST(Guideline36, HoldsSp0ThroughTheDelayThenRespondsAtMostByItsLimit) {
  Guideline36Baseline g36(g36_site, guideline36_as_written(), "g36");
  EXPECT_NEAR(g36.decide(at(7.0, 29.0)), 16.0, 1e-9);  // 5 zones x 3 requests
  EXPECT_EQ(g36.requests(), 15);
  EXPECT_NEAR(g36.decide(at(7.1, 29.0)), 16.0, 1e-9);  // 6 of the 10 minutes
  EXPECT_NEAR(g36.decide(at(7.2, 29.0)), 15.4, 1e-9);  // 2 minutes after the delay: one step of -0.6
  EXPECT_NEAR(g36.decide(at(7.3, 29.0)), 13.6, 1e-9);  // three steps
  EXPECT_NEAR(g36.decide(at(7.4, 29.0)), 12.0, 1e-9);  // stops at the minimum
}

TEST(Guideline36, RespondsInProportionToRequestsAboveTheIgnoredOnes) {
  Guideline36Baseline g36(g36_site, guideline36_as_written(), "g36");
  CycleObservation now = at(7.0, 25.0);
  now.sensors.room_temp_degc = {27.3, 27.3, 25.0, 25.0, 25.0};  // 2 K above: 2 requests each, 2 above I
  for (int i = 0; i < 3; ++i) {
    now.time.seconds = 4 * 86400 + 7 * 3600 + i * row_s;
    g36.decide(now);
  }
  EXPECT_EQ(g36.requests(), 4);
  now.time.seconds += row_s;
  EXPECT_NEAR(g36.decide(now), 16.0 - 4 * 0.4, 1e-9);
}

TEST(Guideline36, TrimsBackTowardItsMaximumWhenNobodyAsks) {
  Guideline36Baseline g36(g36_site, guideline36_as_written(), "g36");
  for (int i = 0; i < 10; ++i) g36.decide(at(7.0 + 0.1 * i, 29.0));
  const double low = g36.decide(at(8.0, 23.0));
  EXPECT_NEAR(low, 12.3, 1e-9);  // either trim or respond: +0.1 a step, three steps a row
  for (int i = 1; i < 60; ++i) g36.decide(at(8.0 + 0.1 * i, 25.0));
  EXPECT_NEAR(g36.decide(at(14.0, 25.0)), 16.0, 1e-9);
}

TEST(Guideline36, OutdoorAirResetPinsTheMinimumOnAWarmDay) {
  Guideline36Baseline g36(g36_site, guideline36_as_written(18), "g36");
  EXPECT_NEAR(g36.decide(at(9.0, 25.0, 15.6)), 18.0, 1e-9);
  EXPECT_NEAR(g36.decide(at(9.1, 25.0, 30.0)), 12.0, 1e-9);
  EXPECT_NEAR(g36.decide(at(9.2, 25.0, 18.35)), 15.0, 1e-9);  // half way
}

TEST(Guideline36, ReleasesACoolingLoopOnlyBelowEightyFivePercent) {
  Guideline36Settings settings = guideline36_on_site(g36_site);
  settings.loop_integral_per_kh = 0;
  settings.loop_gain_per_k = 0.5;
  Guideline36Baseline g36(g36_site, settings, "g36");
  g36.decide(at(9.0, 25.25 + 1.8));  // 90 %: not yet
  EXPECT_EQ(g36.requests(), 0);
  g36.decide(at(9.1, 25.25 + 1.92));  // 96 %
  EXPECT_EQ(g36.requests(), 5);
  g36.decide(at(9.2, 25.25 + 1.8));  // 90 %: still
  EXPECT_EQ(g36.requests(), 5);
  g36.decide(at(9.3, 25.25 + 1.6));  // 80 %: released
  EXPECT_EQ(g36.requests(), 0);
}

TEST(Guideline36, AShutVavAsksForNothingWithEitherProxy) {
  for (const CoolingLoop loop : {CoolingLoop::zone_pi, CoolingLoop::airflow}) {
    Guideline36Settings settings = guideline36_on_site(g36_site);
    settings.loop = loop;
    Guideline36Baseline g36(g36_site, settings, "g36");
    CycleObservation now = at(9.0, 29.0);
    now.sensors.vav_on = {1, 0, 0, 0, 0};
    g36.decide(now);
    EXPECT_EQ(g36.requests(), 3);
  }
}

TEST(Guideline36, GoesBackToTheNightSetpointAfterWorkAndCoolsDownBeforeIt) {
  Guideline36Baseline g36(g36_site, guideline36_on_site(g36_site), "g36");
  EXPECT_NEAR(g36.decide(at(3.0, 27.0)), 25.0, 1e-9);
  EXPECT_NEAR(g36.decide(at(6.5, 27.0)), 20.0, 1e-9);  // cool-down
  EXPECT_NEAR(g36.decide(at(6.6, 25.0)), 25.0, 1e-9);  // reached
  g36.decide(at(7.0, 29.0));
  for (int i = 1; i < 40; ++i) g36.decide(at(7.0 + 0.1 * i, 29.0));
  EXPECT_NEAR(g36.decide(at(11.0, 29.0)), 20.0, 1e-9);
  EXPECT_NEAR(g36.decide(at(19.0, 29.0)), 25.0, 1e-9);
  EXPECT_NEAR(g36.decide(at(24 + 7.0, 25.0)), 25.0, 1e-9);  // starts anew at SP0
}

TEST(Guideline36, OnTheSiteRangeHoldsAHotRoomNearItsCoolingSetpoint) {
  Guideline36Baseline g36(g36_site, guideline36_on_site(g36_site), "g36");
  FirstOrderPlant plant(0.5);
  double warmest = 0;
  for (int i = 0; i < 3 * rows_per_day; ++i) {
    plant.set_setpoint(g36.decide(plant.observe()));
    const double hour = plant.time().second_of_day() / 3600.0;
    if (i >= rows_per_day && hour > 9 && hour < 19) warmest = std::max(warmest, plant.mean_degc());
    plant.step_row();
  }
  EXPECT_LT(warmest, 25.25 + 1.5);
}

}  // namespace
}  // namespace airside::tools
