// New weights must pass the gate before they control: poisoned memories and broken steps leave the old ones standing.

#include "airside/presets.hpp"
#include "support/controller_rig.hpp"
#include "support/default_cycle.hpp"

namespace airside {
namespace {

using Rig = ControllerRig;
using L = Layout<FiveZone>;

/// Settings that learn hard enough to ruin weights within one cycle.
ControllerSettings eager() {
  ControllerSettings s = product_settings();
  s.updates_per_cycle = 20;
  s.learning_rate = 0.02;
  return s;
}

/// Fills the memory with a day of the rig's own transitions.
void remember_a_day(Rig& rig) {
  for (int i = 0; i < 240; ++i) {
    rig.now.seconds += row_s;
    const auto before = rig.reading().value;
    rig.controller->remember(before, rig.setpoint, before);
  }
  while (!starts_cycle(rig.now)) rig.now.seconds += row_s;
}

bool trained_on(int slot) { return slot % 10 != 9; }

TEST(Gate, SoundLearningPassesAndMovesTheWeights) {
  Rig rig;
  remember_a_day(rig);
  const auto before = rig.controller->learning().weights;
  rig.cycles(4);
  EXPECT_FALSE(rig.same_weights(before));
  EXPECT_EQ(rig.controller->learning().rejected, 0U);
}

TEST(Gate, PoisonedMemoriesAreRefusedAndTheWeightsStay) {
  Rig rig(eager());
  remember_a_day(rig);
  rig.cycles(1);
  auto& replay = inside(*rig.controller).replay;
  for (int slot = 0; slot < replay.size(); ++slot) {
    if (!trained_on(slot)) continue;
    for (int r = 0; r < L::rooms; ++r) replay.slot(slot)[static_cast<std::size_t>(L::inputs + r)] = -40.0f;
  }
  const auto before = rig.controller->learning().weights;
  rig.cycles(1);
  ASSERT_EQ(rig.controller->learning().rejected, 1U);
  EXPECT_EQ(rig.decision().fault, Fault::learning_rejected);
  EXPECT_TRUE(rig.same_weights(before));
  rig.row();
  EXPECT_TRUE(std::isfinite(rig.decision().network_degc)) << "control goes on with the old weights";
}

TEST(Gate, MemoriesThatAreNoNumbersAreRefusedAndTheWeightsStay) {
  Rig rig;
  remember_a_day(rig);
  rig.cycles(1);
  auto& replay = inside(*rig.controller).replay;
  for (int slot = 0; slot < replay.size(); ++slot) {
    if (trained_on(slot)) replay.slot(slot).fill(std::numeric_limits<float>::quiet_NaN());
  }
  const auto before = rig.controller->learning().weights;
  for (int i = 1; i <= 3; ++i) {
    rig.cycles(1);
    EXPECT_EQ(rig.controller->learning().rejected, static_cast<std::uint64_t>(i));
    EXPECT_TRUE(rig.same_weights(before));
  }
  for (const float m : rig.controller->learning().learner.first_moment().values) ASSERT_TRUE(std::isfinite(m));
  EXPECT_TRUE(all_finite(rig.controller->learning().learner.target()));
}

TEST(Gate, AStepThatExplodesIsRefused) {
  ControllerSettings s = product_settings();
  s.learning_rate = 1.0;
  s.updates_per_cycle = 50;
  Rig rig(s);
  remember_a_day(rig);
  rig.cycles(1);
  const auto before = rig.controller->learning().weights;
  rig.cycles(1);
  EXPECT_EQ(rig.controller->learning().rejected, 1U);
  EXPECT_TRUE(rig.same_weights(before));
}

TEST(Gate, StrangeWeightsMayStillLearnTheirWayOut) {
  Rig rig;
  // Forecasts 40 K too high: outside the canary's bounds from the start.
  const auto offset = 40.0f / static_cast<float>(rig.controller->learning().scaler.room_scale());
  auto& weights = inside(*rig.controller).learning.weights;
  weights.bias<Layer::dec>().array() += offset;
  rig.controller->start(Scaler<FiveZone>(rig.controller->learning().scaler));
  const auto& controller = *rig.controller;
  PackedWeights<FiveZone, float> packed;
  auto& scratch = inside(*rig.controller).scratch;
  pack(controller.learning().weights, scratch.kernels, packed);
  ASSERT_GT(canary_excess_k<FiveZone>(controller.settings(), controller.learning().scaler, packed, scratch), 1.0);
  remember_a_day(rig);
  const auto before = rig.controller->learning().weights;
  rig.cycles(40);
  EXPECT_FALSE(rig.same_weights(before));
  EXPECT_LT(rig.controller->learning().rejected, 40U);
}

TEST(Gate, WithoutItWeightsThatAreNoNumbersAreRefusedAllTheSame) {
  ControllerSettings s = product_settings();
  s.gate = 0;
  Rig rig(s);
  remember_a_day(rig);
  rig.cycles(1);
  auto& replay = inside(*rig.controller).replay;
  for (int slot = 0; slot < replay.size(); ++slot) {
    replay.slot(slot).fill(std::numeric_limits<float>::quiet_NaN());
  }
  const auto before = rig.controller->learning().weights;
  rig.cycles(1);
  EXPECT_EQ(rig.controller->learning().rejected, 1U);
  EXPECT_TRUE(rig.same_weights(before));
}

TEST(Gate, WithoutItThePoisonWouldHaveControlled) {
  ControllerSettings s = eager();
  s.gate = 0;
  Rig rig(s);
  remember_a_day(rig);
  rig.cycles(1);
  auto& replay = inside(*rig.controller).replay;
  for (int slot = 0; slot < replay.size(); ++slot) {
    for (int r = 0; r < L::rooms; ++r) replay.slot(slot)[static_cast<std::size_t>(L::inputs + r)] = -40.0f;
  }
  const auto before = rig.controller->learning().weights;
  rig.cycles(1);
  EXPECT_FALSE(rig.same_weights(before));
}

TEST(Canary, WhatIsNoNumberIsNoSaneForecast) {
  ControllerRig rig;
  auto& controller = *rig.controller;
  inside(controller).learning.weights.values.fill(std::nanf(""));
  controller.prepare();
  EXPECT_FALSE(std::isfinite(
      controller.forecast_deviation(controller.learning().scaler, controller.learning().weights).canary_k));
  RoomHead<FiveZone> head;
  head.reset(controller.settings(), 0.3, 0.1);
  const auto excess = [&head] {
    const RoomHead<FiveZone>& seen = head;
    return canary_excess_k<FiveZone>(seen.theta(), seen.covariance());
  };
  EXPECT_EQ(excess(), 0.0);
  head.covariance()(3, 3) = -1;
  EXPECT_FALSE(std::isfinite(excess()));
  head.covariance()(3, 3) = 400;
  EXPECT_DOUBLE_EQ(excess(), 10.0);
  head.covariance()(3, 3) = 0.25;
  head.theta()(20) = -7;
  EXPECT_DOUBLE_EQ(excess(), 2.0);
  head.theta()(20) = std::nan("");
  EXPECT_FALSE(std::isfinite(excess()));
}

}  // namespace
}  // namespace airside
