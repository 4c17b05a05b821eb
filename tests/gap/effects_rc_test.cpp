// Every effect of the library on the RC room: nothing at its null, the physical sign in its channels.

#include <gtest/gtest.h>

#include <cstdio>

#include "gap/effects_expected.hpp"
#include "gap/effects_library.hpp"
#include "tools/gap/model/responses.hpp"

namespace airside::sim {
namespace {

using tools::gap::RcEngine;

const ChannelTable& rc_base() {
  static const ChannelTable table = RcEngine(make_room()).simulate({}, weekend());
  return table;
}

ChannelTable rc_response(const Effect& effect, int place, double magnitude) {
  return RcEngine(make_room()).simulate({{{&effect, place}, magnitude}}, weekend()) - rc_base();
}

TEST(EffectOnRc, ShowsInItsChannelsWithThePhysicalSign) {
  for (const ExpectedSign& expected : expected_signs) {
    const Effect& effect = effect_named(expected.effect);
    for (const double probe : effect.probe) {
      const std::string which = EffectAt{&effect, expected.place}.id() + " at " + std::to_string(probe);
      // The RC room has no east and west windows but at its ends; all are there.
      const ChannelTable response = rc_response(effect, expected.place, probe);
      ASSERT_TRUE(response.allFinite()) << which;
      const ShownResponse shown = shown_in(response, five, expected.shown);
      EXPECT_GT(shown.largest, 0.01) << which << ": no more than a sensor's resolution";
      if (expected.sign != 0) {
        EXPECT_GT(expected.sign * (probe > effect.null_value ? 1 : -1) * shown.mean, 0) << which;
      }
    }
  }
}

TEST(EffectOnRc, DoesNothingAtItsNullToTheBit) {
  for (const Effect& effect : library()) {
    for (const EffectAt& at : places_of(effect, five, windows)) {
      if (at.place != places_of(effect, five, windows).back().place) continue;
      EXPECT_EQ(RcEngine(make_room()).simulate({{at, effect.null_value}}, weekend()), rc_base()) << at.id();
    }
  }
}

TEST(EffectOnRc, BeginsSmallNearItsNull) {
  for (const Effect& effect : library()) {
    // A stuck box is stuck, however near to its usual opening; half a minute is less than the clock's step.
    if (effect.name == "vav_stuck") continue;
    for (const double probe : effect.probe) {
      const double near = effect.null_value + 0.01 * (probe - effect.null_value);
      const int place = effect.place == PlaceKind::facade ? 2 : 0;
      const double at_probe = rc_response(effect, place, probe).leftCols(five.fcu_duty()).norm();
      const double nearby = rc_response(effect, place, near).leftCols(five.fcu_duty()).norm();
      EXPECT_LT(nearby, 0.15 * at_probe) << effect.name << " at " << near;
    }
  }
}

TEST(EffectOnRc, LeakLeavesTheFansAsTheyWere) {
  const ChannelTable response = rc_response(effect_named("duct_leak"), 0, 0.2);
  EXPECT_LT(response.col(five.power()).cwiseAbs().maxCoeff(), 0.011);
}

}  // namespace
}  // namespace airside::sim
