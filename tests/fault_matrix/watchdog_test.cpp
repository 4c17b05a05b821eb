// Row 42: a control thread that is starved is found by the watchdog, which only completed rows kick; and the real
// daemon under a supervisor that speaks systemd's protocol goes on as if nothing had been.

#include <gtest/gtest.h>
#include <string>
#include <vector>

#include "fault_matrix/notify_socket.hpp"
#include "support/bench.hpp"

namespace airside::fault_matrix {
namespace {

using closed_loop::Bench;
using closed_loop::Child;

struct Supervised {
  int ready = 0, kicks = 0, other = 0, restarts = 0, kicks_before_ready = 0;
  bool ended_in_order = false;
};

/// What systemd does with Type=notify, Restart=always and WatchdogSec=silence_s: a daemon that is silent for so long is
/// killed and started again. `strike` is called after each kick with the number of kicks so far.
template <class Strike>
Supervised supervise(Bench& bench, const NotifySocket& manager, double silence_s, Strike strike) {
  Supervised seen;
  auto daemon = bench.start_daemon();
  bool ready = false;
  double heard_s = closed_loop::now_s();
  while (true) {
    const bool running = daemon->running();  // asked before the socket: a word of its last moments is still heard
    const std::string word = manager.next(running ? 0.05 : 0.0);
    if (!word.empty()) heard_s = closed_loop::now_s();
    if (word == "READY=1") {
      ++seen.ready;
      ready = true;
    } else if (word == "WATCHDOG=1") {
      ++seen.kicks;
      seen.kicks_before_ready += ready ? 0 : 1;
      strike(seen.kicks, *daemon);
    } else if (!word.empty()) {
      ++seen.other;
    } else if (!running) {
      seen.ended_in_order = daemon->wait(0) == 0;
      return seen;
    } else if (closed_loop::now_s() - heard_s > silence_s) {
      daemon->signal(SIGKILL);
      (void)daemon->wait(10);
      ++seen.restarts;
      ready = false;
      if (seen.restarts > 3) return seen;
      daemon = bench.start_daemon();
      heard_s = closed_loop::now_s();
    }
  }
}

Bench watched_day(const std::string& name, const char* more_site = closed_loop::brief_learning) {
  return Bench({.name = name, .plant = closed_loop::rc_room(), .expert_days = 1, .days = 1, .more_site = more_site});
}

constexpr double silence_s = 3.0;  // a simulated row takes milliseconds

TEST(Watchdog, Row42AStarvedControlThreadIsFoundAndItsSuccessorGoesOnExactly) {
  Bench bench = watched_day("starved");
  const auto& expected = bench.expected();
  bench.start_server();
  const NotifySocket manager(bench.file("notify"), silence_s);
  const Supervised seen = supervise(bench, manager, silence_s, [](int kicks, const Child& daemon) {
    if (kicks == 50) daemon.signal(SIGSTOP);
  });
  EXPECT_EQ(seen.restarts, 1) << "no kick may come from a thread that does not run";
  EXPECT_EQ(seen.ready, 2);
  EXPECT_TRUE(seen.ended_in_order);
  closed_loop::expect_same_rows(bench.log(), expected);
}

TEST(Watchdog, Row42WithoutStarvationEachRowKicksOnceAndNobodyIsRestarted) {
  // A row takes milliseconds and a socket holds ten words that nobody has read yet, then drops: where this process
  // waits 50 ms for a processor, a word is lost that was said.
  Bench bench = watched_day("kicks", "");
  const auto& expected = bench.expected();
  bench.start_server();
  const NotifySocket manager(bench.file("notify"), 60);
  const Supervised seen = supervise(bench, manager, 60, [](int, const Child&) {});
  EXPECT_EQ(seen.restarts, 0);
  EXPECT_EQ(seen.ready, 1);
  EXPECT_EQ(seen.kicks_before_ready, 0);
  EXPECT_LE(seen.kicks, rows_per_day) << "one a completed row, and none besides";
  EXPECT_GE(seen.kicks, rows_per_day * 19 / 20) << "one a completed row";
  EXPECT_EQ(seen.other, 0);
  EXPECT_TRUE(seen.ended_in_order);
  closed_loop::expect_same_rows(bench.log(), expected);
}

TEST(Watchdog, Row42RowsThatDoNotComeToTheirEndKickNothing) {
  // The daemon itself is well, but its simulated plant, whose clock it follows, stands still: no row, no kick.
  Bench bench = watched_day("still");
  bench.start_server();
  const NotifySocket manager(bench.file("notify"), silence_s);
  const auto daemon = bench.start_daemon();
  ASSERT_EQ(manager.next(30), "READY=1");
  for (int row = 0; row < 20; ++row) ASSERT_EQ(manager.next(30), "WATCHDOG=1");
  bench.stop_server();
  int late = 0;  // rows that were under way
  const double end_s = closed_loop::now_s() + 2;
  while (closed_loop::now_s() < end_s) late += manager.next(0.1).empty() ? 0 : 1;
  EXPECT_GE(bench.logged_rows(), 20U + static_cast<std::size_t>(late)) << "no kick without a row";
  EXPECT_TRUE(manager.next(1).empty());
  EXPECT_TRUE(daemon->running());
}

TEST(Watchdog, Row42WithoutAPlantAtTheStartTheDaemonIsReadyAndAliveWhileItWaits) {
  Bench bench({.name = "away", .plant = closed_loop::rc_room(), .expert_days = 0, .days = 1});
  const NotifySocket manager(bench.file("notify"), silence_s);
  const auto daemon = bench.start_daemon();  // nobody answers at the site's port
  EXPECT_EQ(manager.next(30), "READY=1");
  EXPECT_EQ(manager.next(30), "WATCHDOG=1");
  EXPECT_EQ(manager.next(30), "WATCHDOG=1");
  EXPECT_EQ(bench.logged_rows(), 0U);
}

TEST(Watchdog, AnIntervalThatALateRowWouldTripIsSaidAtTheStart) {
  Bench bench({.name = "short", .plant = closed_loop::rc_room(), .expert_days = 0, .days = 1});
  for (const double interval_s : {600.0, 900.0}) {
    const NotifySocket manager(bench.file(std::to_string(interval_s)), interval_s);
    const auto daemon = bench.start_daemon();
    ASSERT_EQ(manager.next(30), "READY=1");
    EXPECT_EQ(daemon->said().find("WatchdogSec is 600") != std::string::npos, true) << daemon->said();
    EXPECT_EQ(daemon->said().find("WatchdogSec is 900"), std::string::npos) << daemon->said();
  }
}

}  // namespace
}  // namespace airside::fault_matrix
