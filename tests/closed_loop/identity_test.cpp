// The same plant, seed and weather: airsided over Modbus and the simulation in one process write the same log,
// setpoints and controller columns included, to the bit.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <set>

#include "support/bench.hpp"

namespace airside::closed_loop {
namespace {

/// Setpoints that the controller, not the schedule, has chosen.
int setpoints_of(const tools::ControlRun& run) {
  std::set<double> different;
  for (const tools::CycleSample& c : run.cycles) different.insert(c.setpoint_degc);
  return static_cast<int>(different.size());
}

void run_and_compare(Bench& bench, bool sync, double timeout_s) {
  const LogText& expected = bench.expected();
  ASSERT_EQ(expected.rows.size(), bench.rows());
  EXPECT_GT(setpoints_of(bench.run()), 20) << "a run without decisions proves nothing";
  bench.start_server();
  const double began_s = now_s();
  const auto daemon = bench.start_daemon(sync);
  ASSERT_EQ(daemon->wait(timeout_s), 0) << daemon->said();
  expect_same_rows(bench.log(), expected);
  std::printf("%zu rows, %zu cycles over Modbus in %.1f s\n", expected.rows.size(), bench.run().cycles.size(),
              now_s() - began_s);
}

TEST(ClosedLoop, DaemonOverTcpDecidesAsTheSimulationToTheBit) {
  Bench bench({.name = "tcp", .plant = rc_room(), .expert_days = 5, .days = from_environment("AIRSIDE_LOOP_DAYS", 14)});
  run_and_compare(bench, false, 400);
}

TEST(ClosedLoop, DaemonThatForcesEveryRowToTheDiskDecidesTheSame) {
  Bench bench({.name = "sync", .plant = rc_room("401"), .expert_days = 1, .days = 1, .in_memory = false});
  run_and_compare(bench, true, 200);
}

TEST(ClosedLoop, DaemonOverSerialLineDecidesAsTheSimulationToTheBit) {
  Bench bench({.name = "rtu", .plant = rc_room("701"), .expert_days = 1, .days = 1, .serial = true});
  run_and_compare(bench, false, 200);
}

TEST(ClosedLoop, DaemonOfEveryShapeDecidesAsTheSimulationToTheBit) {
  for (const std::string topology :
       {"3vav-0fcu-1power", "8vav-4fcu-2power", "1vav-0fcu-0power", "12vav-0fcu-1power", "32vav-32fcu-8power"}) {
    SCOPED_TRACE(topology);
    Bench bench({.name = "shape", .topology = topology, .plant = rc_room(), .expert_days = 1, .days = 1});
    run_and_compare(bench, false, 100);
  }
}

TEST(ClosedLoop, SimulateCommandWritesTheRowsOfTheSharedLoop) {
  Bench bench({.name = "command", .plant = rc_room("402"), .expert_days = 2, .days = 2});
  const LogText& expected = bench.expected();
  const std::string out = bench.file("out.csv"), history = bench.file("history_again.csv");
  Child simulate({bench.program("airside"),
                  "simulate",
                  "--site",
                  bench.file("site.toml"),
                  "--plant",
                  "rc",
                  "--room",
                  "402",
                  "--start",
                  "2021-08-01",
                  "--seed",
                  "7",
                  "--expert-days",
                  "2",
                  "--days",
                  "2",
                  "--weights",
                  bench.file("weights.blob"),
                  "--log",
                  out,
                  "--history-log",
                  history,
                  "--json"},
                 bench.file("simulate.txt"));
  ASSERT_EQ(simulate.wait(100), 0) << simulate.said();
  LogText log;
  std::ifstream in(out);
  std::getline(in, log.header);
  for (std::string line; std::getline(in, line);) log.rows.push_back(line);
  expect_same_rows(log, expected);
  // The history that it writes is the one that the daemon remembers, and the run goes on where it ends.
  const hal::Log past = hal::read_log(history, bench.trial().site.counts);
  EXPECT_EQ(past.rows.size(), 2U * rows_per_day);
  EXPECT_EQ(past.rows.back().time.seconds + row_s, bench.run().rows.front().time.seconds);
}

TEST(ClosedLoop, AnotherSeedOfLearningShowsInTheLog) {
  // The comparison can fail: one other seed of the sampler, and the rows differ.
  Bench bench({.name = "seed", .plant = rc_room(), .expert_days = 1, .days = 1});
  const LogText expected = bench.expected();
  tools::Trial other = bench.trial();
  tools::Prepared again = tools::prepare(other);
  const auto blob = tools::read_blob(bench.file("weights.blob").string(), other.site);
  const auto run = tools::run_controller(other.site, *again.model, blob, again.history, again.until, 8);
  ASSERT_EQ(run.cycles.size(), bench.run().cycles.size());
  int differ = 0;
  for (std::size_t i = 0; i < run.rows.size(); ++i) {
    differ += run.rows[i].controller.loss_strb != bench.run().rows[i].controller.loss_strb &&
              !std::isnan(run.rows[i].controller.loss_strb);
  }
  EXPECT_GT(differ, 40);
}

}  // namespace
}  // namespace airside::closed_loop
