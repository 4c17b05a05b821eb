// Baselines through run_method, the way of `airside simulate` and `airside study`.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "support/default_cycle.hpp"
#include "tools/baselines/baseline.hpp"
#include "tools/study/control_methods.hpp"

namespace airside::tools {
namespace {

ControlRun two_days_of(const std::string& method) {
  Trial trial{built_in_site(), {}, 1, 2};
  trial.plant.kind = "rc";
  trial.plant.room = "301-real";
  trial.plant.start = "2021-08-01";
  Prepared prepared = prepare(trial);
  return run_method(trial, prepared, method);
}

/// Rows that hold another setpoint than the row before, on the cycle's instants and between them.
struct Moves {
  int on_cycle = 0, between = 0;
};
Moves moves_of(const ControlRun& run) {
  Moves moves;
  for (std::size_t i = 1; i < run.rows.size(); ++i) {
    if (run.rows[i].setpoint_degc == run.rows[i - 1].setpoint_degc) continue;
    (starts_cycle(run.rows[i].time) ? moves.on_cycle : moves.between)++;
  }
  return moves;
}

TEST(RunMethod, Guideline36MovesTheSetpointAtItsOwnPeriodBetweenCyclesToo) {
  const ControlRun run = two_days_of("g36-site-i0");
  const Moves moves = moves_of(run);
  EXPECT_GT(moves.on_cycle, 10);
  EXPECT_GT(moves.between, 10);  // two of three rows lie between cycles
  // Trim is 0.1 K each 2 min: a row's step up in working hours is 0.3 K, never a cycle's 0.9 K nor a third of its due.
  double largest = 0;
  for (std::size_t i = 1; i < run.rows.size(); ++i) {
    const int second = run.rows[i].time.second_of_day();
    if (second <= 8 * 3600 || second >= 19 * 3600) continue;
    largest = std::max(largest, run.rows[i].setpoint_degc - run.rows[i - 1].setpoint_degc);
  }
  EXPECT_NEAR(largest, 0.3, 1e-6);
}

TEST(RunMethod, DarvIsTakenOnCyclesWhateverTheMethodsPeriod) {
  const ControlRun run = two_days_of("g36-site-i0");
  ASSERT_EQ(run.cycles.size(), 2U * cycles_per_day);
  for (const CycleSample& c : run.cycles) {
    ASSERT_TRUE(starts_cycle(c.time));
    const auto row = std::find_if(run.rows.begin(), run.rows.end(), [&](const auto& r) { return r.time == c.time; });
    ASSERT_NE(row, run.rows.end());
    EXPECT_EQ(c.setpoint_degc, row->setpoint_degc);
  }
}

TEST(RunMethod, AMethodOfTheCycleHoldsItsSetpointBetweenCycles) {
  const Moves moves = moves_of(two_days_of("pid-tuned"));
  EXPECT_GT(moves.on_cycle, 40);
  EXPECT_EQ(moves.between, 0);
}

TEST(RunMethod, HeedsTheDaysBeforeWhereTheMethodSaysSo) {
  Trial trial{built_in_site(), {}, 1, 1};
  trial.plant.kind = "rc";
  trial.plant.room = "301-real";
  const auto setpoints = [&trial](const std::string& method, bool other_days) {
    Prepared prepared = prepare(trial);
    for (std::size_t i = 0; other_days && i < prepared.history.size(); ++i) {
      hal::LogRow& row = prepared.history[i];
      row.setpoint_degc = 21 + static_cast<double>(i / 30 % 4);
      for (std::size_t room = 0; room < 5; ++room) row.value[room] += 0.2 * static_cast<double>(i / 45 % 3);
    }
    std::vector<double> held;
    for (const hal::LogRow& row : run_method(trial, prepared, method).rows) held.push_back(row.setpoint_degc);
    return held;
  };
  int heeding = 0;
  for (const std::string& name : baseline_names()) {
    const bool heeds = make_baseline(name, trial.site.settings)->heeds_history();
    heeding += heeds ? 1 : 0;
    EXPECT_EQ(setpoints(name, false) != setpoints(name, true), heeds) << name;
  }
  EXPECT_GE(heeding, 4);
}

TEST(RunMethod, Guideline36AsWrittenReachesItsMinimumBelowTheSitesLimits) {
  const auto lowest = [](const std::string& method) {
    double low = 99;
    for (const hal::LogRow& row : two_days_of(method).rows) low = std::min<double>(low, row.setpoint_degc);
    return low;
  };
  EXPECT_NEAR(lowest("g36-written-16"), 12.0, 1e-6);
  EXPECT_GE(lowest("g36-site-i0"), built_in_site().settings.action_min_degc - 1e-6);
}

}  // namespace
}  // namespace airside::tools
