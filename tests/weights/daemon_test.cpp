// The whole way of weights: keygen, sign, push, and a daemon that takes them on trial and confirms them; killed while
// the trial runs it ends as if nothing had been.

#include <fcntl.h>
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "airside/splitmix64.hpp"
#include "firmware/edge/daemon.hpp"
#include "hal/points/point_map.hpp"
#include "hal/site/site_settings.hpp"
#include "support/bench.hpp"

namespace airside::weights {
namespace {

namespace fs = std::filesystem;
using closed_loop::Bench;
using closed_loop::Child;

/// A bench with keys, its own blob signed, and an inbox.
class PushBench {
 public:
  explicit PushBench(const std::string& name, int days = 2)
      : bench({.name = name, .plant = closed_loop::rc_room(), .expert_days = 1, .days = days}) {
    for (const char* part : {"keys", "inbox"}) fs::create_directories(bench.file(part));
    EXPECT_EQ(run({"keygen", "-o", bench.file("ann")}), 0);
    fs::copy(bench.file("ann.pub"), bench.file("keys") / "ann.pub");
    EXPECT_EQ(run({"sign", bench.file("weights.blob"), "--key", bench.file("ann.key"), "-o", bench.file("signed.blob"),
                   "--counter", "10"}),
              0);
    bench.start_server();
  }
  int run(std::vector<std::string> words) {
    words.insert(words.begin(), bench.program("airside").string());
    return Child(words, bench.file("said.txt")).wait(60).value_or(-1);
  }
  std::string said() const {
    std::ifstream in(bench.file("said.txt"));
    return {std::istreambuf_iterator<char>(in), {}};
  }
  /// Until so many rows more are logged, or the daemon is gone.
  void rows(Child& daemon, std::size_t more) const {
    const std::size_t until = bench.logged_rows() + more;
    while (bench.logged_rows() < until && daemon.running()) closed_loop::sleep_s(0.001);
  }
  /// Other weights than weights.blob.
  void name_in_site(const std::string& blob) const {
    std::ifstream in(bench.file("site.toml"));
    std::string site(std::istreambuf_iterator<char>(in), {});
    const std::size_t at = site.find("weights.blob");
    ASSERT_NE(at, std::string::npos) << site;
    site.replace(at, 12, blob);
    std::ofstream(bench.file("site.toml"), std::ios::trunc) << site;
  }
  nlohmann::json status() const { return bench.status(); }

  Bench bench;
};

TEST(PushedWeights, AreTakenOnTrialAndConfirmedAfterADay) {
  PushBench b("push");
  ASSERT_EQ(b.run({"push", b.bench.file("signed.blob"), b.bench.file("site.toml")}), 0) << b.said();
  const auto daemon = b.bench.start_daemon();
  ASSERT_EQ(daemon->wait(120), 0) << daemon->said();
  EXPECT_NE(daemon->said().find("taken; on trial"), std::string::npos) << daemon->said();
  EXPECT_NE(daemon->said().find("confirmed after a day"), std::string::npos) << daemon->said();
  const auto status = b.status();
  EXPECT_EQ(status["pushed_weights"], "confirmed");
  EXPECT_EQ(status["pushed_refusal"], "none");
  EXPECT_TRUE(fs::is_empty(b.bench.file("inbox")));
}

TEST(PushedWeights, ADaemonKilledDuringTheTrialEndsAsAnUndisturbedOne) {
  PushBench calm("push_calm"), killed("push_killed");
  for (PushBench* b : {&calm, &killed}) {
    // The keys differ, the weights do not: what is compared is the control that follows.
    ASSERT_EQ(b->run({"push", b->bench.file("signed.blob"), b->bench.file("site.toml")}), 0);
  }
  ASSERT_EQ(calm.bench.start_daemon()->wait(120), 0);
  SplitMix64 draw(3);
  for (int kill = 0; kill < 12; ++kill) {
    const auto daemon = killed.bench.start_daemon();
    const std::size_t rows = killed.bench.logged_rows() + 3 + draw.below(6);
    while (daemon->running() && killed.bench.logged_rows() < rows) closed_loop::sleep_s(0.0005);
    daemon->signal(SIGKILL);
    daemon->wait(10);
  }
  ASSERT_EQ(killed.bench.start_daemon()->wait(120), 0);
  closed_loop::expect_same_rows(killed.bench.log(), calm.bench.log());
  EXPECT_EQ(killed.status()["pushed_weights"], "confirmed");
}

TEST(Released, AWishThatLiesThereIsKeptBeforeTheFirstWriteAndByWhateverComesAfter) {
  PushBench b("released");
  std::ofstream(b.bench.file("inbox") / "release");
  {
    const auto daemon = b.bench.start_daemon();
    b.rows(*daemon, 30);
    daemon->signal(SIGTERM);
    ASSERT_EQ(daemon->wait(30), 0) << daemon->said();
  }
  EXPECT_EQ(b.status()["setpoint_writes"], 0) << "the first row is one that decides";
  EXPECT_EQ(b.status()["reason"], "released by hand");
  // What the state itself knows must do: the wish would be told again.
  EXPECT_TRUE(fs::remove(b.bench.file("inbox") / "release"));
  // Other weights in the site file are a person's wish too, but not this one's end.
  b.name_in_site("signed.blob");
  const auto daemon = b.bench.start_daemon();
  ASSERT_EQ(daemon->wait(120), 0) << daemon->said();
  EXPECT_NE(daemon->said().find("other weights than the state grew from"), std::string::npos) << daemon->said();
  EXPECT_EQ(b.status()["setpoint_writes"], 0);
  EXPECT_EQ(b.status()["reason"], "released by hand") << b.status();
}

TEST(OtherWeights, OfTheSiteFileKeepWhatMayBeInTheRegister) {
  PushBench b("stored");
  {
    const auto daemon = b.bench.start_daemon();
    b.rows(*daemon, 30);
    daemon->signal(SIGTERM);
    ASSERT_EQ(daemon->wait(30), 0) << daemon->said();
  }
  b.name_in_site("signed.blob");
  const hal::SiteFile site = hal::read_site_file(b.bench.file("site.toml").string(), hal::site_rules());
  const hal::PointMap points = hal::PointMap::load(site.modbus->points);
  edge::DaemonOptions options;
  options.sync = hal::Sync::none;
  const auto daemon = edge::make_daemon(site, points, options, {});
  daemon->start();
  const auto& controller = dynamic_cast<edge::Daemon<FiveZone>&>(*daemon).controller();
  EXPECT_EQ(controller.cycle().last_time.seconds, 0) << "else these are the weights that the state grew from";
  EXPECT_TRUE(std::isfinite(controller.cycle().stored.low_degc)) << "else the first step has no limit";
}

/// State of thirty rows that cannot be had at the next start, and then can.
class LateState : public ::testing::Test {
 protected:
  void run(std::size_t rows) {
    start();
    b.rows(*daemon, rows);
    end();
  }
  void start() { daemon = b.bench.start_daemon(); }
  void end() {
    daemon->signal(SIGTERM);
    ASSERT_EQ(daemon->wait(30), 0) << daemon->said();
  }
  void hide() const {
    fs::rename(state, away);
    fs::create_symlink("state", state);  // to itself: neither there nor not there
  }
  /// At once, as a mount is: a row that finds nothing there would make a folder.
  void show() const { ASSERT_EQ(::renameat2(AT_FDCWD, away.c_str(), AT_FDCWD, state.c_str(), RENAME_EXCHANGE), 0); }
  void wish(const char* name) const { std::ofstream(b.bench.file("inbox") / name).put('x'); }

  PushBench b{"late", 20};
  const fs::path state = b.bench.file("state"), away = b.bench.file("away");
  std::unique_ptr<Child> daemon;
};

TEST_F(LateState, IsThatOfAnAhuWhichWasReleasedMeanwhile) {
  run(30);
  hide();
  start();
  b.rows(*daemon, 30);
  wish("release");
  b.rows(*daemon, 30);
  EXPECT_TRUE(fs::remove(b.bench.file("inbox") / "release")) << "else it would be told again";
  show();
  b.rows(*daemon, 30);
  const int writes = b.status()["setpoint_writes"];
  EXPECT_EQ(b.status()["reason"], "released by hand") << b.status();
  b.rows(*daemon, 60);
  EXPECT_EQ(b.status()["setpoint_writes"], writes);
  EXPECT_EQ(b.status()["reason"], "released by hand") << b.status();
  EXPECT_NE(daemon->said().find("resuming after row"), std::string::npos) << daemon->said();
  wish("hand-back");
  b.rows(*daemon, 60);
  EXPECT_GT(b.status()["setpoint_writes"], writes) << "until it is handed back";
  end();
}

TEST_F(LateState, IsToldOfAHandBackThatCameMeanwhile) {
  wish("release");
  run(30);
  EXPECT_EQ(b.status()["reason"], "released by hand");
  hide();
  start();
  b.rows(*daemon, 30);
  wish("hand-back");
  b.rows(*daemon, 30);
  show();
  b.rows(*daemon, 60);
  EXPECT_NE(b.status()["reason"], "released by hand") << b.status();
  EXPECT_GT(b.status()["setpoint_writes"], 0);
  EXPECT_TRUE(fs::is_empty(b.bench.file("inbox")));
  end();
}

TEST_F(LateState, TakesWeightsThatWerePushedMeanwhile) {
  run(30);
  const char* records[] = {"row.a", "row.b", "learning.a", "learning.b"};
  for (const char* name : records) {
    fs::rename(state / name, b.bench.file(name));
    fs::create_symlink(name, state / name);
  }
  start();
  b.rows(*daemon, 30);
  ASSERT_EQ(b.run({"push", b.bench.file("signed.blob"), b.bench.file("site.toml")}), 0) << b.said();
  b.rows(*daemon, 30);
  EXPECT_EQ(b.status()["pushed_weights"], "on trial") << b.status();
  for (const char* name : records) fs::rename(b.bench.file(name), state / name);
  b.rows(*daemon, 30);
  EXPECT_NE(daemon->said().find("resuming after row"), std::string::npos) << daemon->said();
  EXPECT_EQ(b.status()["pushed_weights"], "on trial") << b.status();
  EXPECT_EQ(b.status()["pushed_refusal"], "none") << b.status();
  EXPECT_TRUE(fs::is_empty(b.bench.file("inbox")));
  std::ofstream(b.bench.file("inbox") / "rollback");
  b.rows(*daemon, 30);
  EXPECT_EQ(b.status()["pushed_weights"], "rolled back") << "the copy is there";
  EXPECT_EQ(b.status()["has_weights"], true);
  end();
}

TEST_F(LateState, OfOtherWeightsGivesWayToTheSites) {
  run(30);
  b.name_in_site("signed.blob");
  hide();
  start();
  b.rows(*daemon, 30);
  show();
  b.rows(*daemon, 30);
  EXPECT_NE(daemon->said().find("other weights than the state grew from"), std::string::npos) << daemon->said();
  EXPECT_EQ(b.status()["has_weights"], true) << b.status();
  end();
  start();
  b.rows(*daemon, 30);
  EXPECT_NE(daemon->said().find("resuming after row"), std::string::npos) << daemon->said();
  EXPECT_EQ(b.status()["has_weights"], true) << b.status();
  end();
}

TEST(Released, WithoutAWishTheFirstRowsWrite) {
  PushBench b("not_released");
  const auto daemon = b.bench.start_daemon();
  b.rows(*daemon, 30);
  daemon->signal(SIGTERM);
  ASSERT_EQ(daemon->wait(30), 0) << daemon->said();
  EXPECT_GT(b.status()["setpoint_writes"], 0);
}

TEST(PushedWeights, AnUnsignedBlobIsRefusedBeforeItLeaves) {
  PushBench b("push_unsigned");
  EXPECT_EQ(b.run({"push", b.bench.file("weights.blob"), b.bench.file("site.toml")}), 1);
  EXPECT_NE(b.said().find("an unsigned blob"), std::string::npos) << b.said();
  EXPECT_EQ(b.run({"push", b.bench.file("signed.blob"), b.bench.file("nowhere")}), 1);
  EXPECT_NE(b.said().find("inbox"), std::string::npos) << b.said();
  EXPECT_EQ(b.run({"keygen", "-o", b.bench.file("ann")}), 1) << "a key is never written over";
}

TEST(PushedWeights, ADamagedBlobIsNeitherSignedNorSent) {
  PushBench b("push_damaged");
  for (const char* name : {"weights.blob", "signed.blob"}) {
    std::fstream blob(b.bench.file(name), std::ios::in | std::ios::out | std::ios::binary);
    blob.seekg(50'000);
    const int was = blob.get();
    blob.seekp(50'000);
    blob.put(static_cast<char>(was ^ 4));
  }
  EXPECT_EQ(b.run({"sign", b.bench.file("weights.blob"), "--key", b.bench.file("ann.key"), "-o", b.bench.file("x")}),
            1);
  EXPECT_NE(b.said().find("weights.blob: digest"), std::string::npos) << b.said();
  EXPECT_FALSE(fs::exists(b.bench.file("x")));
  EXPECT_EQ(b.run({"push", b.bench.file("signed.blob"), b.bench.file("site.toml")}), 1);
  EXPECT_NE(b.said().find("undamaged"), std::string::npos) << b.said();
  EXPECT_EQ(b.run({"push", b.bench.file("points.csv"), b.bench.file("site.toml")}), 1) << "no blob at all";
  EXPECT_TRUE(fs::is_empty(b.bench.file("inbox")));
}

TEST(PushedWeights, ABlobThatWaitsIsOnlyReplacedByANewerOneOfItsKey) {
  PushBench b("push_twice");
  const std::string site = b.bench.file("site.toml"), blob = b.bench.file("signed.blob");
  const auto sign = [&](const char* key, const char* counter) {
    return b.run({"sign", blob, "--key", b.bench.file(key), "--counter", counter});
  };
  ASSERT_EQ(b.run({"push", blob, site}), 0) << b.said();
  EXPECT_EQ(b.run({"push", blob, site}), 1) << "not older than what waits";
  ASSERT_EQ(sign("ann.key", "11"), 0) << b.said();
  EXPECT_EQ(b.run({"push", blob, site}), 0) << b.said();
  ASSERT_EQ(b.run({"keygen", "-o", b.bench.file("bob")}), 0);
  ASSERT_EQ(sign("bob.key", "12"), 0) << b.said();
  fs::copy(b.bench.file("bob.pub"), b.bench.file("keys") / "bob.pub");
  EXPECT_EQ(b.run({"push", blob, site}), 1);
  EXPECT_NE(b.said().find("other weights that wait"), std::string::npos) << b.said();
  EXPECT_EQ(sign("ann.key", "0"), 2) << "counters begin at 1";
  EXPECT_EQ(sign("ann.key", "-1"), 2);
}

TEST(PushedWeights, WithoutAPushTheDaemonsRowsAreTheSimulations) {
  PushBench b("push_none");
  const auto daemon = b.bench.start_daemon();
  ASSERT_EQ(daemon->wait(120), 0) << daemon->said();
  closed_loop::expect_same_rows(b.bench.log(), b.bench.expected());
}

}  // namespace
}  // namespace airside::weights
