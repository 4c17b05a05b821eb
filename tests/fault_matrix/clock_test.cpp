// Clocks that cannot be right: after a power cut without a battery, set far back, or far ahead and then right.

#include <gtest/gtest.h>

#include <csignal>
#include <cstdlib>
#include <ctime>
#include <fstream>
#include <functional>
#include <iomanip>
#include <nlohmann/json.hpp>
#include <sstream>

#include "fault_matrix/notify_socket.hpp"
#include "firmware/edge/daemon.hpp"
#include "hal/site/site_settings.hpp"
#include "support/bench.hpp"
#include "support/sanitized.hpp"

namespace airside::fault_matrix {
namespace {

using closed_loop::Bench;
using closed_loop::Child;

/// A daemon on the machine's clock, whose rows are called one by one.
class ClockDesk : public ::testing::Test {
 protected:
  ClockDesk() {
    bench.start_server();
    begin();
  }
  /// A process, in the place of the one before.
  void begin() {
    daemon.reset();
    hal::SiteFile site = hal::read_site_file(bench.file("site.toml").string(), hal::site_rules());
    site.clock = hal::ClockSource::system;
    const hal::PointMap points = hal::PointMap::load(site.modbus->points);
    edge::DaemonOptions options;
    options.sync = hal::Sync::none;
    options.crash_limit = 0;
    daemon = edge::make_daemon(site, points, options, {});
    daemon->start();
  }
  /// One row at t; whether its clock was believed.
  bool believed(CivilTime t) {
    auto& wired = dynamic_cast<edge::Daemon<FiveZone>&>(*daemon);
    const Expected<Reading<FiveZone>> nothing = tl::unexpected(Fault::no_reading);
    EXPECT_TRUE(wired.row(t, nothing, wired.controller()));
    return !wired.controller().cycle().mode_arbiter.active(Reason::clock_not_set, t);
  }

  static constexpr CivilTime now{1'795'000'320 / 86400 * 86400};  // a midnight of November 2026
  Bench bench{{.name = "clock", .plant = closed_loop::rc_room(), .expert_days = 1, .days = 1}};
  std::unique_ptr<edge::AnyDaemon> daemon;
};

TEST_F(ClockDesk, Row30AClockOf1970IsNotBelievedAndItsRowsAreNotLogged) {
  for (int row = 0; row < 300; ++row) EXPECT_FALSE(believed({row * row_s})) << row;
  EXPECT_EQ(bench.logged_rows(), 0u);
  EXPECT_TRUE(believed(now)) << "and is followed once it is set";
  EXPECT_EQ(bench.logged_rows(), 1u);
}

TEST_F(ClockDesk, Row30WithoutAClockThatIsRightIsNeverDoubted) {
  for (int row = 0; row < 300; ++row) EXPECT_TRUE(believed({now.seconds + row * row_s})) << row;
  EXPECT_EQ(bench.logged_rows(), 300u);
}

TEST_F(ClockDesk, Row30AClockThatIsNotBelievedIsNotBelievedAfterARestartEither) {
  EXPECT_TRUE(believed(now));
  const std::int64_t year_back_s = now.seconds - 365 * seconds_per_day;
  for (int start = 0; start < 3; ++start) {
    begin();
    EXPECT_FALSE(believed({year_back_s + start * row_s})) << "start " << start;
  }
  begin();
  EXPECT_TRUE(believed({now.seconds + row_s})) << "set again";
}

TEST_F(ClockDesk, Row28AnHourBackOrForthIsFollowed) {
  EXPECT_TRUE(believed(now));
  EXPECT_TRUE(believed({now.seconds + 3600}));
  EXPECT_TRUE(believed({now.seconds + 360}));
}

TEST_F(ClockDesk, Row28AClockThatWasFarAheadIsBelievedADayAfterItWasSetRight) {
  EXPECT_TRUE(believed({now.seconds + 1000 * seconds_per_day})) << "nobody can know";
  int doubted = 0;
  for (int row = 0; row < 2 * rows_per_day; ++row) doubted += !believed({now.seconds + row * row_s});
  EXPECT_EQ(doubted, rows_per_day);
}

/// A daemon of the machine's clock, which faketime sets: the wall's, not the monotonic one that waits run on.
class FakedClock : public ::testing::Test {
 protected:
  void SetUp() override {
    if (sanitized) GTEST_SKIP() << "faketime and a sanitizer both want to be loaded first";
    if (std::system("faketime -f '+0' true >/dev/null 2>&1") != 0) GTEST_SKIP() << "faketime is not installed";
    bench.start_server();
    std::ifstream in(bench.file("site.toml"));
    std::string site(std::istreambuf_iterator<char>(in), {});
    const std::string plant = "source = \"plant\"";
    site.replace(site.find(plant), plant.size(), "source = \"system\"");
    site.insert(site.find("[modbus]\n") + 9, "heartbeat_s = 5\n");
    std::ofstream(bench.file("site.toml")) << site;
  }
  /// status.json after the row that comes 2 s after the daemon's start at this time of the wall.
  nlohmann::json status_at(const std::string& start) {
    std::filesystem::remove(bench.file("state") / "status.json");
    Child daemon({"/usr/bin/env", "TZ=UTC", "LD_PRELOAD=/usr/$LIB/faketime/libfaketime.so.1", "FAKETIME=@" + start,
                  "DONT_FAKE_MONOTONIC=1", "FAKETIME_DONT_FAKE_MONOTONIC=1", bench.program("airsided").string(),
                  "--site", bench.file("site.toml").string(), "--no-sync", "--crash-limit", "0"},
                 bench.file("daemon.txt"));
    nlohmann::json status;
    const auto before_its_first_row = [&status] { return !status.is_object() || status.value("first_row", "") != ""; };
    for (int i = 0; i < 3000 && before_its_first_row(); ++i) {
      closed_loop::sleep_s(0.01);
      std::ifstream in(bench.file("state") / "status.json");
      status = nlohmann::json::parse(in, nullptr, false);
    }
    daemon.signal(SIGTERM);
    EXPECT_EQ(daemon.wait(20), 0) << daemon.said();
    return status;
  }
  /// The wall's clock shows this from now on, to daemons that follow the file.
  void set_wall(const std::string& time) {
    std::tm parts{};
    std::istringstream(time) >> std::get_time(&parts, "%Y-%m-%d %H:%M:%S");
    const std::string staged = bench.file("wall.new");
    std::ofstream(staged) << std::showpos << ::timegm(&parts) - std::time(nullptr) << '\n';
    std::filesystem::rename(staged, bench.file("wall"));
  }
  std::unique_ptr<Child> follow_wall() {
    return std::make_unique<Child>(
        std::vector<std::string>{"/usr/bin/env", "TZ=UTC", "LD_PRELOAD=/usr/$LIB/faketime/libfaketime.so.1",
                                 "FAKETIME_TIMESTAMP_FILE=" + bench.file("wall").string(), "FAKETIME_NO_CACHE=1",
                                 "DONT_FAKE_MONOTONIC=1", "FAKETIME_DONT_FAKE_MONOTONIC=1",
                                 bench.program("airsided").string(), "--site", bench.file("site.toml").string(),
                                 "--no-sync", "--crash-limit", "0"},
        bench.file("daemon.txt"));
  }
  /// Seconds until the log holds so many rows; more than `at_most_s` where it does not.
  double seconds_until(std::size_t rows, double at_most_s) const {
    const double begun_s = closed_loop::now_s();
    while (bench.logged_rows() < rows && closed_loop::now_s() - begun_s <= at_most_s) closed_loop::sleep_s(0.01);
    return closed_loop::now_s() - begun_s;
  }
  Bench bench{{.name = "faketime", .plant = closed_loop::rc_room(), .expert_days = 1, .days = 1}};
};

TEST_F(FakedClock, Row28AWaitIsNeitherCutNorMadeLongerByAClockThatIsSet) {
  set_wall("2026-11-23 12:17:53");
  const auto daemon = follow_wall();
  closed_loop::sleep_s(3);
  ASSERT_TRUE(daemon->running()) << daemon->said();
  set_wall("2026-11-23 12:02:56");  // during the wait for 12:18
  EXPECT_LT(seconds_until(1, 20), 10) << "not in a quarter of an hour";
  EXPECT_NE(bench.log().rows.at(0).find("2026-11-23T12:18:00"), std::string::npos) << bench.log().rows.at(0);
  daemon->signal(SIGTERM);
  ASSERT_EQ(daemon->wait(20), 0) << daemon->said();
}

TEST_F(FakedClock, Row28ARowThatAClockSetForwardHasPassedIsLeftOut) {
  set_wall("2026-11-23 12:17:52");
  const auto daemon = follow_wall();
  closed_loop::sleep_s(2);
  ASSERT_TRUE(daemon->running()) << daemon->said();
  set_wall("2026-11-23 13:23:50");
  EXPECT_GT(seconds_until(1, 30), 4) << "the wait for 12:18 comes to its end, and then 13:24 is near";
  EXPECT_NE(bench.log().rows.at(0).find("2026-11-23T13:24:00"), std::string::npos) << bench.log().rows.at(0);
  EXPECT_EQ(bench.logged_rows(), 1u) << "eleven rows were not made up for in a burst";
  daemon->signal(SIGTERM);
  ASSERT_EQ(daemon->wait(20), 0) << daemon->said();
}

TEST_F(FakedClock, Row28WithoutAClockThatIsSetTheRowComesAtItsTime) {
  set_wall("2026-11-23 12:17:53");
  const auto daemon = follow_wall();
  EXPECT_LT(seconds_until(1, 20), 12);
  EXPECT_NE(bench.log().rows.at(0).find("2026-11-23T12:18:00"), std::string::npos) << bench.log().rows.at(0);
  daemon->signal(SIGTERM);
  ASSERT_EQ(daemon->wait(20), 0) << daemon->said();
}

/// Words of a daemon between the row at 12:18 and its kick, and so many seconds after it.
class FakedClockWatched : public FakedClock {
 protected:
  /// Kicks that come within 8 s after those of a first row, before which `strike` was called.
  int kicks_after_a_row(const std::function<void()>& strike) {
    const NotifySocket manager(bench.file("notify"), 900);
    set_wall("2026-11-23 12:17:53");
    const auto daemon = follow_wall();
    EXPECT_EQ(manager.next(20), "READY=1");
    closed_loop::sleep_s(2);
    strike();
    EXPECT_EQ(manager.next(20), "WATCHDOG=1") << "of the row";
    int kicks = 0;
    for (const double end_s = closed_loop::now_s() + 8; closed_loop::now_s() < end_s;) {
      kicks += manager.next(0.5) == "WATCHDOG=1" ? 1 : 0;
    }
    EXPECT_EQ(bench.logged_rows(), 1u);
    daemon->signal(SIGTERM);
    EXPECT_EQ(daemon->wait(20), 0) << daemon->said();
    return kicks;
  }
};

TEST_F(FakedClockWatched, Row28AWaitThatAClockSetBackMakesLongIsNoHang) {
  EXPECT_GE(kicks_after_a_row([this] { set_wall("2026-11-23 12:02:56"); }), 1) << "the next row is 21 min away";
}

TEST_F(FakedClockWatched, Row28WithoutAClockThatIsSetOnlyRowsKick) {
  EXPECT_EQ(kicks_after_a_row([] {}), 0);
}

TEST_F(FakedClock, Row30ARealDaemonOf1970RunsTheScheduleAndOneOfTodayGoesOn) {
  const auto without_battery = status_at("1970-01-01 00:17:58");
  EXPECT_EQ(without_battery["time"], "1970-01-01T00:18:00") << without_battery.dump();
  EXPECT_EQ(without_battery["reason"], text_of(Reason::clock_not_set)) << without_battery.dump();
  EXPECT_EQ(without_battery["state"], "expert");
  EXPECT_EQ(bench.logged_rows(), 0u);
  const auto set = status_at("2026-11-23 00:17:58");
  EXPECT_EQ(set["time"], "2026-11-23T00:18:00") << set.dump();
  EXPECT_NE(set["reason"], text_of(Reason::clock_not_set)) << set.dump();
  EXPECT_EQ(set["alarms"].dump().find(text_of(Reason::clock_not_set)), std::string::npos) << set.dump();
  EXPECT_EQ(bench.logged_rows(), 1u) << "believed";
}

}  // namespace
}  // namespace airside::fault_matrix
