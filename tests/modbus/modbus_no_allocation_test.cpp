// Once connected, the bus costs no heap: a controller that has started cannot run out of memory here.

#include <gtest/gtest.h>

#include <cmath>

#include "airside/supervision/envelope.hpp"
#include "hal/modbus/plant.hpp"
#include "hal/modbus/plant_clock.hpp"
#include "hal/points/register_codec.hpp"
#include "support/allocation_guard.hpp"
#include "support/modbus_fixture.hpp"

namespace airside::hal {
namespace {

using namespace testing_peers;
using footprint::AllocationGuard;

TEST(ModbusAllocation, ConnectedPlantAndClockNeverTouchTheHeap) {
  const PointMap map = PointMap::parse(default_point_map(5, 5, 2), "points.csv");
  ServerThread served(map, {TcpListen{}, 1});
  ModbusServer& server = served.server();
  double now_s = 0;
  server.set("clock_s", 0);
  server.on_write([&](const Point& point, double value) {
    if (point.name == "clock_advance_s") now_s = value;
    return value;
  });
  server.refresh([&] { server.set("clock_s", now_s); });
  served.start();
  ModbusLink link(tcp_settings(server.port()));
  ModbusPlant<FiveZone> plant(map, link);
  ModbusPlantClock clock(map, link);
  const SafetyEnvelope envelope{ControllerSettings{}};
  ASSERT_TRUE(plant.sense());

  bool all_sensed = true, all_applied = true, all_reached = true;
  {
    const AllocationGuard guard("100 cycles over Modbus");
    for (int i = 1; i <= 100; ++i) {
      all_reached &= clock.sleep_until(CivilTime{clock_epoch.seconds + i * row_s});
      all_sensed &= plant.sense().has_value();
      all_applied &= plant.actuate(envelope.limit(20.0 + 0.01 * i, std::nan(""), 20.0)).has_value();
      all_applied &= plant.beat();
    }
  }
  EXPECT_TRUE(all_reached && all_sensed && all_applied);
}

TEST(ModbusAllocation, ReconnectingNeverTouchesTheHeap) {
  const PointMap map = PointMap::parse(default_point_map(3, 0, 1), "points.csv");
  ServerThread served(map, {TcpListen{}, 1});
  served.start();
  ModbusLink link(tcp_settings(served.server().port()));
  std::array<std::uint16_t, 2> words{};
  ASSERT_TRUE(link.read(3, 0, words));
  bool all_read = true;
  {
    const AllocationGuard guard("reconnecting through libmodbus");
    for (int i = 0; i < 10; ++i) {
      link.close();
      all_read &= link.read(3, 0, words).has_value();
    }
  }
  EXPECT_TRUE(all_read);
  EXPECT_EQ(link.generation(), 11U);
  served.stop();
  bool none_read = true;
  {
    const AllocationGuard guard("a device that is gone");
    for (int i = 0; i < 3; ++i) none_read &= !link.read(3, 0, words).has_value();
  }
  EXPECT_TRUE(none_read);
}

TEST(ModbusAllocation, CodecNeverTouchesTheHeap) {
  const PointMap map = PointMap::parse(default_point_map(5, 5, 2), "points.csv");
  double sum = 0;
  {
    const AllocationGuard guard("rounding every point");
    for (const Point& p : map.points()) {
      sum += rounded(p, 0.5 * (p.min + p.max));
      sum += invalid_registers(p).word[0];
    }
  }
  EXPECT_TRUE(std::isfinite(sum));
}

}  // namespace
}  // namespace airside::hal
