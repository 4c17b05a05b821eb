// Which pairs of logged rows are transitions (docs/method.md, open point 1).

#include "airside/learning/row_window.hpp"

#include <gtest/gtest.h>

#include <functional>

#include "airside/presets.hpp"
#include "airside/supervision/schedule.hpp"
#include "support/default_cycle.hpp"
#include "unit/monday.hpp"

namespace airside {
namespace {

using T = FiveZone;
using Vector = Reading<T>::Vector;

struct Counts {
  int transitions = 0, with_change_before = 0;
};

Counts count(int rows, const std::function<double(CivilTime)>& setpoint_at_cycle) {
  RowWindow<T> window;
  Counts n;
  double setpoint = 25;
  for (int i = 0; i < rows; ++i) {
    const CivilTime t{monday.seconds + i * row_s};
    if (starts_cycle(t)) setpoint = setpoint_at_cycle(t);
    window.push(t, Vector::Constant(25), setpoint);
    n.transitions += window.has_transition();
    n.with_change_before += window.has_change_before();
  }
  return n;
}

TEST(RowWindow, FiveDaysUnderOneSetpointGive1197Pairs) {
  EXPECT_EQ(count(1200, [](CivilTime) { return 25.0; }).transitions, 1197);
}

TEST(RowWindow, FiveScheduleDaysLoseTheTwoPairsThatSpanEachChange) {
  const ControllerSettings s = paper_settings();
  const Counts n = count(1200, [&](CivilTime t) { return expert_setpoint_degc(s, t); });
  EXPECT_EQ(n.transitions, 1197 - 10 * 2);
  EXPECT_LT(n.with_change_before, n.transitions);
  EXPECT_GT(n.with_change_before, 1100);
}

TEST(RowWindow, UnderTheAgentOnlyTheAlignedPairsCount) {
  int cycle = 0;
  const Counts n = count(1200, [&](CivilTime) { return 20.0 + 0.1 * (++cycle % 50); });
  EXPECT_EQ(n.transitions, 5 * cycles_per_day - 1);
}

TEST(RowWindow, ATransitionHoldsItsOwnRows) {
  RowWindow<T> window;
  for (int i = 0; i < 20; ++i) window.push({monday.seconds + i * row_s}, Vector::Constant(i), 25);
  EXPECT_EQ(window.at(0).value(0), 19);
  EXPECT_EQ(window.at(rows_per_cycle).value(0), 16);
  EXPECT_EQ(window.at(rows_per_cycle).time.seconds, monday.seconds + 16 * row_s);
}

TEST(RowWindow, HoldsTheRowsOfEachLengthOfTheCycle) {
  for (const int n : {1, 2, 4}) {
    const ControlCycle cycle{n};
    RowWindow<T> window(cycle);
    int transitions = 0, with_change = 0;
    double setpoint = 20;
    for (int i = 0; i < rows_per_day; ++i) {
      const CivilTime t{monday.seconds + i * row_s};
      if (cycle.starts(t)) setpoint = setpoint == 20 ? 21 : 20;
      window.push(t, Vector::Constant(i), setpoint);
      if (!window.has_transition()) continue;
      ++transitions;
      EXPECT_TRUE(cycle.starts(t)) << "the setpoint changes each cycle, so that only whole ones count";
      EXPECT_EQ(window.at(n).value(0), i - n);
      EXPECT_EQ(window.at(n).time.seconds, t.seconds - cycle.seconds());
      if (!window.has_change_before()) continue;
      ++with_change;
      EXPECT_EQ(window.at(2 * n).value(0), i - 2 * n);
      EXPECT_EQ(window.setpoint_degc(3 * n), window.setpoint_degc(n));
      EXPECT_NE(window.setpoint_degc(2 * n), window.setpoint_degc(n));
    }
    EXPECT_EQ(transitions, cycle.per_day() - 1) << n;
    EXPECT_EQ(with_change, cycle.per_day() - 3) << n;
  }
}

TEST(RowWindow, IsNoLargerThanTenRows) { EXPECT_LE(sizeof(RowWindow<T>), 10 * sizeof(RowWindow<T>::Row) + 64); }

TEST(RowWindow, AGapADoubleAndAHoleEachBeginAnew) {
  const auto pairs_after = [](const std::function<void(RowWindow<T>&, CivilTime)>& disturb) {
    RowWindow<T> window;
    for (int i = 0; i < 10; ++i) window.push({monday.seconds + i * row_s}, Vector::Constant(25), 25);
    EXPECT_TRUE(window.has_transition());
    const CivilTime next{monday.seconds + 10 * row_s};
    disturb(window, next);
    return window.has_transition();
  };
  EXPECT_TRUE(pairs_after([](auto& w, CivilTime t) { w.push(t, Vector::Constant(25), 25); }));
  EXPECT_FALSE(pairs_after([](auto& w, CivilTime t) { w.push({t.seconds + row_s}, Vector::Constant(25), 25); }));
  EXPECT_FALSE(pairs_after([](auto& w, CivilTime t) { w.push({t.seconds - row_s}, Vector::Constant(25), 25); }));
  EXPECT_FALSE(pairs_after([](auto& w, CivilTime t) { w.push(t, Vector::Constant(std::nan("")), 25); }));
  EXPECT_FALSE(pairs_after([](auto& w, CivilTime t) { w.push(t, Vector::Constant(25), std::nan("")); }));
}

}  // namespace
}  // namespace airside
