// The mode arbiter: the gravest reason wins, each ends as it says, and no clock makes one last longer.

#include "airside/supervision/mode_arbiter.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cstring>

namespace airside {
namespace {

constexpr CivilTime noon{1'627'905'600};
constexpr CivilTime later(std::int64_t seconds) { return {noon.seconds + seconds}; }

constexpr std::array<ModeRequest, reason_count> spoilt(std::size_t row, ModeRequest to) {
  auto table = mode_table;
  table[row] = to;
  return table;
}
constexpr ModeRequest sound_row = request_of(Reason::storage_failed);
constexpr auto row_of_it = static_cast<std::size_t>(Reason::storage_failed);
constexpr ModeRequest with(Reason reason, const char* why, bool beats, bool for_person) {
  return {.reason = reason,
          .name = sound_row.name,
          .mode = sound_row.mode,
          .beats = beats,
          .for_person = for_person,
          .why = why,
          .way_out = sound_row.way_out};
}

// What the compiler refuses of the table: it is asserted of the real one where that is defined.
static_assert(is_complete(spoilt(row_of_it, sound_row)));
static_assert(!is_complete(spoilt(row_of_it, with(Reason::signal_held, sound_row.why, true, false))), "out of place");
static_assert(!is_complete(spoilt(row_of_it, with(sound_row.reason, "", true, false))), "without words");
static_assert(!is_complete(spoilt(row_of_it, with(sound_row.reason, nullptr, true, false))), "left out");
static_assert(!is_complete(spoilt(row_of_it, with(sound_row.reason, sound_row.why, false, false))),
              "silent while it writes");
static_assert(!is_complete(spoilt(row_of_it, with(sound_row.reason, sound_row.why, true, true))),
              "an alarm waits for nobody");

TEST(ModeTable, AnUnknownNumberReleasesUntilAPersonComes) {
  const ModeRequest unknown = request_of(static_cast<Reason>(reason_count));
  EXPECT_EQ(unknown.mode, ControlMode::release);
  EXPECT_TRUE(unknown.for_person);
  EXPECT_FALSE(unknown.beats);
}

TEST(ModeArbiter, StandsOnLearnWhereNothingIsWrong) {
  ModeArbiter mode_arbiter;
  EXPECT_EQ(mode_arbiter.mode(noon), ControlMode::learn);
  EXPECT_EQ(mode_arbiter.gravest(noon), Reason::none);
  EXPECT_TRUE(mode_arbiter.beats(noon));
}

TEST(ModeArbiter, TakesTheHighestRungThatAnyReasonAsksFor) {
  ModeArbiter mode_arbiter;
  mode_arbiter.set(Reason::sensor_drifts, true, noon);
  EXPECT_EQ(mode_arbiter.mode(noon), ControlMode::run);
  mode_arbiter.set(Reason::map_differs, true, noon);
  EXPECT_EQ(mode_arbiter.mode(noon), ControlMode::release);
  mode_arbiter.set(Reason::clock_not_set, true, noon);
  EXPECT_EQ(mode_arbiter.gravest(noon), Reason::map_differs) << "a lesser reason does not lower it";
  mode_arbiter.set(Reason::map_differs, false, noon);
  EXPECT_EQ(mode_arbiter.gravest(noon), Reason::clock_not_set);
  mode_arbiter.set(Reason::clock_not_set, false, noon);
  mode_arbiter.set(Reason::sensor_drifts, false, noon);
  EXPECT_EQ(mode_arbiter.mode(noon), ControlMode::learn);
}

TEST(ModeArbiter, AnOverrideEndsAfterItsTime) {
  ModeArbiter mode_arbiter;
  mode_arbiter.hold(Reason::overridden, noon, 3600);
  EXPECT_EQ(mode_arbiter.mode(later(3599)), ControlMode::release);
  EXPECT_EQ(mode_arbiter.mode(later(3600)), ControlMode::learn);
}

TEST(ModeArbiter, WhatWaitsForAPersonEndsOnlyWhenHandedBack) {
  ModeArbiter mode_arbiter;
  mode_arbiter.hold(Reason::two_masters, noon, 1);
  mode_arbiter.set(Reason::sensor_drifts, true, noon);
  EXPECT_EQ(mode_arbiter.mode(later(10'000'000)), ControlMode::release);
  mode_arbiter.hand_back();
  EXPECT_EQ(mode_arbiter.gravest(later(1)), Reason::sensor_drifts) << "a broken sensor does not heal by decree";
}

TEST(ModeArbiter, TheHeartbeatStopsOnReleaseButNotForAnOverride) {
  ModeArbiter mode_arbiter;
  mode_arbiter.hold(Reason::overridden, noon, 3600);
  EXPECT_TRUE(mode_arbiter.beats(noon)) << "without it the AHU would drop the operator's value";
  mode_arbiter.set(Reason::map_differs, true, noon);
  EXPECT_FALSE(mode_arbiter.beats(noon));
}

TEST(ModeArbiter, AClockSetBackDoesNotMakeAnOverrideLast) {
  ModeArbiter mode_arbiter;
  mode_arbiter.tick(noon);
  mode_arbiter.hold(Reason::overridden, noon, 3600);
  const CivilTime back = later(-30 * 86400);
  mode_arbiter.tick(back);
  EXPECT_EQ(mode_arbiter.mode(back), ControlMode::release);
  EXPECT_EQ(mode_arbiter.mode({back.seconds + 3600}), ControlMode::learn);
}

TEST(ModeArbiter, Row28AClockThatIsSetAtLastDoesNotEndAnOverride) {
  ModeArbiter mode_arbiter;
  mode_arbiter.tick(noon);
  mode_arbiter.hold(Reason::overridden, noon, 4 * 3600);
  const CivilTime nineteen_seventy{600};
  mode_arbiter.tick(nineteen_seventy);
  mode_arbiter.set(Reason::clock_not_set, true, nineteen_seventy);
  mode_arbiter.tick(later(1200));
  EXPECT_TRUE(mode_arbiter.active(Reason::overridden, later(1200)));
  mode_arbiter.set(Reason::clock_not_set, false, later(1200));
  EXPECT_TRUE(mode_arbiter.active(Reason::overridden, later(1200 + 4 * 3600 - 1)));
  EXPECT_FALSE(mode_arbiter.active(Reason::overridden, later(1200 + 4 * 3600)));
}

TEST(ModeArbiter, Row28WithoutADoubtedClockTimeThatHasPassedHasPassed) {
  ModeArbiter mode_arbiter;
  mode_arbiter.tick(noon);
  mode_arbiter.hold(Reason::overridden, noon, 3600);
  mode_arbiter.tick(later(86400));
  EXPECT_FALSE(mode_arbiter.active(Reason::overridden, later(86400)));
  ModeArbiter fresh;
  fresh.set(Reason::clock_not_set, true, {600});
  fresh.tick({600});
  EXPECT_EQ(fresh.since_s(Reason::clock_not_set), 600) << "the first tick moves nothing";
}

TEST(ModeArbiter, ReleasesOfAnotherLadderStay) {
  ModeArbiter before, after;
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

TEST(ModeArbiter, ReleasesOfAnotherLadderLastAsLongWhateverClockEachKnew) {
  const CivilTime nineteen_seventy{600};
  for (const CivilTime saved : {CivilTime{30 * 86400}, noon, later(-300 * 86400)}) {
    ModeArbiter loaded, now;
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
  ModeArbiter loaded, now;  // saved under a clock that was not set, which is right now
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

TEST(ModeArbiter, WhereOnlyReleasesAreKeptTheyLastNoLonger) {
  const CivilTime nineteen_seventy{600};
  ModeArbiter mode_arbiter;
  mode_arbiter.tick(noon);
  mode_arbiter.hold(Reason::overridden, noon, 4 * 3600);
  mode_arbiter.hold(Reason::crash_loop, noon, 8 * 3600);
  mode_arbiter.keep_only_releases();
  EXPECT_EQ(mode_arbiter.gravest(noon), Reason::overridden);
  mode_arbiter.tick(nineteen_seventy);
  mode_arbiter.set(Reason::clock_not_set, true, nineteen_seventy);
  mode_arbiter.keep_only_releases();
  mode_arbiter.tick(later(3600));
  EXPECT_TRUE(mode_arbiter.active(Reason::overridden, later(3600)));
  EXPECT_FALSE(mode_arbiter.active(Reason::overridden, later(3600 + 4 * 3600)));
  EXPECT_EQ(mode_arbiter.gravest(later(3600 + 4 * 3600)), Reason::clock_not_set);
}

TEST(ModeArbiter, ASmallStepOfTheClockChangesNothing) {
  ModeArbiter mode_arbiter;
  mode_arbiter.tick(noon);
  mode_arbiter.hold(Reason::overridden, noon, 3600);
  mode_arbiter.tick(later(-300));
  EXPECT_EQ(mode_arbiter.mode(later(3599)), ControlMode::release);
  EXPECT_EQ(mode_arbiter.mode(later(3600)), ControlMode::learn);
}

TEST(ModeArbiter, SaysSinceWhenAReasonIsActive) {
  ModeArbiter mode_arbiter;
  mode_arbiter.set(Reason::sensor_drifts, true, noon);
  mode_arbiter.set(Reason::sensor_drifts, true, later(600));
  EXPECT_EQ(mode_arbiter.since_s(Reason::sensor_drifts), noon.seconds);
  mode_arbiter.set(Reason::sensor_drifts, false, later(700));
  mode_arbiter.set(Reason::sensor_drifts, true, later(800));
  EXPECT_EQ(mode_arbiter.since_s(Reason::sensor_drifts), later(800).seconds);
}

TEST(ModeArbiter, EveryReasonSaysWhyAndHowItEnds) {
  for (int i = 0; i < reason_count; ++i) {
    const ModeRequest control_mode = request_of(static_cast<Reason>(i));
    EXPECT_GT(std::strlen(control_mode.why), 5u) << i;
    EXPECT_GT(std::strlen(control_mode.way_out), 5u) << i;
    EXPECT_STRNE(control_mode.why, "unknown") << i;
    EXPECT_TRUE(control_mode.beats || control_mode.mode == ControlMode::release) << i;
  }
}

TEST(ModeArbiter, EveryRungHasAWord) {
  const char* words[] = {"learn", "run", "expert", "release", "unknown"};
  for (std::uint32_t control_mode = 0; control_mode < 5; ++control_mode)
    EXPECT_STREQ(text_of(static_cast<ControlMode>(control_mode)), words[control_mode]);
}

TEST(ModeArbiter, BeforeTheFirstCycleItSaysSo) {
  const ActiveMode begun{ControlMode::expert, Reason::none}, well{ControlMode::learn, Reason::none},
      map{ControlMode::expert, Reason::map_differs};
  EXPECT_STREQ(why_of(begun), "it has decided nothing yet");
  EXPECT_STREQ(way_out_of(begun), "ends with its first cycle");
  EXPECT_STREQ(why_of(well), "all is well");
  EXPECT_STREQ(way_out_of(well), "none needed");
  EXPECT_STREQ(why_of(map), request_of(Reason::map_differs).why);
  EXPECT_STREQ(way_out_of(map), request_of(Reason::map_differs).way_out);
}

TEST(ModeArbiter, NoReasonHoldsNothing) {
  ModeArbiter mode_arbiter;
  mode_arbiter.hold(Reason::none, noon, 3600);
  mode_arbiter.set(Reason::none, true, noon);
  EXPECT_EQ(mode_arbiter.gravest(noon), Reason::none);
  EXPECT_FALSE(mode_arbiter.active(Reason::none, noon));
  EXPECT_EQ(request_of(static_cast<Reason>(200)).mode, ControlMode::release)
      << "a number that nobody knows is the gravest";
}

TEST(ModeArbiter, HoldingAgainBeginsTheTimeAnewButNotItsBeginning) {
  ModeArbiter mode_arbiter;
  mode_arbiter.hold(Reason::overridden, noon, 3600);
  mode_arbiter.hold(Reason::overridden, later(1800), 3600);
  EXPECT_EQ(mode_arbiter.since_s(Reason::overridden), noon.seconds);
  EXPECT_TRUE(mode_arbiter.active(Reason::overridden, later(5399)));
  EXPECT_FALSE(mode_arbiter.active(Reason::overridden, later(5400)));
}

TEST(ModeArbiter, AClockSetBackLeavesWhatHasNoEndWithoutOne) {
  ModeArbiter mode_arbiter;
  mode_arbiter.tick(noon);
  mode_arbiter.set(Reason::map_differs, true, noon);
  mode_arbiter.tick(later(-86400));
  EXPECT_TRUE(mode_arbiter.active(Reason::map_differs, later(1'000'000'000)));
  EXPECT_EQ(mode_arbiter.since_s(Reason::map_differs), later(-86400).seconds);
}

}  // namespace
}  // namespace airside
