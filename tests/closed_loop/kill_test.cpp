// However often the daemon is killed or stopped, it goes on as if nothing had been: the same rows, none lost, none
// twice.
//   AIRSIDE_LOOP_KILLS=n, AIRSIDE_LOOP_DAYS=n     so many kills (200) in so many simulated days (7)
//   AIRSIDE_SHAPE_KILLS=n, AIRSIDE_SHAPE_DAYS=n   the same (20, 1) of the sites of twelve boxes and of one
//   AIRSIDE_DAEMON=FILE                           an installed airsided instead of this build's

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "airside/splitmix64.hpp"
#include "support/bench.hpp"

namespace airside::closed_loop {
namespace {

/// Rows after which to strike, at random, ascending. Not before the third row: the first commit must stand, since
/// before it nothing tells a restarted daemon that the setpoint it finds was its own.
std::vector<std::size_t> moments(SplitMix64& draw, int n, std::size_t rows) {
  std::vector<std::size_t> at;
  for (int i = 0; i < n; ++i) at.push_back(3 + draw.below(static_cast<std::uint32_t>(rows - 6)));
  std::sort(at.begin(), at.end());
  return at;
}

/// Waits until the log has `rows` rows. False: the daemon ended before.
bool reach(Bench& bench, Child& daemon, std::size_t rows) {
  while (bench.logged_rows() < rows) {
    if (!daemon.running()) return false;
    sleep_s(0.0005);
  }
  return true;
}

void expect_whole_status(const Bench& bench) {
  std::ifstream in(bench.file("state") / "status.json");
  if (!in) return;
  const auto status = nlohmann::json::parse(in, nullptr, false);
  EXPECT_FALSE(status.is_discarded()) << "status.json is not whole";
}

/// Kills `kills` times at random instants, those of start-up included. Returns how many struck a running daemon.
/// A daemon that is ahead of the drawn rows is struck while it starts: on a machine of any speed the last kill comes
/// before the last row.
int kill_through(Bench& bench, int kills, bool sync, std::uint64_t seed) {
  SplitMix64 draw(seed);
  int struck = 0;
  for (const std::size_t rows : moments(draw, kills, bench.rows())) {
    const bool ahead = bench.logged_rows() > rows;
    const auto daemon = bench.start_daemon(sync);
    if (!reach(bench, *daemon, rows)) {
      ADD_FAILURE() << "ended before row " << rows << ": " << daemon->said();
      return struck;
    }
    sleep_s((ahead ? 0.003 : 0.03) * draw.uniform() * draw.uniform());
    daemon->signal(SIGKILL);
    struck += daemon->wait(10) == 128 + SIGKILL;
    expect_whole_status(bench);
  }
  const auto daemon = bench.start_daemon(sync);
  EXPECT_EQ(daemon->wait(300), 0) << daemon->said();
  return struck;
}

TEST(KilledDaemon, LogOfAWeekEqualsTheUndisturbedOne) {
  const int kills = from_environment("AIRSIDE_LOOP_KILLS", 200);
  const int days = from_environment("AIRSIDE_LOOP_DAYS", 7);
  Bench bench({.name = "kill", .plant = rc_room(), .expert_days = 2, .days = days});
  const LogText& expected = bench.expected();
  bench.start_server();
  const double began_s = now_s();
  const int struck = kill_through(bench, kills, false, 20210801);
  EXPECT_GE(struck, kills * 9 / 10);
  expect_same_rows(bench.log(), expected);
  std::printf("%d kills in %zu rows, %.1f s\n", struck, expected.rows.size(), now_s() - began_s);
}

TEST(KilledDaemon, LogOfTwelveBoxesAndOfOneEqualsTheUndisturbedOne) {
  const int days = from_environment("AIRSIDE_SHAPE_DAYS", 1), kills = from_environment("AIRSIDE_SHAPE_KILLS", 20);
  for (const char* const topology : {"12vav-0fcu-1power", "1vav-0fcu-0power"}) {
    SCOPED_TRACE(topology);
    Bench bench({.name = "kill_shape", .topology = topology, .plant = rc_room(), .expert_days = 1, .days = days});
    const LogText& expected = bench.expected();
    bench.start_server();
    const double began_s = now_s();
    const int struck = kill_through(bench, kills, false, 12);
    EXPECT_GE(struck, kills * 3 / 4);
    expect_same_rows(bench.log(), expected);
    std::printf("%s: %d kills in %zu rows, %.1f s, by %s\n", topology, struck, expected.rows.size(), now_s() - began_s,
                bench.program("airsided").c_str());
  }
}

TEST(KilledDaemon, LogEqualsTheUndisturbedOneWithEveryRowForcedToTheDisk) {
  Bench bench({.name = "kill_sync", .plant = rc_room("702"), .expert_days = 1, .days = 1, .in_memory = false});
  const LogText& expected = bench.expected();
  bench.start_server();
  const int struck = kill_through(bench, 15, true, 702);
  EXPECT_GE(struck, 12);
  expect_same_rows(bench.log(), expected);
}

TEST(StoppedDaemon, LeavesWithinASecondAndGoesOnExactly) {
  Bench bench({.name = "stop", .plant = rc_room("402"), .expert_days = 1, .days = 2});
  const LogText& expected = bench.expected();
  bench.start_server();
  SplitMix64 draw(402);
  double slowest_s = 0;
  for (const std::size_t rows : moments(draw, 12, bench.rows() - 200)) {
    const auto daemon = bench.start_daemon();
    ASSERT_TRUE(reach(bench, *daemon, std::max(rows, bench.logged_rows() + 1))) << daemon->said();
    sleep_s(0.01 * draw.uniform());
    const double asked_s = now_s();
    daemon->signal(SIGTERM);
    ASSERT_EQ(daemon->wait(5), 0) << daemon->said();
    slowest_s = std::max(slowest_s, now_s() - asked_s);
  }
  EXPECT_LT(slowest_s, 1.0);
  const auto daemon = bench.start_daemon();
  ASSERT_EQ(daemon->wait(100), 0) << daemon->said();
  expect_same_rows(bench.log(), expected);
}

TEST(StoppedDaemon, LeavesWithinASecondWhileThePlantIsSilent) {
  // Nobody answers at the site's port: the wait for the plant, its back-off included, ends at once.
  Bench bench({.name = "silent", .plant = rc_room(), .expert_days = 0, .days = 1});
  const auto daemon = bench.start_daemon();
  const double deadline_s = now_s() + 10;
  while (daemon->said().find("no answer") == std::string::npos && now_s() < deadline_s) sleep_s(0.01);
  sleep_s(0.3);
  const double asked_s = now_s();
  daemon->signal(SIGTERM);
  EXPECT_EQ(daemon->wait(5), 0) << daemon->said();
  EXPECT_LT(now_s() - asked_s, 1.0);
}

TEST(SecondDaemon, Row60IsTurnedAwayAndTheFirstGoesOn) {
  Bench bench({.name = "two", .plant = rc_room(), .expert_days = 1, .days = 1});
  const LogText& expected = bench.expected();
  bench.start_server();
  const auto daemon = bench.start_daemon();
  ASSERT_TRUE(reach(bench, *daemon, 5));
  Child second({bench.program("airsided"), "--site", bench.file("site.toml")}, bench.file("second.txt"));
  EXPECT_EQ(second.wait(10), 1);
  EXPECT_NE(second.said().find("another airsided"), std::string::npos) << second.said();
  ASSERT_EQ(daemon->wait(100), 0);
  expect_same_rows(bench.log(), expected);
}

TEST(SecondDaemon, Row60WhoeverLocksTheFolderThatWasTakenAwayHasTheAhu) {
  Bench bench({.name = "taken", .plant = rc_room(), .expert_days = 1, .days = 1});
  bench.start_server();
  const auto first = bench.start_daemon();
  ASSERT_TRUE(reach(bench, *first, 5));
  first->signal(SIGSTOP);
  std::filesystem::remove_all(bench.file("state"));
  Child second({bench.program("airsided"), "--site", bench.file("site.toml"), "--no-sync"}, bench.file("second.txt"));
  const double deadline_s = now_s() + 20;
  while (!std::filesystem::exists(bench.file("state") / "status.json") && now_s() < deadline_s) sleep_s(0.01);
  second.signal(SIGSTOP);
  first->signal(SIGCONT);
  EXPECT_EQ(first->wait(100), 0);
  EXPECT_NE(first->said().find("files removed while in use"), std::string::npos) << first->said();
  EXPECT_NE(first->said().find("another process uses it"), std::string::npos) << first->said();
  EXPECT_NE(first->said().find("release: "), std::string::npos) << first->said();
  second.signal(SIGCONT);
  second.signal(SIGKILL);
}

TEST(SecondDaemon, Row60WithoutItTwoRoomsHaveADaemonEach) {
  Bench one({.name = "one", .plant = rc_room(), .expert_days = 1, .days = 1});
  Bench other({.name = "other", .plant = rc_room("401"), .expert_days = 1, .days = 1});
  one.start_server();
  other.start_server();
  const auto first = one.start_daemon(), second = other.start_daemon();
  ASSERT_EQ(first->wait(100), 0);
  ASSERT_EQ(second->wait(100), 0);
  expect_same_rows(one.log(), one.expected());
  expect_same_rows(other.log(), other.expected());
}

}  // namespace
}  // namespace airside::closed_loop
