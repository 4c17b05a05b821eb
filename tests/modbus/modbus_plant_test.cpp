// The plant behind Modbus: what the map says is what the loop sees, and what the device took is what it remembers.

#include "hal/modbus/plant.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>

#include "hal/modbus/wire.hpp"
#include "hal/points/register_codec.hpp"
#include "support/command_of.hpp"
#include "support/modbus_fixture.hpp"

namespace airside::hal {
namespace {

using namespace testing_peers;
using L = Layout<FiveZone>;

PointMap five_zone_map(const std::string& from = "", const std::string& to = "") {
  std::string csv = default_point_map(5, 5, 2);
  if (!from.empty()) {
    const std::size_t at = csv.find(from);
    if (at == std::string::npos) throw std::runtime_error("no " + from);
    csv.replace(at, from.size(), to);
  }
  return PointMap::parse(csv, "points.csv");
}

double value_of(int index) {
  const SignalKind kind = signal_id<FiveZone>(index).kind;
  return is_status(kind) ? index % 2 : 20.123456 + index / 7.0;
}

void publish_all(ModbusServer& server) {
  for (int i = 0; i < L::signals; ++i) server.set(point_name(signal_id<FiveZone>(i)), value_of(i));
  server.set("supply_temp", 16.5);
  server.set("clock_s", 86400);
}

struct Bench {
  explicit Bench(const PointMap& map, double exchange_s = 0.5)
      : served(map, {TcpListen{}, 1}), link(tcp_settings(served.server().port(), exchange_s)), plant(map, link) {
    publish_all(served.server());
  }
  ServerThread served;
  ModbusLink link;
  ModbusPlant<FiveZone> plant;
};

TEST(ModbusPlant, SensesEverySignalRoundedAsThePointMapSays) {
  const PointMap map = five_zone_map();
  Bench bench(map);
  bench.served.start();
  const auto reading = bench.plant.sense();
  ASSERT_TRUE(reading);
  for (int i = 0; i < L::signals; ++i) {
    const std::string name = point_name(signal_id<FiveZone>(i));
    EXPECT_EQ(reading->value[i], rounded(map.at(name), value_of(i))) << name;
    EXPECT_EQ(reading->age_s[i], 0.0);
  }
  EXPECT_EQ(reading->setpoint_degc, 18.0);
  EXPECT_EQ(reading->supply_temp_degc, 16.5);
  EXPECT_EQ(reading->time.seconds, clock_epoch.seconds + 86400);
  EXPECT_EQ(bench.link.counters().exchanges, 3U)
      << "one block of input and one of holding registers, and the fingerprint";
  ASSERT_TRUE(bench.plant.sense());
  EXPECT_EQ(bench.link.counters().exchanges, 5U) << "which is asked once a connection";
}

TEST(ModbusPlant, ReadsWhetherTheFanRunsWhereTheMapHasIt) {
  Bench without(five_zone_map());
  without.served.start();
  const auto unknown = without.plant.sense();
  ASSERT_TRUE(unknown);
  EXPECT_TRUE(std::isnan(unknown->flows));
  Bench bench(
      five_zone_map("setpoint,degc,3,0,", "ahu_on,,3,40,uint16,big,big,1,0,0,1,,,0xFFFF,,,,\nsetpoint,degc,3,0,"));
  bench.served.server().set("ahu_on", 0);
  bench.served.start();
  const auto still = bench.plant.sense();
  ASSERT_TRUE(still);
  EXPECT_EQ(still->flows, 0.0);
}

TEST(ModbusPlant, SentinelAndOutOfRangeAreNanAndNameTheirFault) {
  Bench bench(five_zone_map());
  bench.served.server().set("room_temp_2", std::nan(""));
  bench.served.server().set("room_temp_3", 60.0);
  bench.served.server().set("power_1", std::nan(""));
  bench.served.start();
  const auto reading = bench.plant.sense();
  ASSERT_TRUE(reading);
  EXPECT_TRUE(std::isnan(reading->value[1]));
  EXPECT_EQ(bench.plant.signal_fault(1), Fault::not_finite);
  EXPECT_TRUE(std::isnan(reading->value[2]));
  EXPECT_EQ(bench.plant.signal_fault(2), Fault::out_of_range);
  EXPECT_TRUE(std::isnan(reading->value[L::power]));
  EXPECT_FALSE(std::isnan(reading->value[0]));
}

TEST(ModbusPlant, WritesReadsBackAndSparesTheRegisterWhenNothingChanges) {
  Bench bench(five_zone_map());
  int writes = 0;
  bench.served.server().on_write([&](const Point&, double value) { return ++writes, value; });
  bench.served.start();
  ASSERT_TRUE(bench.plant.sense());
  for (int i = 0; i < 5; ++i) {
    const auto applied = bench.plant.actuate(command_of(20.5));
    ASSERT_TRUE(applied);
    EXPECT_EQ(applied->setpoint_degc, 20.5);
  }
  ASSERT_TRUE(bench.plant.actuate(command_of(20.6)));
  bench.served.stop();
  EXPECT_EQ(writes, 2);
  EXPECT_EQ(bench.served.server().get("setpoint"), 20.6);
}

TEST(ModbusPlant, RefreshPolicyWritesEveryTime) {
  Bench bench(five_zone_map("on-change,6,18,self", "refresh,16,18,self"));
  int writes = 0;
  bench.served.server().on_write([&](const Point&, double value) { return ++writes, value; });
  bench.served.start();
  ASSERT_TRUE(bench.plant.sense());
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(bench.plant.actuate(command_of(20.5)));
  bench.served.stop();
  EXPECT_EQ(writes, 3);
}

TEST(ModbusPlant, ClampedWriteIsRememberedAsTheDeviceTookIt) {
  Bench bench(five_zone_map());
  bench.served.server().on_write([](const Point&, double value) { return std::min(value, 20.0); });
  bench.served.start();
  ASSERT_TRUE(bench.plant.sense());
  const auto applied = bench.plant.actuate(command_of(26.0));
  ASSERT_TRUE(applied);
  EXPECT_EQ(applied->setpoint_degc, 20.0);
}

TEST(ModbusPlant, RefusedWriteIsNamed) {
  Bench bench(five_zone_map());
  bench.served.server().on_write([](const Point&, double) { return std::nan(""); });
  bench.served.start();
  ASSERT_TRUE(bench.plant.sense());
  EXPECT_EQ(bench.plant.actuate(command_of(26.0)).error(), Fault::write_refused);
  ASSERT_TRUE(bench.plant.sense()) << "reading goes on";
}

TEST(ModbusPlant, CommandOutsideThePointsLimitsNeverReachesTheBus) {
  Bench bench(five_zone_map("8,32,,,0x8000,on-change,6,18", "16,24,,,0x8000,on-change,6,18"));
  bench.served.start();
  ASSERT_TRUE(bench.plant.sense());
  EXPECT_EQ(bench.plant.actuate(command_of(30.0)).error(), Fault::not_applied);
  EXPECT_EQ(bench.plant.setpoint_writes(), 0U);
}

TEST(ModbusPlant, ForeignOverrideIsSeenAndWrittenOver) {
  Bench bench(five_zone_map());
  bench.served.start();
  ASSERT_TRUE(bench.plant.sense());
  ASSERT_TRUE(bench.plant.actuate(command_of(20.5)));
  ModbusLink foreign(tcp_settings(bench.served.server().port()));
  const std::array<std::uint16_t, 1> other = {1234};
  ASSERT_TRUE(foreign.write(6, 0, other));
  EXPECT_EQ(bench.plant.sense()->setpoint_degc, 12.34);
  EXPECT_EQ(bench.plant.actuate(command_of(20.5))->setpoint_degc, 20.5);
  EXPECT_EQ(bench.plant.sense()->setpoint_degc, 20.5);
}

TEST(ModbusPlant, WriteOnlyRegisterIsNeverReadAndAppliedIsWhatWasWritten) {
  Bench bench(five_zone_map("on-change,6,18,self", "on-change,6,18,none"));
  bench.served.start();
  ASSERT_TRUE(bench.plant.sense());
  EXPECT_TRUE(std::isnan(bench.plant.sense()->setpoint_degc));
  const auto applied = bench.plant.actuate(command_of(20.51));
  ASSERT_TRUE(applied);
  EXPECT_EQ(applied->setpoint_degc, 20.5);
  ASSERT_TRUE(bench.plant.actuate(command_of(20.5)));
  EXPECT_EQ(bench.plant.setpoint_writes(), 1U);
}

TEST(ModbusPlant, RefusedGroupIsSplitOnceAndOnlyTheMissingPointIsInvalid) {
  // The device lacks one register in the middle of the block that the map describes.
  const PointMap map = five_zone_map();
  const PointMap poorer = five_zone_map("vav_on_2,,4,11", "spare,,4,200");
  ServerThread served(poorer, {TcpListen{}, 1});
  served.server().set("map_fingerprint", map.told_fingerprint());
  for (const Point& p : poorer.points()) {
    if (p.fc == 4 && p.name != "map_fingerprint" && p.name != "spare")
      served.server().set(p.name, p.unit == "degc" ? 21.0 : 1.0);
  }
  served.start();
  ModbusLink link(tcp_settings(served.server().port()));
  ModbusPlant<FiveZone> plant(map, link);
  for (int turn = 0; turn < 2; ++turn) {
    const auto reading = plant.sense();
    ASSERT_TRUE(reading);
    for (int i = 0; i < L::signals; ++i) EXPECT_EQ(std::isnan(reading->value[i]), i == L::vav_on + 1) << i;
    EXPECT_EQ(plant.last_exception(), 2);
  }
}

TEST(ModbusPlant, ServerRestartCostsAtMostOneReading) {
  const PointMap map = five_zone_map();
  auto first = std::make_unique<ServerThread>(map, ServerSettings{TcpListen{}, 1});
  publish_all(first->server());
  first->start();
  const int port = first->server().port();
  ModbusLink link(tcp_settings(port));
  ModbusPlant<FiveZone> plant(map, link);
  ASSERT_TRUE(plant.sense());
  first.reset();
  EXPECT_EQ(plant.sense().error(), Fault::no_reading);
  EXPECT_EQ(plant.actuate(command_of(20.5)).error(), Fault::not_applied);
  ServerThread second(map, {TcpListen{"127.0.0.1", port}, 1});
  publish_all(second.server());
  second.start();
  ASSERT_TRUE(plant.sense());
  EXPECT_EQ(plant.actuate(command_of(20.5))->setpoint_degc, 20.5);
  EXPECT_EQ(link.generation(), 2U);
}

TEST(ModbusPlant, SilentDeviceHeartbeatAgesEverySignal) {
  const PointMap map = five_zone_map("heartbeat,,3,1,uint16,big,big,1,0,0,65535,,,,refresh,6,,self",
                                     "heartbeat,,3,1,uint16,big,big,1,0,0,65535,,,,,,,");
  Bench bench(map);
  int reads = -1;  // the first sense has one exchange more, for the fingerprint
  ModbusServer& server = bench.served.server();
  server.refresh([&] {
    ++reads;
    server.set("clock_s", 360.0 * (reads / 2));  // two exchanges a sense
    server.set("heartbeat", reads < 5 ? reads : 5);
  });
  bench.served.start();
  std::vector<double> ages;
  for (int i = 0; i < 6; ++i) ages.push_back(bench.plant.sense()->age_s[0]);
  EXPECT_EQ(ages[1], 0.0);
  EXPECT_EQ(ages[2], 0.0);
  EXPECT_GE(ages[4], 360.0);
  EXPECT_EQ(ages[5], ages[4] + 360.0);
}

TEST(ModbusPlant, BeatsUntilItStops) {
  Bench bench(five_zone_map());
  bench.served.start();
  EXPECT_FALSE(bench.plant.beat()) << "nothing is written before the device was read";
  ASSERT_TRUE(bench.plant.sense());
  for (int i = 0; i < 3; ++i) ASSERT_TRUE(bench.plant.beat());
  bench.served.stop();
  EXPECT_EQ(bench.served.server().get("heartbeat"), 3.0);
  EXPECT_FALSE(bench.plant.beat());
}

TEST(ModbusPlant, KeepsAConnectionWithoutAHeartbeatAlive) {
  const auto reads_of = [](const PointMap& map) {
    Bench bench(map);
    bench.served.start();
    bench.plant.keep_alive();
    EXPECT_FALSE(bench.link.connected()) << "it opens none";
    EXPECT_TRUE(bench.plant.sense());
    const std::uint64_t before = bench.link.counters().exchanges;
    bench.plant.keep_alive();
    EXPECT_TRUE(bench.plant.in_touch());
    return bench.link.counters().exchanges - before;
  };
  EXPECT_EQ(reads_of(five_zone_map()), 0U) << "the heartbeat does it";
  const PointMap without = five_zone_map("heartbeat,,3,1,uint16,big,big,1,0,0,65535,,,,refresh,6,,self",
                                         "heartbeat,,3,1,uint16,big,big,1,0,0,65535,,,,,,,");
  EXPECT_EQ(reads_of(without), 1U);
}

TEST(ModbusPlant, MapThatDoesNotFitTheTopologyIsRefused) {
  ModbusLink link(tcp_settings(1));
  EXPECT_THROW((ModbusPlant<ThreeVav>{five_zone_map(), link}), InputError);
}

TEST(ModbusPlant, TwoWeeksOfReadingsTakeSeconds) {
  Bench bench(five_zone_map());
  bench.served.start();
  const std::int64_t start = monotonic_ns();
  constexpr int rows = 2000;
  for (int i = 0; i < rows; ++i) ASSERT_TRUE(bench.plant.sense());
  const double sense_us = 1e6 * seconds_since(start) / rows;
  RecordProperty("sense_us", std::to_string(sense_us));
  std::printf("sense() of 28 points over loopback: %.0f us\n", sense_us);
  EXPECT_LT(sense_us, 5000.0) << "14 days are 3360 rows";
}

TEST(ModbusPlant, NothingIsWrittenToADeviceOfAnotherMap) {
  const PointMap map = five_zone_map();
  const PointMap other =
      five_zone_map("room_temp_1,degc,4,0,int16,big,big,0.01", "room_temp_1,degc,4,0,int16,big,big,0.1");
  ASSERT_NE(map.told_fingerprint(), other.told_fingerprint());
  ServerThread served(other, {TcpListen{}, 1});
  int writes = 0;
  served.server().on_write([&](const Point&, double value) { return ++writes, value; });
  served.start();
  ModbusLink link(tcp_settings(served.server().port()));
  ModbusPlant<FiveZone> plant(map, link);
  EXPECT_EQ(plant.sense().error(), Fault::other_device);
  EXPECT_TRUE(plant.other_device());
  EXPECT_EQ(plant.actuate(command_of(21)).error(), Fault::other_device);
  EXPECT_FALSE(plant.beat());
  served.stop();
  EXPECT_EQ(writes, 0);
}

TEST(ModbusPlant, AConstantOfTheDeviceMayStandInForTheFingerprint) {
  const PointMap map =
      five_zone_map("uint32,big,big,1,0,0,4294967295,,,,,,,", "uint32,big,big,1,0,0,4294967295,,,,,,4711,");
  EXPECT_EQ(map.told_fingerprint(), 4711);
  ServerThread served(map, {TcpListen{}, 1});
  served.server().set("clock_s", 0);
  served.start();
  ModbusLink link(tcp_settings(served.server().port()));
  ModbusPlant<FiveZone> plant(map, link);
  EXPECT_TRUE(plant.sense());
}

TEST(ModbusPlant, NothingIsWrittenOnAConnectionThatWasNotReadFirst) {
  Bench bench(five_zone_map());
  int writes = 0;
  bench.served.server().on_write([&](const Point&, double value) { return ++writes, value; });
  bench.served.start();
  EXPECT_EQ(bench.plant.actuate(command_of(21)).error(), Fault::not_applied);
  ASSERT_TRUE(bench.plant.sense());
  EXPECT_TRUE(bench.plant.actuate(command_of(21)));
  bench.served.stop();
  EXPECT_EQ(writes, 1);
}

}  // namespace
}  // namespace airside::hal
