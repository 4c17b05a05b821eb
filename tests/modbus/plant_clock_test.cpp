// Clocks: the machine's own waits on monotonic time; a served plant's runs as fast as its server.

#include "hal/modbus/plant_clock.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdlib>
#include <optional>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "airside/controller/cycle.hpp"
#include "hal/modbus/wire.hpp"
#include "support/modbus_fixture.hpp"

namespace airside::hal {
namespace {

using namespace testing_peers;

TEST(SystemClock, SleepsUntilTheInstantAndSaysSo) {
  const SystemClock clock({}, 0);
  const CivilTime t{clock.now().seconds + 1};
  const std::int64_t start = monotonic_ns();
  EXPECT_TRUE(clock.sleep_until(t));
  EXPECT_GE(clock.now(), t);
  EXPECT_LT(seconds_since(start), 1.2);
  EXPECT_TRUE(clock.sleep_until(CivilTime{0})) << "the past is reached at once";
}

TEST(SystemClock, StopsWithinATenthOfASecond) {
  std::atomic<bool> stop{false};
  const SystemClock clock(StopFlag(&stop), 0);
  std::thread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    stop = true;
  });
  const std::int64_t start = monotonic_ns();
  EXPECT_FALSE(clock.sleep_until(CivilTime{clock.now().seconds + 3600}));
  EXPECT_LT(seconds_since(start), 0.4);
  stopper.join();
  volatile std::sig_atomic_t raised = 1;
  EXPECT_FALSE(SystemClock(StopFlag(&raised), 0).sleep_until(CivilTime{clock.now().seconds + 3600}));
}

TEST(SystemClock, CountsFromTheSitesStandardTime) {
  const SystemClock greenwich({}, 0);
  const SystemClock singapore({}, 8 * 3600);
  EXPECT_NEAR(static_cast<double>(singapore.now().seconds - greenwich.now().seconds), 8 * 3600, 1);
}

TEST(SystemClock, IsOfTheWinterTimeOfEveryZone) {
  const char* before = std::getenv("TZ");
  const std::string kept = before == nullptr ? "" : before;
  // In Ireland's own words summer is standard, and winter is an hour less.
  const std::vector<std::pair<const char*, int>> zones{
      {"IST-1GMT0,M10.5.0,M3.5.0/1", 0}, {"GMT0BST,M3.5.0/1,M10.5.0", 0},      {"CET-1CEST,M3.5.0,M10.5.0/3", 1},
      {"EST5EDT,M3.2.0,M11.1.0", -5},    {"AEST-10AEDT,M10.1.0,M4.1.0/3", 10}, {"CST-8", 8}};
  for (const auto& [zone, hours] : zones) {
    ::setenv("TZ", zone, 1);
    ::tzset();
    const std::int64_t apart_s = SystemClock({}, std::nullopt).now().seconds - SystemClock({}, 0).now().seconds;
    EXPECT_NEAR(static_cast<double>(apart_s), 3600.0 * hours, 1.0) << zone;
  }
  before == nullptr ? ::unsetenv("TZ") : ::setenv("TZ", kept.c_str(), 1);
  ::tzset();
}

TEST(SystemClock, HastensFromNowAndGoesOnWhereItWas) {
  const CivilTime begin = SystemClock({}, 0).now();
  SystemClock fast({}, 0, 3600);
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  const std::int64_t passed_s = fast.now().seconds - begin.seconds;
  EXPECT_GE(passed_s, 180);
  EXPECT_LT(passed_s, 36000) << "not from midnight: that would be hours for each second of the day";
  const CivilTime later{begin.seconds + 30 * 86400};
  fast.go_on_from(later);
  EXPECT_GE(fast.now(), later);
  EXPECT_LT(fast.now().seconds, later.seconds + 36000);
  fast.go_on_from(begin);
  EXPECT_GE(fast.now(), later) << "never back";
  SystemClock real({}, 0);
  real.go_on_from(later);
  EXPECT_LT(real.now(), later) << "the machine's own clock is never set";
}

/// A server whose plant steps to the wanted time, `step_s` at most each time somebody looks at it.
struct SteppingPlant {
  explicit SteppingPlant(const PointMap& map, double step_s) : served(map, {TcpListen{}, 1}) {
    ModbusServer& server = served.server();
    server.set("clock_s", 0);
    server.on_write([this](const Point& point, double value) {
      if (point.name == "clock_advance_s") wanted = value;
      return value;
    });
    server.refresh([this, step_s] {
      now = std::min(wanted, now + step_s);
      served.server().set("clock_s", now);
    });
    served.start();
  }
  double now = 0, wanted = 0;
  ServerThread served;
};

TEST(ModbusPlantClock, ServedPlantReachesTheWantedInstantAtAnySpeed) {
  const PointMap map = PointMap::parse(default_point_map(3, 0, 1), "points.csv");
  for (const double step_s : {1e9, 30.0}) {
    SteppingPlant plant(map, step_s);
    ModbusLink link(tcp_settings(plant.served.server().port()));
    ModbusPlantClock clock(map, link);
    EXPECT_EQ(clock.now(), clock_epoch);
    for (int row = 1; row <= 3; ++row) {
      const CivilTime t{clock_epoch.seconds + row * row_s};
      EXPECT_TRUE(clock.sleep_until(t));
      EXPECT_EQ(clock.now(), t);
    }
  }
}

TEST(ModbusPlantClock, StandingPlantIsGivenUpAndAStopIsHeard) {
  const PointMap map = PointMap::parse(default_point_map(3, 0, 1), "points.csv");
  SteppingPlant plant(map, 0.0);
  ModbusLink link(tcp_settings(plant.served.server().port()));
  std::atomic<bool> stop{false};
  ModbusPlantClock clock(map, link, StopFlag(&stop), 0.3);
  EXPECT_FALSE(clock.sleep_until(CivilTime{clock_epoch.seconds + 360}));
  EXPECT_TRUE(clock.stalled());
  stop = true;
  EXPECT_FALSE(clock.sleep_until(CivilTime{clock_epoch.seconds + 360}));
  EXPECT_FALSE(clock.stalled());
}

/// A plant whose clock runs so many times as fast as the machine's, from base_s on, and shows what a test adds to it.
class FreePlant {
 public:
  static constexpr double base_s = 100'000;

  FreePlant(const PointMap& map, double speed) : served_(map, {TcpListen{}, 1}) {
    served_.server().refresh([this, speed] {
      // A reading is a look at clock_s; a client that writes has had its own.
      const double seconds = base_s + speed * seconds_since(began_ns_);
      const double added = added_;
      if (readings_ != 0 && --readings_ == 0) added_ = 0;
      served_.server().set("clock_s", seconds + added);
    });
    served_.start();
  }
  int port() { return served_.server().port(); }
  CivilTime now(double speed) const {
    return {clock_epoch.seconds + static_cast<std::int64_t>(base_s + speed * seconds_since(began_ns_))};
  }
  /// Adds to the next `readings`, or to all from now on.
  void add(double seconds, int readings = 0) {
    readings_ = readings;
    added_ = seconds;
  }

 private:
  const std::int64_t began_ns_ = monotonic_ns();
  std::atomic<double> added_{0};
  std::atomic<int> readings_{0};
  ServerThread served_;
};

TEST(ModbusPlantClock, OneWrongReadingIsNotBelieved) {
  const PointMap map = PointMap::parse(default_point_map(3, 0, 1), "points.csv");
  for (const double wrong_s : {24.0 * seconds_per_day, 3 * 365.0 * seconds_per_day, 20'000.0, -30'000.0}) {
    FreePlant plant(map, 500);
    ModbusLink link(tcp_settings(plant.port()));
    ModbusPlantClock clock(map, link, {}, 5);
    const CivilTime before = clock.now();
    plant.add(wrong_s, 1);
    EXPECT_LE(std::abs(clock.now().seconds - before.seconds), ModbusPlantClock::leap_s) << wrong_s;
    const CivilTime t{before.seconds + row_s};
    plant.add(wrong_s, 2);  // the request, and the reading behind it
    EXPECT_TRUE(clock.sleep_until(t)) << wrong_s;
    EXPECT_GE(clock.woke(), t) << wrong_s;
    EXPECT_LE(clock.woke().seconds - t.seconds, ModbusPlantClock::leap_s) << wrong_s;
    EXPECT_GE(clock.jumps().doubted, 1U) << wrong_s;
    EXPECT_EQ(clock.jumps().taken, 0U) << wrong_s;
  }
}

TEST(ModbusPlantClock, AJumpThatStaysIsFollowedWithinASecond) {
  const PointMap map = PointMap::parse(default_point_map(3, 0, 1), "points.csv");
  for (const double jump_s : {24.0 * seconds_per_day, 10'000.0}) {
    FreePlant plant(map, 100);
    ModbusLink link(tcp_settings(plant.port()));
    ModbusPlantClock clock(map, link, {}, 5);
    const CivilTime before = clock.now();
    plant.add(jump_s);
    const std::int64_t began_ns = monotonic_ns();
    EXPECT_TRUE(clock.sleep_until({before.seconds + row_s})) << "it is past";
    EXPECT_LT(seconds_since(began_ns), 1.0);
    EXPECT_GE(clock.woke().seconds, before.seconds + static_cast<std::int64_t>(jump_s));
    EXPECT_EQ(clock.jumps().taken, 1U);
    EXPECT_EQ(clock.jumps().doubted, 0U);
  }
}

TEST(ModbusPlantClock, OneThatIsRightAgainIsFollowedBackAndNotWaitedFor) {
  const PointMap map = PointMap::parse(default_point_map(3, 0, 1), "points.csv");
  FreePlant plant(map, 100);
  ModbusLink link(tcp_settings(plant.port()));
  ModbusPlantClock clock(map, link, {}, 5);
  const CivilTime before = clock.now();
  plant.add(24 * seconds_per_day);
  ASSERT_TRUE(clock.sleep_until({before.seconds + row_s}));
  const CivilTime wrong = next_row(clock.now());
  plant.add(0);
  const std::int64_t began_ns = monotonic_ns();
  EXPECT_FALSE(clock.sleep_until({wrong.seconds + row_s}));
  EXPECT_LT(seconds_since(began_ns), 1.0);
  EXPECT_TRUE(clock.set_back());
  EXPECT_FALSE(clock.stalled());
  EXPECT_NEAR(static_cast<double>(clock.now().seconds), static_cast<double>(plant.now(100).seconds), 100);
  EXPECT_TRUE(clock.sleep_until(next_row(clock.now())));
  EXPECT_FALSE(clock.sleep_until({clock.now().seconds + 86400})) << "no wait is so long";
  EXPECT_TRUE(clock.set_back());
}

TEST(ModbusPlantClock, AWrongFirstReadingIsNotBelieved) {
  const PointMap map = PointMap::parse(default_point_map(3, 0, 1), "points.csv");
  FreePlant plant(map, 1);
  plant.add(24 * seconds_per_day, 1);
  ModbusLink link(tcp_settings(plant.port()));
  ModbusPlantClock clock(map, link);
  EXPECT_NEAR(static_cast<double>(clock.now().seconds), static_cast<double>(plant.now(1).seconds), 5);
}

TEST(ModbusPlantClock, APlantOfAnySpeedIsFollowed) {
  const PointMap map = PointMap::parse(default_point_map(3, 0, 1), "points.csv");
  FreePlant plant(map, 1e6);
  ModbusLink link(tcp_settings(plant.port()));
  ModbusPlantClock clock(map, link, {}, 20);
  const std::int64_t began_ns = monotonic_ns();
  for (int i = 0; i < 2; ++i) EXPECT_TRUE(clock.sleep_until(next_row({clock.now().seconds + 1})));
  EXPECT_LT(seconds_since(began_ns), 10.0);
}

TEST(ModbusPlantClock, NeedsBothPoints) {
  ModbusLink link(tcp_settings(1));
  const PointMap map = PointMap::parse(csv_header() + "clock_s,s,4,0,int32,,,1,0,0,2147483647,,,,,,,\n", "points.csv");
  EXPECT_THROW((ModbusPlantClock{map, link}), InputError);
}

}  // namespace
}  // namespace airside::hal
