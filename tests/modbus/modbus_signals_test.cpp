// Which sensors make up a signal, over real TCP: several in a zone, none and a stand-in.

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "hal/modbus/plant.hpp"
#include "support/modbus_fixture.hpp"

namespace airside::hal {
namespace {

using namespace testing_peers;
using L = Layout<ThreeVav>;

/// The map of a site without the rows whose names begin with one of `without`, and with `rows` more.
PointMap map_of(const std::vector<std::string>& without, const std::string& rows = "") {
  const std::string all = default_point_map(3, 0, 1);
  std::string kept;
  for (std::size_t at = 0; at < all.size();) {
    const std::size_t end = all.find('\n', at) + 1;
    const std::string line = all.substr(at, end - at);
    bool keep = true;
    for (const std::string& name : without) keep = keep && !line.starts_with(name);
    if (keep) kept += line;
    at = end;
  }
  return PointMap::parse(kept + rows, "points.csv");
}

std::string sensor_row(const std::string& name, int addr) {
  return name + ",degc,4," + std::to_string(addr) + ",int16,big,big,0.01,0,5,45,1.0,1200,0x8000,,,,\n";
}

struct Bench {
  explicit Bench(const PointMap& map, const ModbusPlantOptions& options = {})
      : served(map, {TcpListen{}, 1}), link(tcp_settings(served.server().port(), 0.5)), plant(map, link, options) {
    for (const Point& p : map.points()) {
      if (!p.writable() && p.name != "map_fingerprint") served.server().set(p.name, 0.5 * (p.min + p.max));
    }
    served.server().set("clock_s", 86400);
  }
  ServerThread served;
  ModbusLink link;
  ModbusPlant<ThreeVav> plant;
};

TEST(ModbusSignals, RoomOfThreeSensorsIsAtTheirMedianAndOfTwoAtTheirMean) {
  Bench bench(
      map_of({"room_temp_2,", "room_temp_3,"}, sensor_row("room_temp_2a", 100) + sensor_row("room_temp_2b", 101) +
                                                   sensor_row("room_temp_2c", 102) + sensor_row("room_temp_3a", 110) +
                                                   sensor_row("room_temp_3b", 120)));
  ModbusServer& server = bench.served.server();
  server.set("room_temp_1", 24);
  server.set("room_temp_2a", 25);
  server.set("room_temp_2b", 31);
  server.set("room_temp_2c", 25.4);
  server.set("room_temp_3a", 25);
  server.set("room_temp_3b", 26);
  bench.served.start();
  const auto reading = bench.plant.sense();
  ASSERT_TRUE(reading);
  EXPECT_EQ(reading->value[0], 24.0);
  EXPECT_DOUBLE_EQ(reading->value[1], 25.4);
  EXPECT_DOUBLE_EQ(reading->value[2], 25.5);
}

TEST(ModbusSignals, BadSensorOfAZoneIsLeftOutAndTheZoneIsLostWithTheLast) {
  const PointMap map = map_of({"room_temp_2,"}, sensor_row("room_temp_2a", 100) + sensor_row("room_temp_2b", 101));
  for (const double second : {26.0, std::nan("")}) {
    Bench bench(map);
    bench.served.server().set("room_temp_2a", std::nan(""));
    bench.served.server().set("room_temp_2b", second);
    bench.served.start();
    const auto reading = bench.plant.sense();
    ASSERT_TRUE(reading);
    EXPECT_EQ(std::isnan(reading->value[1]), std::isnan(second));
    if (!std::isnan(second)) {
      EXPECT_DOUBLE_EQ(reading->value[1], 26.0);
    }
    EXPECT_EQ(bench.plant.signal_fault(1), std::isnan(second) ? Fault::not_finite : Fault::none);
  }
}

TEST(ModbusSignals, SignalWithoutARowReadsAsItsStandIn) {
  StandIns in;
  in.set("rain", 0);
  in.set("mau_temp", 18);
  in.set("power", 4);
  in.set("vav_on", 1);
  Bench bench(map_of({"rain,", "mau_temp,", "power_", "vav_on_"}), {.utc_offset_s = std::nullopt, .stand_ins = in});
  bench.served.start();
  const auto reading = bench.plant.sense();
  ASSERT_TRUE(reading);
  EXPECT_EQ(reading->value[L::rain], 0.0);
  EXPECT_EQ(reading->value[L::mau_temp], 18.0);
  EXPECT_EQ(reading->value[L::power], 4.0);
  EXPECT_EQ(reading->value[L::vav_on + 2], 1.0);
  EXPECT_EQ(reading->value[L::outdoor_temp], 10.0) << "sensed";
  EXPECT_EQ(bench.plant.signal_fault(L::rain), Fault::none);
}

TEST(ModbusSignals, SideSignalsAreReadWhereTheMapHasThemAndAreNoNumbersElsewhere) {
  Bench bench(map_of({}, "damper_2,,4,100,uint16,big,big,0.01,0,0,1,,,,,,,\n" + sensor_row("zone_setpoint_3", 101) +
                             "occupied,,4,102,uint16,big,big,1,0,0,1,,,,,,,\n"
                             "supply_flow,m3/s,4,103,uint16,big,big,0.001,0,0,9,,,,,,,\n"));
  ModbusServer& server = bench.served.server();
  server.set("damper_2", 0.37);
  server.set("zone_setpoint_3", 24.5);
  server.set("occupied", 1);
  server.set("supply_flow", 1.234);
  bench.served.start();
  const auto reading = bench.plant.sense();
  ASSERT_TRUE(reading);
  EXPECT_TRUE(std::isnan(reading->damper(0)));
  EXPECT_DOUBLE_EQ(reading->damper(1), 0.37) << "percent in the register, by scale";
  EXPECT_DOUBLE_EQ(reading->zone_setpoint_degc(2), 24.5);
  EXPECT_TRUE(std::isnan(reading->zone_setpoint_degc(1)));
  EXPECT_EQ(reading->occupied, 1.0);
  EXPECT_DOUBLE_EQ(reading->supply_flow_m3s, 1.234);
  EXPECT_TRUE(std::isnan(reading->flows));
}

TEST(ModbusSignals, MapWithoutTheRowAndWithoutAStandInIsRefused) {
  const PointMap map = map_of({"rain,"});
  ServerThread served(map, {TcpListen{}, 1});
  ModbusLink link(tcp_settings(served.server().port(), 0.5));
  EXPECT_THROW(ModbusPlant<ThreeVav>(map, link), InputError);
}

TEST(ModbusSignals, BothFormsOfAZoneAndForeignPlacesAreRefused) {
  const auto complaint = [](const PointMap& map) {
    try {
      map.check_topology(3, 0, 1);
    } catch (const InputError& e) {
      return std::string(e.what());
    }
    return std::string();
  };
  EXPECT_NE(complaint(map_of({}, sensor_row("room_temp_2a", 100))).find("\"room_temp_2a\" beside \"room_temp_2\""),
            std::string::npos);
  EXPECT_NE(complaint(map_of({}, sensor_row("room_temp_4b", 100))).find("room_temp_1 to room_temp_3"),
            std::string::npos);
  EXPECT_NE(complaint(map_of({}, "damper_4,,4,100,uint16,big,big,0.01,0,0,1,,,,,,,\n")).find("damper_1 to damper_3"),
            std::string::npos);
  EXPECT_EQ(complaint(map_of({}, "damper_3,,4,100,uint16,big,big,0.01,0,0,1,,,,,,,\n")), "");
  EXPECT_THROW(map_of({}, "supply_flow,m3/h,4,100,uint16,big,big,1,0,0,9999,,,,,,,\n"), InputError) << "another unit";
  EXPECT_NO_THROW(map_of({}, "supply_flow,m3/s,4,100,uint16,big,big,0.001,0,0,9,,,,,,,\n"));
}

}  // namespace
}  // namespace airside::hal
