// Civil time, the loop's way with clocks, the schedule's edges, and the one random generator.

#include <gtest/gtest.h>

#include <set>
#include <vector>

#include "airside/controller/cycle.hpp"
#include "airside/controller/decision.hpp"
#include "airside/presets.hpp"
#include "airside/splitmix64.hpp"
#include "airside/supervision/envelope.hpp"
#include "airside/supervision/schedule.hpp"
#include "support/default_cycle.hpp"
#include "unit/monday.hpp"

namespace airside {
namespace {

constexpr CivilTime at(int day, int hour, int minute, int second = 0) {
  return {monday.seconds + day * 86400LL + hour * 3600 + minute * 60 + second};
}

TEST(CivilTime, KnowsWeekdays) {
  EXPECT_EQ(CivilTime{0}.weekday(), 3) << "1970-01-01 was a Thursday";
  EXPECT_EQ(monday.weekday(), 0);
  EXPECT_EQ(at(5, 23, 59).weekday(), 5);
  EXPECT_EQ(at(6, 0, 0).weekday(), 6);
  EXPECT_EQ(CivilTime{951'782'400}.weekday(), 1) << "2000-02-29 was a Tuesday";
}

TEST(CivilTime, CountsBackwardsBefore1970) {
  const CivilTime t{-1};
  EXPECT_EQ(t.day(), -1);
  EXPECT_EQ(t.second_of_day(), 86399);
  EXPECT_EQ(t.weekday(), 2);
  EXPECT_EQ(CivilTime{-86400}.day(), -1);
  EXPECT_EQ(CivilTime{-86400}.second_of_day(), 0);
}

TEST(CivilTime, HasEightyCyclesADayAlignedAtMidnight) {
  int starts = 0;
  for (int row = 0; row < rows_per_day; ++row) starts += starts_cycle({monday.seconds + row * row_s});
  EXPECT_EQ(starts, 80);
  EXPECT_TRUE(starts_cycle(monday));
  EXPECT_EQ(cycle_of_day(at(0, 7, 12)), 24);
  EXPECT_EQ(cycle_of_day(at(0, 18, 54)), 63);
  EXPECT_EQ(cycle_of_day(at(0, 23, 59, 59)), 79);
}

TEST(ControlCycle, IsOfOneToFourRowsAndDividesTheDay) {
  for (const int minutes : {6, 12, 18, 24}) {
    ASSERT_TRUE(is_cycle_min(minutes));
    const ControlCycle cycle = cycle_of_minutes(minutes);
    EXPECT_EQ(cycle.minutes(), minutes);
    int starts = 0;
    for (int row = 0; row < rows_per_day; ++row) starts += cycle.starts({monday.seconds + row * row_s});
    EXPECT_EQ(starts, cycle.per_day());
    EXPECT_EQ(starts * minutes, 24 * 60);
    EXPECT_EQ(cycle.of_day(at(0, 23, 59, 59)), starts - 1);
  }
  for (const int minutes : {-6, 0, 1, 10, 15, 30, 36, 60}) EXPECT_FALSE(is_cycle_min(minutes)) << minutes;
  EXPECT_EQ(default_cycle.minutes(), 18);
}

TEST(ControlCycle, OfASiteIsOneThatItsObjectiveHas) {
  for (const int minutes : {6, 10, 12, 18, 24}) {
    ControllerSettings s = product_settings();
    s.cycle_min = minutes;
    EXPECT_EQ(settings_valid(s), minutes != 10) << minutes;
    s.objective = Objective::band;
    EXPECT_EQ(settings_valid(s), minutes == 18) << minutes;
  }
}

TEST(CivilTime, NextRowIsAtOrAfter) {
  EXPECT_EQ(next_row(at(0, 0, 6)), at(0, 0, 6));
  EXPECT_EQ(next_row(at(0, 0, 6, 1)), at(0, 0, 12));
  EXPECT_EQ(next_row({-1}).seconds, 0);
  EXPECT_EQ(next_row({-360}).seconds, -360);
}

/// A plant that always answers, and a clock that somebody sets right once, after so many rows.
struct AnsweringPlant {
  Expected<Reading<FiveZone>> sense() { return Reading<FiveZone>{}; }
  Expected<Applied> actuate(const Command& command) { return Applied{command.setpoint_degc()}; }
};
struct CorrectedClock {
  CivilTime time;
  std::int64_t correction_s = 0;
  int rows_before = 0;
  std::int64_t suspended_s = 0;  ///< in the third sleep
  int sleeps = 0;
  CivilTime now() {
    if (rows_before-- == 0) time.seconds += correction_s;
    return time;
  }
  bool sleep_until(CivilTime t) {
    time = std::max(time, t);
    if (++sleeps == 3) time.seconds += suspended_s;
    return true;
  }
  CivilTime woke() const { return time; }
};
struct Schedule {
  Decision last{.time = {}, .command = SafetyEnvelope(paper_settings()).limit(25, 25, 25)};
  ControllerSettings site = paper_settings();
  const ControllerSettings& settings() const { return site; }
  int decisions = 0;
  const Decision& decide(CivilTime, const Expected<Reading<FiveZone>>&) {
    ++decisions;
    return last;
  }
  void absorb(const Decision&, const Expected<Applied>&) {}
  void observe(CivilTime, const Expected<Reading<FiveZone>>&) {}
};
struct Times {
  std::vector<CivilTime> rows;
  bool row(CivilTime t, const Expected<Reading<FiveZone>>&, const Schedule&) {
    rows.push_back(t);
    return rows.size() < 6;
  }
};
std::vector<CivilTime> rows_with(std::int64_t correction_s) {
  AnsweringPlant plant;
  CorrectedClock clock{at(0, 12, 0), correction_s, 2};
  Schedule controller;
  Times times;
  run_cycles<FiveZone>(plant, clock, controller, times, at(0, 12, 0), at(2, 0, 0));
  return times.rows;
}

TEST(RunCycles, DecideOnceACycleOfTheSite) {
  for (const int minutes : {6, 12, 18, 24}) {
    AnsweringPlant plant;
    CorrectedClock clock{at(0, 0, 0), 0, -1};
    Schedule controller;
    controller.site.cycle_min = minutes;
    struct {
      bool row(CivilTime, const Expected<Reading<FiveZone>>&, const Schedule&) { return true; }
    } sink;
    run_cycles<FiveZone>(plant, clock, controller, sink, at(0, 0, 0), at(1, 0, 0));
    EXPECT_EQ(controller.decisions, 24 * 60 / minutes);
  }
}

TEST(RunCycles, FollowsAClockThatIsSetBackInsteadOfWaitingForIt) {
  const auto rows = rows_with(-3 * 3600);
  ASSERT_EQ(rows.size(), 6U);
  EXPECT_EQ(rows[2], at(0, 12, 12));
  EXPECT_EQ(rows[3], at(0, 9, 12));
  EXPECT_EQ(rows[4], at(0, 9, 18));
}

TEST(RunCycles, WaitsOutASmallCorrectionAndRepeatsNoRow) {
  const auto rows = rows_with(-400);
  ASSERT_EQ(rows.size(), 6U);
  for (std::size_t i = 0; i < rows.size(); ++i) EXPECT_EQ(rows[i], at(0, 12, 6 * static_cast<int>(i)));
}

TEST(RunCycles, SkipsTheRowsThatAClockJumpsOver) {
  const auto rows = rows_with(3600);
  ASSERT_EQ(rows.size(), 6U);
  EXPECT_EQ(rows[2], at(0, 12, 12));
  EXPECT_EQ(rows[3], at(0, 13, 12));
}

TEST(RunCycles, Row31ARowThatTheMachineSleptThroughIsLeftOutAndControlGoesOnWhereItWoke) {
  for (const std::int64_t away_s : {359, 360, 7250}) {
    AnsweringPlant plant;
    CorrectedClock clock{.time = at(0, 12, 0), .rows_before = -1, .suspended_s = away_s};
    Schedule controller;
    Times times;
    run_cycles<FiveZone>(plant, clock, controller, times, at(0, 12, 0), at(2, 0, 0));
    ASSERT_EQ(times.rows.size(), 6U);
    const CivilTime third = away_s == 359 ? at(0, 12, 12) : away_s == 360 ? at(0, 12, 18) : at(0, 14, 18);
    EXPECT_EQ(times.rows[1], at(0, 12, 6));
    EXPECT_EQ(times.rows[2], third) << away_s;
    EXPECT_EQ(times.rows[3].seconds, third.seconds + row_s) << away_s;
  }
}

TEST(ExpertSchedule, Row29WithoutItChangesAtSevenAndAtNineteen) {
  const ControllerSettings s = paper_settings();
  EXPECT_EQ(expert_setpoint_degc(s, at(0, 6, 59, 59)), 25.0);
  EXPECT_EQ(expert_setpoint_degc(s, at(0, 7, 0)), 20.5);
  EXPECT_EQ(expert_setpoint_degc(s, at(0, 18, 59, 59)), 20.5);
  EXPECT_EQ(expert_setpoint_degc(s, at(0, 19, 0)), 25.0);
  EXPECT_EQ(expert_setpoint_degc(s, at(0, 0, 0)), 25.0);
}

TEST(ExpertSchedule, KnowsDaysOffOnlyWhereTheSiteHasThem) {
  ControllerSettings s = paper_settings();
  EXPECT_EQ(expert_setpoint_degc(s, at(5, 12, 0)), 20.5);
  s.weekday_only = 1;
  EXPECT_EQ(expert_setpoint_degc(s, at(4, 12, 0)), 20.5);
  EXPECT_EQ(expert_setpoint_degc(s, at(5, 12, 0)), 25.0);
  EXPECT_EQ(expert_setpoint_degc(s, at(6, 12, 0)), 25.0);
  EXPECT_EQ(expert_setpoint_degc(s, at(7, 12, 0)), 20.5);
}

TEST(ExpertSchedule, TakesHalfHours) {
  ControllerSettings s = paper_settings();
  s.work_start_h = 7.5;
  EXPECT_FALSE(in_working_hours(s, at(0, 7, 29, 59)));
  EXPECT_TRUE(in_working_hours(s, at(0, 7, 30)));
}

TEST(SplitMix64, GivesTheReferenceNumbers) {
  SplitMix64 g(1234567);  // published with the algorithm
  for (const std::uint64_t expected : {6457827717110365317u, 3203168211198807973u, 9817491932198370423u,
                                       4593380528125082431u, 16408922859458223821u}) {
    EXPECT_EQ(g.next(), expected);
  }
}

TEST(SplitMix64, GoesOnFromItsState) {
  SplitMix64 g(9);
  for (int i = 0; i < 10; ++i) (void)g.next();
  SplitMix64 again(g.state());
  EXPECT_EQ(again.next(), g.next());
}

TEST(SplitMix64, StaysInItsRanges) {
  SplitMix64 g(4);
  std::set<std::uint32_t> seen;
  for (int i = 0; i < 10000; ++i) {
    const double u = g.uniform(), v = g.symmetric();
    ASSERT_TRUE(u >= 0 && u < 1 && v >= -1 && v < 1);
    seen.insert(g.below(7));
  }
  EXPECT_EQ(seen.size(), 7U);
  EXPECT_EQ(*seen.rbegin(), 6U);
  EXPECT_EQ(g.below(1), 0U);
}

constexpr std::int64_t hours(double h) { return static_cast<std::int64_t>(h * 3600); }

TEST(DaylightSaving, TheEuropeanOneChangesAtOneOClockUniversalTime) {
  constexpr auto eu = DaylightSaving::european_union;
  // 2024-03-31 and 2024-10-27 in central Europe (standard time is an hour east)
  constexpr CivilTime spring{1'711'843'200 + hours(2)}, autumn{1'729'987'200 + hours(2)};
  EXPECT_EQ(local_time(eu, 1, {spring.seconds - 1}).seconds, spring.seconds - 1);
  EXPECT_EQ(local_time(eu, 1, spring).seconds, spring.seconds + 3600);
  EXPECT_EQ(local_time(eu, 1, {autumn.seconds - 1}).seconds, autumn.seconds - 1 + 3600);
  EXPECT_EQ(local_time(eu, 1, autumn).seconds, autumn.seconds);
  EXPECT_EQ(local_time(eu, 2, {spring.seconds + hours(1) - 1}).seconds, spring.seconds + hours(1) - 1)
      << "an hour further east it is an hour later";
}

TEST(DaylightSaving, TheAmericanOneChangesAtTwoOnTheWall) {
  constexpr auto us = DaylightSaving::united_states;
  constexpr CivilTime spring{1'710'028'800 + hours(2)}, autumn{1'730'592'000 + hours(1)};  // 2024-03-10, 2024-11-03
  EXPECT_EQ(local_time(us, -5, {spring.seconds - 1}).seconds, spring.seconds - 1);
  EXPECT_EQ(local_time(us, -5, spring).seconds, spring.seconds + 3600);
  EXPECT_EQ(local_time(us, -5, {autumn.seconds - 1}).seconds, autumn.seconds - 1 + 3600);
  EXPECT_EQ(local_time(us, -5, autumn).seconds, autumn.seconds);
}

TEST(DaylightSaving, Row29EveryRowExistsOnceOnDaysOf23And25Hours) {
  // The schedule begins at seven on the wall on all three days, and a day always has 80 cycles.
  ControllerSettings s = product_settings();
  s.daylight_saving = 1;
  s.utc_offset_h = 1;
  for (const std::int64_t midnight : {1'711'843'200LL, 1'729'987'200LL, 1'720'000'000LL / 86400 * 86400}) {
    int cycles = 0;
    for (std::int64_t t = midnight; t < midnight + 86400; t += row_s) cycles += starts_cycle({t});
    EXPECT_EQ(cycles, cycles_per_day);
  }
  const std::int64_t spring = 1'711'843'200, autumn = 1'729'987'200;
  EXPECT_FALSE(in_working_hours(s, {spring + hours(6) - 1})) << "six standard is seven on the wall";
  EXPECT_TRUE(in_working_hours(s, {spring + hours(6)}));
  EXPECT_FALSE(in_working_hours(s, {autumn + hours(7) - 1}));
  EXPECT_TRUE(in_working_hours(s, {autumn + hours(7)}));
  s.daylight_saving = 0;
  EXPECT_FALSE(in_working_hours(s, {spring + hours(6)}));
}

}  // namespace
}  // namespace airside
