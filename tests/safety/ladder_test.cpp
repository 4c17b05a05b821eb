// The ladder: the gravest reason wins, each ends as it says, and no clock makes one last longer.

#include "airside/supervision/ladder.hpp"

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

TEST(Ladder, Row28AClockThatIsSetAtLastDoesNotEndAnOverride) {
  Ladder ladder;
  ladder.tick(noon);
  ladder.hold(Reason::overridden, noon, 4 * 3600);
  const CivilTime nineteen_seventy{600};
  ladder.tick(nineteen_seventy);
  ladder.set(Reason::clock_not_set, true, nineteen_seventy);
  ladder.tick(later(1200));
  EXPECT_TRUE(ladder.active(Reason::overridden, later(1200)));
  ladder.set(Reason::clock_not_set, false, later(1200));
  EXPECT_TRUE(ladder.active(Reason::overridden, later(1200 + 4 * 3600 - 1)));
  EXPECT_FALSE(ladder.active(Reason::overridden, later(1200 + 4 * 3600)));
}

TEST(Ladder, Row28WithoutADoubtedClockTimeThatHasPassedHasPassed) {
  Ladder ladder;
  ladder.tick(noon);
  ladder.hold(Reason::overridden, noon, 3600);
  ladder.tick(later(86400));
  EXPECT_FALSE(ladder.active(Reason::overridden, later(86400)));
  Ladder fresh;
  fresh.set(Reason::clock_not_set, true, {600});
  fresh.tick({600});
  EXPECT_EQ(fresh.since_s(Reason::clock_not_set), 600) << "the first tick moves nothing";
}

TEST(Ladder, ReleasesOfAnotherLadderStay) {
  Ladder before, after;
  before.hold(Reason::released_by_hand, noon, 0);
  before.hold(Reason::overridden, noon, 3600);
  before.hold(Reason::writes_refused, later(-7200), 3600);
  before.set(Reason::sensor_drifts, true, noon);
  after.hold(Reason::overridden, noon, 7200);
  before.hold(Reason::crash_loop, noon, 3600);
  before.tick(noon);
  after.join_releases(before, noon);
  EXPECT_TRUE(after.active(Reason::crash_loop, later(3599))) << "no row holds it again";
  EXPECT_EQ(after.gravest(later(1'000'000'000)), Reason::released_by_hand);
  EXPECT_TRUE(after.active(Reason::overridden, later(7199))) << "its own is the longer one";
  EXPECT_FALSE(after.active(Reason::writes_refused, noon)) << "that was over";
  EXPECT_FALSE(after.active(Reason::sensor_drifts, noon)) << "the next reading tells";
}

TEST(Ladder, ReleasesOfAnotherLadderLastAsLongWhateverClockEachKnew) {
  const CivilTime nineteen_seventy{600};
  for (const CivilTime saved : {CivilTime{30 * 86400}, noon, later(-300 * 86400)}) {
    Ladder loaded, now;
    loaded.tick(saved);
    now.tick(nineteen_seventy);
    now.set(Reason::clock_not_set, true, nineteen_seventy);
    now.hold(Reason::overridden, nineteen_seventy, 4 * 3600);
    loaded.join_releases(now, nineteen_seventy);
    CivilTime t{nineteen_seventy.seconds + row_s};
    loaded.tick(t);
    EXPECT_TRUE(loaded.active(Reason::overridden, t)) << saved.seconds;
    loaded.tick(noon);  // set at last
    EXPECT_TRUE(loaded.active(Reason::overridden, later(4 * 3600 - row_s - 1))) << saved.seconds;
    EXPECT_FALSE(loaded.active(Reason::overridden, later(4 * 3600 - row_s))) << saved.seconds;
  }
  Ladder loaded, now;  // saved under a clock that was not set, which is right now
  loaded.tick(nineteen_seventy);
  loaded.set(Reason::clock_not_set, true, nineteen_seventy);
  now.tick(noon);
  now.hold(Reason::overridden, noon, 4 * 3600);
  loaded.join_releases(now, noon);
  EXPECT_FALSE(loaded.active(Reason::clock_not_set, noon));
  loaded.tick(later(7200));
  EXPECT_TRUE(loaded.active(Reason::overridden, later(4 * 3600 - 1)));
  EXPECT_FALSE(loaded.active(Reason::overridden, later(4 * 3600)));
}

TEST(Ladder, WhereOnlyReleasesAreKeptTheyLastNoLonger) {
  const CivilTime nineteen_seventy{600};
  Ladder ladder;
  ladder.tick(noon);
  ladder.hold(Reason::overridden, noon, 4 * 3600);
  ladder.hold(Reason::crash_loop, noon, 8 * 3600);
  ladder.keep_only_releases();
  EXPECT_EQ(ladder.gravest(noon), Reason::overridden);
  ladder.tick(nineteen_seventy);
  ladder.set(Reason::clock_not_set, true, nineteen_seventy);
  ladder.keep_only_releases();
  ladder.tick(later(3600));
  EXPECT_TRUE(ladder.active(Reason::overridden, later(3600)));
  EXPECT_FALSE(ladder.active(Reason::overridden, later(3600 + 4 * 3600)));
  EXPECT_EQ(ladder.gravest(later(3600 + 4 * 3600)), Reason::clock_not_set);
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

TEST(Ladder, EveryRungHasAWord) {
  const char* words[] = {"learn", "run", "expert", "release", "unknown"};
  for (std::uint32_t rung = 0; rung < 5; ++rung) EXPECT_STREQ(text_of(static_cast<Mode>(rung)), words[rung]);
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
