// The learned forecast of electric power.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "airside/demand/power_model.hpp"
#include "demand/zone_fixture.hpp"

namespace {

using namespace airside;
using demand_test::FormulaBuilding;

constexpr double not_metered = std::numeric_limits<double>::quiet_NaN();

BandObjective learned_power(FormulaBuilding& building, int days = 8) {
  BandObjective objective;
  objective.reset({});
  building.live({}, objective, days);
  return objective;
}

PowerShapes shapes_of(const FormulaBuilding& b, double supply) {
  return power_shapes(
      {.flow = b.flow(supply), .supply_degc = supply, .room_degc = b.room_degc[0], .outdoor_degc = b.outdoor_degc});
}

TEST(PowerModel, PredictsAPlantAtSetpointsThatItHasNeverSeen) {
  for (const bool economizer : {false, true}) {
    FormulaBuilding building;
    building.economizer = economizer;
    const BandObjective objective = learned_power(building);
    for (const double outdoor : {15.0, 20.0, 26.0}) {
      building.outdoor_degc = outdoor;
      const double now = building.total(14), there = building.total(16);
      const double predicted =
          objective.power().power_kw(shapes_of(building, 16)) - objective.power().power_kw(shapes_of(building, 14));
      EXPECT_NEAR(predicted, there - now, 0.15 * now) << "economizer " << economizer << ", outdoors " << outdoor;
    }
  }
}

TEST(PowerModel, TellsFromTheMetersWhetherThereIsAnEconomizer) {
  FormulaBuilding with, without;
  without.economizer = false;
  EXPECT_GT(learned_power(with).power().economizer_share(), 0.95);
  EXPECT_LT(learned_power(without).power().economizer_share(), 0.05);
}

TEST(PowerModel, BelievesNeitherLawBeforeItHasSeenColdWeather) {
  BandObjective objective;
  objective.reset({});
  EXPECT_DOUBLE_EQ(objective.power().economizer_share(), 0.5);
}

TEST(PowerModel, IsLessSureOfASetpointThatIsFurtherAway) {
  FormulaBuilding building;
  const BandObjective objective = learned_power(building, 3);
  const auto sd = [&](double supply) {
    return objective.power().difference_sd_kw(shapes_of(building, supply), shapes_of(building, 14));
  };
  EXPECT_DOUBLE_EQ(sd(14), 0);
  EXPECT_LT(sd(15), sd(17));
}

/// Flow and the coil's load go up and down together; cooling is said to fall by this much where flow is full.
PowerModel learned_from(double fall_kw) {
  PowerModel model;
  for (int i = 0; i < 800; ++i) {
    const double flow = 0.5 + 0.2 * std::sin(0.3 * i), room = 24 + 0.5 * std::sin(0.07 * i);
    const PowerShapes x =
        power_shapes({.flow = flow, .supply_degc = 14, .room_degc = room, .outdoor_degc = 30 + 3 * std::sin(0.05 * i)});
    const double fan_kw = 6 * x.flow_cubed;
    model.update({}, x,
                 {.total_kw = fan_kw + 60 * x.lift - fall_kw * x.flow, .fan_kw = fan_kw, .flow_m3_s = not_metered});
  }
  return model;
}

TEST(PowerModel, CoolingDoesNotFallWithFlowAsMuchAsTheFanTakes) {
  const double slope = 6 * 3 * 0.25;  // of the fan at half flow
  EXPECT_GE(learned_from(25).lift_law().theta()[5], -0.25 * slope);
  EXPECT_LT(learned_from(25).lift_law().theta()[5], -0.15 * slope) << "and as far as that it is believed";
  EXPECT_GT(learned_from(-3).lift_law().theta()[5], 0) << "the other way it is free";
}

TEST(PowerModel, WhatCoolingTakesGrowsWithTheLoadAndTheWeather) {
  const PowerModel model = learned_from(0);
  EXPECT_NEAR(model.cooling_kw(0.1, 30), 6, 1);
  EXPECT_NEAR(model.cooling_kw(-0.1, 30), -model.cooling_kw(0.1, 30), 1e-9);
}

TEST(PowerModel, AFlowSensorSaysWhatHeatFlows) {
  PowerModel model;
  const PowerShapes x = power_shapes({.flow = 0.5, .supply_degc = 14, .room_degc = 24, .outdoor_degc = 28});
  for (int i = 0; i < 30; ++i) model.update({}, x, {.total_kw = 3, .fan_kw = 0.5, .flow_m3_s = 0.8});
  EXPECT_NEAR(model.thermal_kw(), 1.207 * 1.6 * 10, 0.01);
}

TEST(PowerModel, WhatIsNoNumberChangesNothing) {
  FormulaBuilding building;
  const BandObjective objective = learned_power(building, 3);
  PowerModel model = objective.power();
  PowerShapes x = shapes_of(building, 15);
  const double before = model.power_kw(x);
  model.update({}, x, {.total_kw = std::nan(""), .fan_kw = 1, .flow_m3_s = 1});
  PowerShapes broken = x;
  broken.lift = std::nan("");
  model.update({}, broken, {.total_kw = 3, .fan_kw = 1, .flow_m3_s = 1});
  EXPECT_DOUBLE_EQ(model.power_kw(x), before);
  EXPECT_TRUE(model.finite());
}

}  // namespace
