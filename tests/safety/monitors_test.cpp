// What takes days to see: each watch fires on its fault and rests where there is none.

#include "airside/supervision/monitors.hpp"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>

#include "airside/presets.hpp"
#include "airside/splitmix64.hpp"
#include "airside/supervision/write_budget.hpp"
#include "support/default_cycle.hpp"

namespace airside {
namespace {

TEST(AuthorityMonitor, TellsRoomsThatDoNotFollowFromRoomsOnTheirWay) {
  const ControllerSettings s = product_settings();
  AuthorityMonitor stuck, nearing, other_side, off_limit;
  CivilTime t{0};
  bool is_stuck = false;
  for (int row = 0; row < 40; ++row, t.seconds += row_s) {
    is_stuck = stuck.row(s, t, s.action_min_degc, s.target_degc + 2);
    EXPECT_EQ(is_stuck, row >= 20) << row;
    EXPECT_FALSE(nearing.row(s, t, s.action_min_degc, s.target_degc + 6 - 0.1 * row)) << "it cools all the time";
    EXPECT_FALSE(other_side.row(s, t, s.action_min_degc, s.target_degc - 2)) << "colder air would not help";
    EXPECT_FALSE(off_limit.row(s, t, s.action_min_degc + 0.2, s.target_degc + 2));
  }
  EXPECT_FALSE(stuck.row(s, t, s.action_min_degc, s.target_degc + 0.4)) << "near enough";
  for (int row = 0; row < 30; ++row, t.seconds += row_s) {
    is_stuck = stuck.row(s, t, s.action_max_degc, s.target_degc - 0.6);
  }
  EXPECT_TRUE(is_stuck) << "at the other end too";
}

using Rooms = Eigen::Matrix<double, 5, 1>;

/// Rooms that swing with the day, each in its own way, with noise.
Rooms rooms_at(int row, SplitMix64& draw) {
  Rooms v;
  for (int i = 0; i < 5; ++i) {
    const double day = 6.2831853 * row / rows_per_day;
    v(i) = 25 + 0.3 * i + (0.5 + 0.2 * i) * std::sin(day) + 0.1 * (draw.uniform() - 0.5);
  }
  return v;
}

/// Days until a sensor that drifts by `k_per_day` is noticed, -1 within 60 days.
double days_until_noticed(double k_per_day) {
  DriftMonitor<5> watch;
  SplitMix64 draw(4);
  for (int row = 0; row < 60 * rows_per_day; ++row) {
    Rooms v = rooms_at(row, draw);
    v(2) += k_per_day * row / rows_per_day;
    if (watch.row(v, product_settings().drift_k)) return static_cast<double>(row) / rows_per_day;
  }
  return -1;
}

TEST(DriftMonitor, NoticesASensorThatDriftsAFifthOfAKelvinADay) {
  const double days = days_until_noticed(0.2);
  EXPECT_GT(days, 3);
  EXPECT_LT(days, 20);
}

TEST(DriftMonitor, RestsWhereRoomsOnlySwing) { EXPECT_EQ(days_until_noticed(0), -1); }

TEST(ExcitationMonitor, NoticesASetpointThatRestsForADayAndForgetsItWhenItMoves) {
  ExcitationMonitor watch;
  for (int i = 0; i < cycles_per_day - 1; ++i)
    EXPECT_FALSE(watch.cycle(22, 0.05, cycles_per_day)) << "not before a day";
  EXPECT_TRUE(watch.cycle(22, 0.05, cycles_per_day));
  bool rests = true;
  for (int i = 0; i < 20; ++i) rests = watch.cycle(22 + 0.5 * (i % 2), 0.05, cycles_per_day);
  EXPECT_FALSE(rests);
}

TEST(ScheduleShadowMonitor, FindsTheScheduleCloserOnlyWhereItWouldBe) {
  const ControllerSettings s = product_settings();
  ScheduleShadowMonitor good, bad;
  for (int i = 0; i < 20; ++i) {
    good.cycle(s, s.target_degc + 0.05, 22.0, s.expert_work_degc, 0.6);
    bad.cycle(s, s.target_degc + 1.0, 22.0, s.expert_work_degc, 0.6);  // the schedule's 20.5 would be 0.9 K colder
  }
  EXPECT_FALSE(good.worse(s));
  EXPECT_TRUE(bad.worse(s));
  EXPECT_NEAR(bad.schedule_k(), 0.1, 1e-9);
}

TEST(ScheduleShadowMonitor, JudgesNothingBeforeItHasSeenHoursAndNothingThatIsNoNumber) {
  const ControllerSettings s = product_settings();
  ScheduleShadowMonitor watch;
  for (int i = 0; i < 11; ++i) watch.cycle(s, s.target_degc + 5, 26, s.expert_work_degc, 0.6);
  EXPECT_FALSE(watch.worse(s));
  for (int i = 0; i < 50; ++i) watch.cycle(s, std::nan(""), 26, s.expert_work_degc, 0.6);
  EXPECT_FALSE(watch.worse(s));
}

TEST(OverrideMonitor, OnlyTheThirdWithinADayIsAFight) {
  constexpr std::int64_t start_s = 1'700'000'000;
  OverrideMonitor daily;
  for (int day = 0; day < 10; ++day) EXPECT_FALSE(daily.third_in_a_day({start_s + day * 24 * seconds_per_hour})) << day;
  OverrideMonitor twice;
  for (int day = 0; day < 10; ++day) {
    EXPECT_FALSE(twice.third_in_a_day({start_s + day * 24 * seconds_per_hour})) << day;
    EXPECT_FALSE(twice.third_in_a_day({start_s + (day * 24 + 8) * seconds_per_hour})) << day;
  }
  OverrideMonitor fight;
  EXPECT_FALSE(fight.third_in_a_day({start_s}));
  EXPECT_FALSE(fight.third_in_a_day({start_s + 5 * seconds_per_hour}));
  EXPECT_TRUE(fight.third_in_a_day({start_s + 10 * seconds_per_hour}));
  EXPECT_TRUE(fight.third_in_a_day({start_s + 15 * seconds_per_hour}));
  EXPECT_FALSE(fight.third_in_a_day({start_s})) << "the clock was set back: the count begins anew";
}

TEST(PersistentCondition, LastsOnlyWithoutABreakAndStartsAnewWhenTheClockIsSetBack) {
  PersistentCondition spell;
  const CivilTime t{1'000'000};
  EXPECT_FALSE(spell.lasts(true, t, 600));
  EXPECT_TRUE(spell.lasts(true, {t.seconds + 600}, 600));
  EXPECT_FALSE(spell.lasts(false, {t.seconds + 900}, 600));
  EXPECT_FALSE(spell.lasts(true, {t.seconds + 1200}, 600));
  EXPECT_FALSE(spell.lasts(true, {t.seconds - 5000}, 600));
  EXPECT_TRUE(spell.lasts(true, {t.seconds - 4400}, 600));
}

TEST(PersistentCondition, DoesNotCountTimeInWhichNobodyLooked) {
  constexpr std::int64_t wanted_s = 5400, gap_s = 3600;
  PersistentCondition away;
  CivilTime t{1'000'000};
  const auto look_after = [&](std::int64_t passed_s) {
    t.seconds += passed_s;
    return away.lasts(true, t, wanted_s, gap_s);
  };
  EXPECT_FALSE(look_after(0));
  EXPECT_FALSE(look_after(2 * gap_s)) << "two moments two hours apart are no two hours";
  EXPECT_FALSE(look_after(gap_s));
  EXPECT_TRUE(look_after(1800)) << "looked at often enough";
  EXPECT_FALSE(look_after(200 * seconds_per_day)) << "a clock that was set";
  PersistentCondition over_nights;
  for (int day = 0; day < 2; ++day) {
    const CivilTime morning{t.seconds + day * seconds_per_day};
    EXPECT_EQ(over_nights.lasts(true, morning, seconds_per_day), day == 1) << "a fan that rests at night ends nothing";
  }
}

TEST(WriteBudget, KeepsItsAverageWhateverIsWished) {
  for (const double largest_k : {0.1, 0.6, 3.0, 6.0}) {
    WriteBudget budget;
    SplitMix64 draw(8);
    int writes = 0;
    constexpr int days = 200;
    for (int i = 0; i < days * cycles_per_day; ++i) {
      budget.earn(20, cycles_per_day);
      if (!budget.allows(largest_k * draw.symmetric(), 20)) continue;
      budget.spend(20);
      ++writes;
    }
    EXPECT_LE(writes, 20 * days + 20) << largest_k;
    EXPECT_GE(writes, 5 * days) << largest_k << ": it must still control";
  }
}

TEST(WriteBudget, ALargeMoveIsNeverLateAndASmallOneWaits) {
  WriteBudget budget;
  EXPECT_TRUE(budget.allows(4.5, 20)) << "the schedule's step, without a token";
  EXPECT_FALSE(budget.allows(0.3, 20));
  for (int i = 0; i < cycles_per_day; ++i) budget.earn(20, cycles_per_day);
  EXPECT_TRUE(budget.allows(0.06, 20)) << "rested for a day";
}

TEST(WriteBudget, WritesThatWereForcedForWeeksMakeADebtOfADay) {
  WriteBudget budget;
  for (int i = 0; i < 1000; ++i) budget.spend(20);
  int cycles = 0;
  while (!budget.allows(2, 20)) {
    budget.earn(20, cycles_per_day);
    ++cycles;
  }
  EXPECT_LE(cycles, 4) << "a move of 2 K";
  for (; !budget.allows(0.3, 20); ++cycles) budget.earn(20, cycles_per_day);
  EXPECT_LE(cycles, cycles_per_day * 3 / 2);
}

TEST(ScheduleShadowMonitor, LearnsNothingFromASetpointThatIsUnknown) {
  const ControllerSettings settings = product_settings();
  ScheduleShadowMonitor watch;
  watch.cycle(settings, 30.0, std::nan(""), 20.5, 0.5);
  EXPECT_TRUE(std::isnan(watch.ours_k())) << "not known yet";
  watch.cycle(settings, 30.0, 21.0, 20.5, 0.5);
  EXPECT_GT(watch.ours_k(), 0.0);
}

}  // namespace
}  // namespace airside
