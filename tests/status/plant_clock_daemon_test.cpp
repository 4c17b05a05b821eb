// A plant's clock that is wrong for a reading, for a while, or for good: the daemon neither waits for a day that nobody
// reaches nor leaves the room alone, and says what it saw.

#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>

#include "hal/modbus/wire.hpp"
#include "hal/text/civil_text.hpp"
#include "support/bench.hpp"
#include "support/modbus_fixture.hpp"

namespace airside::status {
namespace {

using closed_loop::Bench;
using closed_loop::Child;
using hal::testing_peers::ServerThread;

/// A daemon beside a plant that stands at 25 degC and whose clock runs 1200 times as fast as the machine's: a row takes
/// 0.3 s.
class PlantClock : public ::testing::Test {
 protected:
  static constexpr double speed = 1200;

  PlantClock() : served(hal::PointMap::load(bench.file("points.csv").string()), {hal::TcpListen{}, 1}) {
    hal::ModbusServer& server = served.server();
    for (const hal::Point& point : server.map().points()) {
      if (!point.writable() && point.name != "map_fingerprint")
        server.set(point.name, std::clamp(25.0, point.min, point.max));
    }
    server.refresh([this] { served.server().set("clock_s", clock_s()); });
    served.start();
    std::ifstream in(bench.file("site.toml"));
    std::string site(std::istreambuf_iterator<char>(in), {});
    site.replace(site.find("port = 502"), 10, "port = " + std::to_string(server.port()));
    std::ofstream(bench.file("site.toml"), std::ios::trunc) << site;
    daemon = bench.start_daemon(false, {"--until", "2100-01-01T00:00:00"});
    EXPECT_TRUE(rows(5, 20)) << daemon->said();
  }
  ~PlantClock() override {
    daemon->signal(SIGTERM);
    EXPECT_EQ(daemon->wait(20), 0) << daemon->said();
  }

  double plant_s() const { return start_s + speed * hal::testing_peers::seconds_since(began_ns); }
  double clock_s() const { return plant_s() + added; }
  /// Whether the daemon writes so many statuses more in time.
  bool rows(int more, double limit_s) const {
    const std::int64_t before_ns = hal::monotonic_ns();
    std::string last = status()["time"].dump();
    while (more > 0 && hal::testing_peers::seconds_since(before_ns) < limit_s && daemon->running()) {
      closed_loop::sleep_s(0.02);
      const nlohmann::json s = status();
      if (!s.contains("time") || s["time"].dump() == last) continue;
      last = s["time"].dump();
      --more;
    }
    return more == 0;
  }
  nlohmann::json status() const {
    nlohmann::json s = bench.status();
    return s.is_object() ? s : nlohmann::json::object();
  }
  /// Rows between the plant's time (with what is added) and that of the status.
  double rows_behind(double added_s = 0) const {
    const std::string time = status().value("time", "");
    const auto t = hal::parse_civil_text(time);
    if (!t) return 1e9;
    const double row = static_cast<double>(t->seconds - hal::clock_epoch.seconds);
    return (plant_s() + added_s - row) / row_s;
  }
  bool has_said(const std::string& what) const { return daemon->said().find(what) != std::string::npos; }

  Bench bench{{.name = "plant_clock",
               .plant = closed_loop::rc_room(),
               .expert_days = 0,
               .days = 1,
               .more_site = closed_loop::brief_learning}};
  const double start_s = 21 * 365 * seconds_per_day;
  const std::int64_t began_ns = hal::monotonic_ns();
  std::atomic<double> added{0};
  ServerThread served;
  std::unique_ptr<Child> daemon;
};

TEST_F(PlantClock, WrongForAMomentNeitherHangsTheDaemonNorIsWrittenToTheLog) {
  for (const double wrong_s : {24.0 * seconds_per_day, 3 * 365.0 * seconds_per_day}) {
    added = wrong_s;
    closed_loop::sleep_s(0.15);
    added = 0;
    EXPECT_TRUE(rows(4, 10)) << daemon->said();
    EXPECT_LT(std::abs(rows_behind()), 4) << status();
  }
  EXPECT_TRUE(has_said("that did not last and is not believed")) << daemon->said();
  EXPECT_EQ(status()["clock"], "read wrong") << status();
  EXPECT_EQ(status()["storage"], "ok") << status();
}

TEST_F(PlantClock, WrongForAWhileIsLeftAgain) {
  added = 24 * seconds_per_day;
  closed_loop::sleep_s(1.0);
  added = 0;
  EXPECT_TRUE(rows(5, 15)) << daemon->said();
  EXPECT_LT(std::abs(rows_behind()), 4) << status();
  EXPECT_TRUE(has_said("so control goes on from there")) << daemon->said();
  EXPECT_EQ(status()["clock"], "jumped") << status();
}

TEST_F(PlantClock, ThatReallyJumpedIsFollowed) {
  added = 24 * seconds_per_day;
  EXPECT_TRUE(rows(5, 15)) << daemon->said();
  EXPECT_LT(std::abs(rows_behind(24 * seconds_per_day)), 4) << status();
  EXPECT_TRUE(has_said("so control goes on from there")) << daemon->said();
}

TEST_F(PlantClock, SetBackOverARestartIsSaidAsSuchAndNotAsADiskThatFailed) {
  daemon->signal(SIGTERM);
  ASSERT_EQ(daemon->wait(20), 0) << daemon->said();
  added = -0.5 * seconds_per_day;
  daemon = bench.start_daemon(false, {"--until", "2100-01-01T00:00:00"});
  ASSERT_TRUE(rows(7, 30)) << "the decision after the first row that failed" << daemon->said();
  const nlohmann::json s = status();
  EXPECT_EQ(s["storage"], "log's last row is later than the clock") << s;
  EXPECT_EQ(s["reason"], "storage failed") << s;
  EXPECT_NE(s.value("way_out", "").find("set the clock right, or move the log folder away"), std::string::npos) << s;
  EXPECT_TRUE(has_said("log: the clock is at 2020-12-2")) << daemon->said();
  EXPECT_TRUE(has_said("move the log folder away")) << daemon->said();
  EXPECT_FALSE(has_said("look at the disk")) << daemon->said();
  // What is advised helps, while the daemon runs.
  std::filesystem::rename(bench.file("log"), bench.file("log-before"));
  EXPECT_TRUE(rows(4, 20)) << daemon->said();
  EXPECT_EQ(status()["storage"], "ok") << status();
  EXPECT_GE(bench.logged_rows(), 2u);
}

}  // namespace
}  // namespace airside::status
