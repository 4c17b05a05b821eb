// Row 41: a daemon that keeps dying must not control; the schedule does, for an hour, and then it is tried again.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <utility>

#include "support/bench.hpp"

namespace airside::fault_matrix {
namespace {

using closed_loop::Bench;

constexpr std::size_t rows_an_hour = 3600 / row_s;

/// Starts the daemon, lets it log up to `rows` rows, and ends it by `signal`. Its words.
std::string start_and_end(Bench& bench, std::size_t rows, int signal) {
  const auto daemon = bench.start_daemon(false, {"--crash-limit", "3"});
  while (bench.logged_rows() < rows && daemon->running()) closed_loop::sleep_s(0.0005);
  daemon->signal(signal);
  EXPECT_EQ(daemon->wait(10), signal == SIGTERM ? 0 : 128 + signal) << daemon->said();
  return daemon->said();
}

bool is_held(const std::string& row) { return row.find(",expert,crash loop,") != std::string::npos; }

Bench crashing_day(const std::string& name) {
  return Bench({.name = name,
                .plant = closed_loop::rc_room(),
                .expert_days = 1,
                .days = 2,
                .more_site = closed_loop::brief_learning});
}

TEST(CrashLoop, Row41ThreeStartsInTenMinutesLeaveTheScheduleInControlForAnHour) {
  Bench bench = crashing_day("crash_loop");
  const auto& expected = bench.expected();
  bench.start_server();
  start_and_end(bench, 20, SIGKILL);
  start_and_end(bench, 40, SIGKILL);
  const std::size_t begun = bench.logged_rows();
  const std::string said = start_and_end(bench, begun + 4, SIGKILL);
  EXPECT_NE(said.find("3 starts within ten minutes"), std::string::npos) << said;
  const std::size_t again = bench.logged_rows();
  const auto daemon = bench.start_daemon(false, {"--crash-limit", "3"});
  ASSERT_EQ(daemon->wait(100), 0) << daemon->said();
  const closed_loop::LogText log = bench.log();
  ASSERT_EQ(log.rows.size(), expected.rows.size());
  ASSERT_GT(begun, 1U);
  // The last row before a kill may be repeated by the successor, and shows the decision in force until the next one:
  // hence from one row before a start, and from three after it. How far each daemon came is the machine's affair.
  constexpr std::size_t settles = 3;
  for (std::size_t row = 0; row + 1 < begun; ++row) ASSERT_EQ(log.rows[row], expected.rows[row]) << row;
  for (const auto& [from, until] : {std::pair(begun, again), std::pair(again, log.rows.size())}) {
    for (std::size_t row = from + settles; row < std::min(from - 1 + rows_an_hour, until); ++row) {
      EXPECT_TRUE(is_held(log.rows[row])) << "each start in the loop begins the hour anew: " << log.rows[row];
    }
    for (std::size_t row = from + rows_an_hour + settles; row + 1 < until; ++row) {
      ASSERT_FALSE(is_held(log.rows[row])) << "after an hour it is tried again: " << log.rows[row];
    }
  }
  ASSERT_LT(again + rows_an_hour + settles, log.rows.size()) << "the day must be long enough to be tried again";
  EXPECT_NE(log.rows[again + rows_an_hour + settles].find(",learn,"), std::string::npos);
}

TEST(CrashLoop, Row41WithoutACrashThreeStartsInTenMinutesDisturbNothing) {
  Bench bench = crashing_day("restarts");
  const auto& expected = bench.expected();
  bench.start_server();
  for (const std::size_t rows : {20U, 40U, 60U}) start_and_end(bench, rows, SIGTERM);
  const auto daemon = bench.start_daemon(false, {"--crash-limit", "3"});
  ASSERT_EQ(daemon->wait(100), 0) << daemon->said();
  closed_loop::expect_same_rows(bench.log(), expected);
}

}  // namespace
}  // namespace airside::fault_matrix
