// The ladder: the gravest reason wins, each ends as it says, and no clock makes one last longer.

#include "airside/ladder.hpp"

#include <gtest/gtest.h>

#include <cstring>

namespace airside {
namespace {

constexpr CivilTime noon{1'627'905'600};
constexpr CivilTime later(std::int64_t seconds) { return {noon.seconds + seconds}; }

TEST(Ladder, StandsOnLearnWhereNothingIsWrong) {
  Ladder ladder;
  EXPECT_EQ(ladder.mode(noon), Mode::learn);
  EXPECT_EQ(ladder.gravest(noon), Reason::none);
  EXPECT_TRUE(ladder.beats(noon));
}

TEST(Ladder, TakesTheHighestRungThatAnyReasonAsksFor) {
  Ladder ladder;
  ladder.set(Reason::sensor_drifts, true, noon);
  EXPECT_EQ(ladder.mode(noon), Mode::run);
  ladder.set(Reason::map_differs, true, noon);
  EXPECT_EQ(ladder.mode(noon), Mode::release);
  ladder.set(Reason::clock_not_set, true, noon);
  EXPECT_EQ(ladder.gravest(noon), Reason::map_differs) << "a lesser reason does not lower it";
  ladder.set(Reason::map_differs, false, noon);
  EXPECT_EQ(ladder.gravest(noon), Reason::clock_not_set);
  ladder.set(Reason::clock_not_set, false, noon);
  ladder.set(Reason::sensor_drifts, false, noon);
  EXPECT_EQ(ladder.mode(noon), Mode::learn);
}

TEST(Ladder, AnOverrideEndsAfterItsTime) {
  Ladder ladder;
  ladder.hold(Reason::overridden, noon, 3600);
  EXPECT_EQ(ladder.mode(later(3599)), Mode::release);
  EXPECT_EQ(ladder.mode(later(3600)), Mode::learn);
}

TEST(Ladder, WhatWaitsForAPersonEndsOnlyWhenHandedBack) {
  Ladder ladder;
  ladder.hold(Reason::two_masters, noon, 1);
  ladder.set(Reason::sensor_drifts, true, noon);
  EXPECT_EQ(ladder.mode(later(10'000'000)), Mode::release);
  ladder.hand_back();
  EXPECT_EQ(ladder.gravest(later(1)), Reason::sensor_drifts) << "a broken sensor does not heal by decree";
}

TEST(Ladder, TheHeartbeatStopsOnReleaseButNotForAnOverride) {
  Ladder ladder;
  ladder.hold(Reason::overridden, noon, 3600);
  EXPECT_TRUE(ladder.beats(noon)) << "without it the AHU would drop the operator's value";
  ladder.set(Reason::map_differs, true, noon);
  EXPECT_FALSE(ladder.beats(noon));
}

TEST(Ladder, AClockSetBackDoesNotMakeAnOverrideLast) {
  Ladder ladder;
  ladder.tick(noon);
  ladder.hold(Reason::overridden, noon, 3600);
  const CivilTime back = later(-30 * 86400);
  ladder.tick(back);
  EXPECT_EQ(ladder.mode(back), Mode::release);
  EXPECT_EQ(ladder.mode({back.seconds + 3600}), Mode::learn);
}

TEST(Ladder, ASmallStepOfTheClockChangesNothing) {
  Ladder ladder;
  ladder.tick(noon);
  ladder.hold(Reason::overridden, noon, 3600);
  ladder.tick(later(-300));
  EXPECT_EQ(ladder.mode(later(3599)), Mode::release);
  EXPECT_EQ(ladder.mode(later(3600)), Mode::learn);
}

TEST(Ladder, SaysSinceWhenAReasonIsActive) {
  Ladder ladder;
  ladder.set(Reason::sensor_drifts, true, noon);
  ladder.set(Reason::sensor_drifts, true, later(600));
  EXPECT_EQ(ladder.since_s(Reason::sensor_drifts), noon.seconds);
  ladder.set(Reason::sensor_drifts, false, later(700));
  ladder.set(Reason::sensor_drifts, true, later(800));
  EXPECT_EQ(ladder.since_s(Reason::sensor_drifts), later(800).seconds);
}

TEST(Ladder, EveryReasonSaysWhyAndHowItEnds) {
  for (int i = 0; i < reason_count; ++i) {
    const Rung rung = rung_of(static_cast<Reason>(i));
    EXPECT_GT(std::strlen(rung.why), 5u) << i;
    EXPECT_GT(std::strlen(rung.way_out), 5u) << i;
    EXPECT_STRNE(rung.why, "unknown") << i;
    EXPECT_TRUE(rung.beats || rung.mode == Mode::release) << i;
  }
}

TEST(Ladder, BeforeTheFirstCycleItSaysSo) {
  const OnRung begun{Mode::expert, Reason::none}, well{Mode::learn, Reason::none},
      map{Mode::expert, Reason::map_differs};
  EXPECT_STREQ(why_of(begun), "it has decided nothing yet");
  EXPECT_STREQ(way_out_of(begun), "ends with its first cycle");
  EXPECT_STREQ(why_of(well), "all is well");
  EXPECT_STREQ(way_out_of(well), "none needed");
  EXPECT_STREQ(why_of(map), rung_of(Reason::map_differs).why);
  EXPECT_STREQ(way_out_of(map), rung_of(Reason::map_differs).way_out);
}

TEST(Ladder, NoReasonHoldsNothing) {
  Ladder ladder;
  ladder.hold(Reason::none, noon, 3600);
  ladder.set(Reason::none, true, noon);
  EXPECT_EQ(ladder.gravest(noon), Reason::none);
  EXPECT_FALSE(ladder.active(Reason::none, noon));
  EXPECT_EQ(rung_of(static_cast<Reason>(200)).mode, Mode::release) << "a number that nobody knows is the gravest";
}

TEST(Ladder, HoldingAgainBeginsTheTimeAnewButNotItsBeginning) {
  Ladder ladder;
  ladder.hold(Reason::overridden, noon, 3600);
  ladder.hold(Reason::overridden, later(1800), 3600);
  EXPECT_EQ(ladder.since_s(Reason::overridden), noon.seconds);
  EXPECT_TRUE(ladder.active(Reason::overridden, later(5399)));
  EXPECT_FALSE(ladder.active(Reason::overridden, later(5400)));
}

TEST(Ladder, AClockSetBackLeavesWhatHasNoEndWithoutOne) {
  Ladder ladder;
  ladder.tick(noon);
  ladder.set(Reason::map_differs, true, noon);
  ladder.tick(later(-86400));
  EXPECT_TRUE(ladder.active(Reason::map_differs, later(1'000'000'000)));
  EXPECT_EQ(ladder.since_s(Reason::map_differs), later(-86400).seconds);
}

}  // namespace
}  // namespace airside
