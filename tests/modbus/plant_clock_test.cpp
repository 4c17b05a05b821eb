// Clocks: the machine's own waits on monotonic time; a served plant's runs as fast as its server.

#include "hal/modbus/plant_clock.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

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

TEST(ModbusPlantClock, NeedsBothPoints) {
  ModbusLink link(tcp_settings(1));
  const PointMap map = PointMap::parse(csv_header() + "clock_s,s,4,0,int32,,,1,0,0,2147483647,,,,,,,\n", "points.csv");
  EXPECT_THROW((ModbusPlantClock{map, link}), InputError);
}

}  // namespace
}  // namespace airside::hal
