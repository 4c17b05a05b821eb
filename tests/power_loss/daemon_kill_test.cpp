// kill -9 at any call of the real daemon, also while weights are exchanged and taken back: it goes on as if nothing had
// been.
//   AIRSIDE_KILLS=n          kills in all (150); AIRSIDE_KILL_SECONDS=n: stops after so long
//   AIRSIDE_KILL_EVERY=1     a life for every single call of it and every phase, instead of a sample
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "airside/splitmix64.hpp"
#include "power_loss/daemon_desk.hpp"

namespace airside::power_loss {
namespace {

using closed_loop::from_environment;
using closed_loop::now_s;

/// Where in a life weights come and go.
struct Plan {
  int first_push, rollback, second_push, end;
};

/// What a life leaves.
struct Left {
  std::vector<std::string> rows;
  std::map<std::int64_t, double> setpoints;
  std::string pushed;
};

struct Kills {
  int kills = 0;
  double slowest_s = 0;  ///< from a start after a kill until the next row is committed and the process has ended
};

class Life {
 public:
  Life(DaemonDesk& desk, const Plan& plan) : desk_(desk), plan_(plan) {}

  /// `reach(row)` brings the daemon to that row, with or without kills. The first three rows are undisturbed: before
  /// the first commit nothing tells a daemon that the setpoint it finds is its own.
  template <class Reach>
  Left live(const Reach& reach) {
    desk_.reset();
    EXPECT_EQ(desk_.run(3).code, 0);
    reach(plan_.first_push);
    desk_.push(1);
    reach(plan_.rollback);
    desk_.wish("rollback");
    reach(plan_.second_push);
    desk_.push(2);
    reach(plan_.end);
    const auto status = nlohmann::json::parse(desk_.status(), nullptr, false);
    return {desk_.rows(), desk_.setpoints(), status.value("pushed_weights", "")};
  }

 private:
  DaemonDesk& desk_;
  Plan plan_;
};

void expect_same(const Left& left, const Left& calm) {
  ASSERT_EQ(left.rows.size(), calm.rows.size());
  for (std::size_t i = 0; i < left.rows.size(); ++i) ASSERT_EQ(left.rows[i], calm.rows[i]) << "row " << i;
  ASSERT_EQ(left.setpoints, calm.setpoints);
  ASSERT_EQ(left.pushed, calm.pushed);
}

void reach_calmly(DaemonDesk& desk, int row) { ASSERT_EQ(desk.run(row).code, 0) << desk.said(); }

TEST(KilledAtACall, Row39AnyKillIsFollowedByTheSameRowsAndSetpoints) {
  const int wanted = from_environment("AIRSIDE_KILLS", 150);
  const double until_s = now_s() + from_environment("AIRSIDE_KILL_SECONDS", 100'000);
  DaemonDesk desk({.name = "kill_calls", .days = 2});
  SplitMix64 draw(static_cast<std::uint64_t>(from_environment("AIRSIDE_KILL_SEED", 39)));
  Kills all;
  int lives = 0, starts = 0;
  while (all.kills < wanted && now_s() < until_s) {
    const int a = 4 + static_cast<int>(draw.below(20)), b = a + 1 + static_cast<int>(draw.below(20)),
              c = b + 1 + static_cast<int>(draw.below(20));
    Life life(desk, {a, b, c, c + 10 + static_cast<int>(draw.below(200))});
    const Left calm = life.live([&](int row) { reach_calmly(desk, row); });
    const Left killed = life.live([&](int row) {
      while (true) {
        // A start needs about 160 calls, a row 11: many of the kills strike before the first row.
        const std::string at = std::to_string(draw.below(260)) + ":" + std::to_string(draw.below(3));
        const DaemonRun run = desk.run(row, {.kill = at});
        ++starts;
        ASSERT_TRUE(run.code == 0 || run.code == 128 + SIGKILL) << run.code << ": " << desk.said();
        if (run.code == 0) break;
        ++all.kills;
        if (all.kills % 16 == 0) {
          const int next = std::min(row, static_cast<int>(desk.rows().size()) + 1);
          const DaemonRun resumed = desk.run(next);
          ASSERT_EQ(resumed.code, 0) << desk.said();
          ASSERT_GE(desk.rows().size() + 1, static_cast<std::size_t>(next));
          all.slowest_s = std::max(all.slowest_s, resumed.seconds);
        }
      }
    });
    ++lives;
    desk.forget_words();
    expect_same(killed, calm);
    if (HasFatalFailure()) FAIL() << "life " << lives;
  }
  EXPECT_LT(all.slowest_s, 5.0);
  std::printf("%d kills in %d lives, %d starts; slowest start until the next row was committed %.3f s\n", all.kills,
              lives, starts, all.slowest_s);
}

TEST(KilledAtACall, Row39EveryCallOfAnExchangeAndOfAWayBack) {
  const bool every = from_environment("AIRSIDE_KILL_EVERY", 0) != 0;
  DaemonDesk desk({.name = "kill_every", .days = 1});
  const Plan plan{4, 6, 8, 10};
  Life life(desk, plan);
  const Left calm = life.live([&](int row) { reach_calmly(desk, row); });
  long most = 0;
  int kills = 0;
  for (int target : {plan.rollback, plan.second_push, plan.end}) {
    most = 1000;
    for (long at = every ? 0 : target; at < most; at += every ? 1 : 23) {
      for (int phase = 0; phase < 3; ++phase) {
        if (!every && (at + phase) % 3 != 0) continue;
        const Left killed = life.live([&](int row) {
          if (row == target) {
            const DaemonRun run = desk.run(row, {.kill = std::to_string(at) + ":" + std::to_string(phase)});
            if (run.code == 0) most = std::min(most, run.calls);
            kills += run.code == 128 + SIGKILL;
          }
          reach_calmly(desk, row);
        });
        expect_same(killed, calm);
        if (HasFatalFailure()) FAIL() << "row " << target << " call " << at << " phase " << phase;
      }
    }
    EXPECT_LT(most, 1000);
    desk.forget_words();
  }
  std::printf("%d kills, each at a call of its own\n", kills);
}

TEST(KilledAtACall, Row39WithoutAKillStoppingAndStartingChangesNothing) {
  DaemonDesk desk({.name = "kill_none", .days = 1});
  Life life(desk, {4, 6, 8, 40});
  const Left calm = life.live([&](int row) { reach_calmly(desk, row); });
  const Left stopped = life.live([&](int row) {
    for (int i = static_cast<int>(desk.rows().size()) + 1; i <= row; ++i) reach_calmly(desk, i);
  });
  expect_same(stopped, calm);
  EXPECT_EQ(calm.pushed, "on trial");
}

TEST(KilledAtACall, BeforeTheFirstCommitTheNextStartIsAFirstStart) {
  DaemonDesk desk({.name = "kill_first", .days = 1});
  for (long at = 0; at < 140; at += 3) {
    desk.reset();
    const DaemonRun run = desk.run(1, {.kill = std::to_string(at) + ":1"});
    ASSERT_TRUE(run.killed_by_probe || run.code == 0);
    ASSERT_EQ(desk.run(12).code, 0) << desk.said();
    const auto rows = desk.rows();
    for (std::size_t i = 1; i < rows.size(); ++i) ASSERT_LT(rows[i - 1].substr(0, 19), rows[i].substr(0, 19)) << at;
    ASSERT_GE(rows.size(), 12u) << at;
    ASSERT_NE(desk.status().find("\"storage\":\"ok\""), std::string::npos) << at;
  }
}

TEST(Restart, Row24WithoutAnotherHandADeviceAtItsDefaultIsTakenOver) {
  DaemonDesk desk({.name = "default", .days = 1});
  ASSERT_EQ(desk.run(10).code, 0);
  desk.keep("box_then");
  auto setpoints = desk.setpoints();
  setpoints[desk.time_of(9).seconds] = 28.0;  // the AHU's own, while nobody beats
  desk.roll_back("box_then", 10, setpoints);
  ASSERT_EQ(desk.run(20).code, 0) << desk.said();
  const auto status = nlohmann::json::parse(desk.status(), nullptr, false);
  EXPECT_EQ(status["reason"], "none") << status.dump();
  EXPECT_NE(desk.setpoints().rbegin()->second, 28.0);
}

}  // namespace
}  // namespace airside::power_loss
