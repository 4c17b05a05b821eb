// The write of the checkout: one step aside and back, and nothing that this program has not sent itself.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "hal/modbus/plant.hpp"
#include "support/command_of.hpp"
#include "support/modbus_fixture.hpp"

namespace airside::hal {
namespace {

using namespace testing_peers;

PointMap map_of(const std::string& policy, const std::string& scale = "0.01,0") {
  std::string csv = default_point_map(5, 5, 2);
  const std::string row = "setpoint,degc,3,0,int16,big,big,0.01,0,8,32,,,0x8000,on-change,6,18,self";
  const std::size_t at = csv.find(row);
  if (at == std::string::npos) throw std::runtime_error("another setpoint in the default map");
  csv.replace(at, row.size(), "setpoint,degc,3,0,int16,big,big," + scale + ",8,32,,,0x8000," + policy);
  return PointMap::parse(csv, "points.csv");
}

void publish_all(ModbusServer& server) {
  for (int i = 0; i < Layout<FiveZone>::signals; ++i) server.set(point_name(signal_id<FiveZone>(i)), 1);
  server.set("clock_s", 86400);
}

/// In control: 20.5 degC written and read back. What the device gets afterwards stands in `got`.
struct InControl {
  std::vector<double> got;
  ModbusServer::OnWrite behave = [](const Point&, double value) { return value; };
  ServerThread served;
  ModbusLink link;
  ModbusPlant<FiveZone> plant;

  explicit InControl(const PointMap& map = map_of("on-change,6,18,self"), double setpoint_degc = 20.5)
      : served(map, {TcpListen{}, 1}), link(tcp_settings(served.server().port())), plant(map, link) {
    publish_all(served.server());
    served.server().on_write([this](const Point& p, double value) {
      got.push_back(value);
      return behave(p, value);
    });
    served.start();
    if (!plant.sense() || !plant.actuate(command_of(setpoint_degc))) throw std::runtime_error("no control");
    got.clear();
  }
  ~InControl() { served.stop(); }
};

TEST(WriteCheck, MovesTheSetpointAndPutsItBack) {
  for (const char* policy : {"on-change,6,18,self", "refresh,16,18,self"}) {
    InControl box(map_of(policy));
    const WriteCheck check = box.plant.check_write(0.5, 18, 27);
    EXPECT_EQ(check.fault, Fault::none);
    EXPECT_EQ(check.before, 20.5);
    EXPECT_EQ(check.sent, 21.0);
    EXPECT_EQ(check.taken, 21.0);
    EXPECT_EQ(check.restored, 20.5);
    EXPECT_EQ(box.got, (std::vector<double>{21.0, 20.5}));
    EXPECT_EQ(box.plant.sense()->setpoint_degc, 20.5);
    EXPECT_EQ(box.plant.actuate(command_of(20.6))->setpoint_degc, 20.6) << "control goes on";
  }
}

TEST(WriteCheck, StaysWithinTheLimits) {
  InControl box;
  EXPECT_EQ(box.plant.check_write(0.5, 18, 20.9).sent, 20.0) << "downwards where there is no room above";
  EXPECT_EQ(box.got, (std::vector<double>{20.0, 20.5}));
  const WriteCheck none = box.plant.check_write(0.5, 20.2, 20.9);
  EXPECT_EQ(none.fault, Fault::out_of_range);
  EXPECT_TRUE(std::isnan(none.taken));
  EXPECT_EQ(box.plant.check_write(0.5, 20.6, 20.9).fault, Fault::out_of_range) << "outside the limits already";
  EXPECT_EQ(box.got.size(), 2U);
}

TEST(WriteCheck, TakesAWholeStepOfACoarseRegister) {
  InControl box(map_of("on-change,6,18,self", "1,0"), 20);
  EXPECT_EQ(box.plant.check_write(0.5, 18, 27).taken, 21.0);
  EXPECT_EQ(box.got, (std::vector<double>{21.0, 20.0}));
}

TEST(WriteCheck, NeverSendsAValueThatAnotherHasSet) {
  InControl box;
  ModbusLink person(tcp_settings(box.served.server().port()));
  ASSERT_TRUE(person.write(6, 0, std::array<std::uint16_t, 1>{2222}));
  box.got.clear();
  EXPECT_EQ(box.plant.check_write(0.5, 18, 27).fault, Fault::released);
  EXPECT_TRUE(box.got.empty());
  EXPECT_EQ(box.plant.sense()->setpoint_degc, 22.22);
}

TEST(WriteCheck, NothingIsWrittenBeforeControlHasWritten) {
  const PointMap map = map_of("on-change,6,18,self");
  ServerThread served(map, {TcpListen{}, 1});
  publish_all(served.server());
  served.start();
  ModbusLink link(tcp_settings(served.server().port()));
  ModbusPlant<FiveZone> plant(map, link);
  EXPECT_EQ(plant.check_write(0.5, 18, 27).fault, Fault::released);
  EXPECT_EQ(plant.setpoint_writes(), 0U);
}

TEST(WriteCheck, SaysWhatADeviceMakesOfIt) {
  {
    InControl clamping;
    clamping.behave = [](const Point&, double value) { return std::min(value, 20.7); };
    const WriteCheck check = clamping.plant.check_write(0.5, 18, 27);
    EXPECT_EQ(check.fault, Fault::not_applied);
    EXPECT_EQ(check.taken, 20.7);
    EXPECT_EQ(check.restored, 20.5);
  }
  {
    InControl refusing;
    refusing.behave = [](const Point&, double) { return std::nan(""); };
    const WriteCheck check = refusing.plant.check_write(0.5, 18, 27);
    EXPECT_EQ(check.fault, Fault::write_refused);
    EXPECT_TRUE(std::isnan(check.taken));
    EXPECT_EQ(check.restored, 20.5) << "which stands there still";
  }
  {
    InControl keeping;
    keeping.behave = [](const Point&, double value) { return std::max(value, 21.0); };
    const WriteCheck check = keeping.plant.check_write(0.5, 18, 27);
    EXPECT_EQ(check.fault, Fault::not_applied);
    EXPECT_EQ(check.taken, 21.0);
    EXPECT_EQ(check.restored, 21.0) << "not put back, and said";
  }
  {
    InControl once;
    once.behave = [](const Point&, double value) { return value < 20.9 ? std::nan("") : value; };
    const WriteCheck check = once.plant.check_write(0.5, 18, 27);
    EXPECT_EQ(check.fault, Fault::write_refused);
    EXPECT_EQ(check.taken, 21.0);
    EXPECT_TRUE(std::isnan(check.restored));
  }
}

TEST(WriteCheck, WithoutAnAnswerNothingIsTried) {
  InControl box;
  box.served.stop();
  const WriteCheck check = box.plant.check_write(0.5, 18, 27);
  EXPECT_EQ(check.fault, Fault::no_reading);
  EXPECT_TRUE(std::isnan(check.sent));
}

}  // namespace
}  // namespace airside::hal
