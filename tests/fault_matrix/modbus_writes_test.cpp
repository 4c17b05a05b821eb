// Rows 15, 20, 21, 22 and 26: to whom, when and what is written, and what is never written.

#include "fault_matrix/modbus_rig.hpp"
#include "hal/points/word_order.hpp"

namespace airside::fault_matrix {
namespace {

using Desk = ChaosDesk;

/// Writes with the number of the connection on which nothing was read before.
std::size_t writes_before_reading(const Desk& desk) {
  std::size_t found = 0;
  std::uint64_t fingerprint_read_on = 0;
  for (const ChaosExchange& e : desk.exchanges()) {
    if (e.request.function == 4 && e.request.addr == fingerprint_addr && e.taken()) fingerprint_read_on = e.connection;
    if (e.request.writes() && fingerprint_read_on != e.connection) ++found;
  }
  return found;
}

TEST(ModbusWrites, Row15RestartedServerIsVerifiedAndReadBeforeTheFirstWrite) {
  Desk desk("n=12 refuse:s=0.3", 0.02);
  int lost = 0, taken = 0;
  for (int i = 0; i < 40; ++i) {
    if (const auto reading = desk.plant.sense()) {
      desk.expect_right(reading);
    } else {
      ++lost;
    }
    taken += desk.plant.actuate(command_of(20.0 + 0.1 * i)).has_value();
    (void)desk.plant.beat();
    hal::sleep_until_ns(hal::monotonic_ns() + 20'000'000, {});
  }
  EXPECT_GT(lost, 2) << "it was away for 0.3 s";
  EXPECT_LT(lost, 30);
  EXPECT_GT(taken, 10);
  EXPECT_GE(desk.link.generation(), 2U);
  EXPECT_LE(desk.link.generation(), 3U) << "at most one connection to the server that is going";
  EXPECT_EQ(writes_before_reading(desk), 0U);
}

TEST(ModbusWrites, Row15AConnectionThatIsLostBetweenReadingAndWritingIsNotWrittenTo) {
  for (const char* policy : {"on-change,6,18,self", "refresh,16,18,self", "on-change,6,18,none", "refresh,6,18,none"}) {
    const hal::PointMap map = room_map("on-change,6,18,self", policy);
    Desk desk("", 0.0, map, map);
    for (int i = 0; i < 5; ++i) {
      ASSERT_TRUE(desk.plant.sense());
      desk.link.close();  // as a firewall does with what it has forgotten
      EXPECT_EQ(desk.plant.actuate(command_of(21.0 + i)).error(), Fault::not_applied) << policy;
      EXPECT_FALSE(desk.plant.beat()) << policy;
    }
    EXPECT_EQ(desk.writes_taken(), 0U) << policy;
    ASSERT_TRUE(desk.plant.sense());
    EXPECT_TRUE(desk.plant.actuate(command_of(22.0))) << policy;
  }
}

TEST(ModbusWrites, Row20DeviceThatWasExchangedDuringAReconnectIsNeverWrittenTo) {
  Desk desk;
  desk.expect_undisturbed();
  const std::size_t before = desk.writes_taken();
  desk.proxy.use(rules_of("n=1.. set:addr=" + std::to_string(fingerprint_addr) + ",value=4711"));
  EXPECT_TRUE(desk.plant.sense()) << "on one connection it is the same device";
  desk.link.close();
  for (int i = 0; i < 5; ++i) {
    EXPECT_EQ(desk.plant.sense().error(), Fault::other_device);
    EXPECT_EQ(desk.plant.actuate(command_of(24)).error(), Fault::other_device);
    EXPECT_FALSE(desk.plant.beat());
  }
  EXPECT_EQ(desk.writes_taken(), before);
  desk.proxy.use({});
  desk.link.close();
  desk.expect_right(desk.plant.sense());
  EXPECT_TRUE(desk.plant.actuate(command_of(24))) << "the right device again";
}

TEST(ModbusWrites, Row20MapWithOneOtherColumnIsNeverWrittenTo) {
  const hal::PointMap other =
      room_map("room_temp_1,degc,4,0,int16,big,big,0.01", "room_temp_1,degc,4,0,int16,big,big,0.1");
  Desk desk("", 0.0, room_map(), other);
  EXPECT_EQ(desk.plant.sense().error(), Fault::other_device);
  EXPECT_EQ(desk.plant.actuate(command_of(24)).error(), Fault::other_device);
  EXPECT_FALSE(desk.plant.beat());
  EXPECT_EQ(desk.writes_taken(), 0U);
}

TEST(ModbusWrites, Row21ExchangedWordsAreInvalidNamedAndNeverSwitched) {
  const hal::PointMap map = room_map();
  const std::string addr = std::to_string(map.at("power_2").addr);
  Desk desk("swap:addr=" + addr);
  for (int row = 0; row < 30; ++row) {
    const auto reading = desk.plant.sense();
    desk.expect_right(reading, Desk::L::power + 1);
    if (row >= 1) {
      ASSERT_NE(desk.plant.order_doubted(), nullptr);
      EXPECT_EQ(desk.plant.order_doubted()->name, "power_2");
    }
  }
  desk.proxy.use({});  // somebody has corrected the device
  int rows = 0;
  while (desk.plant.order_doubted() != nullptr && rows < 20) ++rows, (void)desk.plant.sense();
  EXPECT_GT(rows, 3) << "not believed at once";
  EXPECT_LT(rows, 12);
  desk.expect_right(desk.plant.sense());
}

TEST(ModbusWrites, Row21ExchangedWordsThatLookLikeATinyNumberAreNoValueOnceTheyAreDoubted) {
  const hal::PointMap map = room_map();
  // 3.0 is 4040 0000; exchanged it is 0000 4040, 2.3e-41, which is in range.
  const hal::Point& p = map.at("power_1");
  const std::array<std::uint16_t, 2> tiny = {0x0000, 0x4040}, right = {0x4040, 0x0000}, zero = {0, 0};
  EXPECT_TRUE(hal::decode(p, tiny)) << "range alone does not see it";
  EXPECT_TRUE(hal::fits_other_order_only(p, tiny));
  EXPECT_FALSE(hal::fits_other_order_only(p, right));
  EXPECT_FALSE(hal::fits_other_order_only(p, zero)) << "a meter at rest";
}

TEST(ModbusWrites, Row21WithoutExchangedWordsNoOrderIsDoubted) {
  Desk desk;
  desk.expect_undisturbed();
  desk.served.stop();
  // Every power that a meter of this room may show, in the order of the map.
  const hal::Point& p = desk.map.at("power_1");
  for (double kw = 0; kw <= 500; kw += 0.037) {
    const auto registers = hal::encode(p, kw);
    ASSERT_TRUE(registers);
    ASSERT_FALSE(hal::fits_other_order_only(p, registers->used())) << kw;
  }
}

TEST(ModbusWrites, Row22OtherFunctionIsTriedOnceAndKept) {
  Desk desk("on=write fc=6 at=0 exception:code=1");
  for (int i = 0; i < 5; ++i) {
    ASSERT_TRUE(desk.plant.sense());
    EXPECT_NEAR(desk.plant.actuate(command_of(22.0 + 0.1 * i))->setpoint_degc, 22.0 + 0.1 * i, 1e-9);
  }
  EXPECT_EQ(desk.count([](const ChaosExchange& e) { return writes_setpoint(e) && e.request.function == 6; }), 1U);
  EXPECT_EQ(desk.count([](const ChaosExchange& e) { return writes_setpoint(e) && e.request.function == 16; }), 5U);
}

TEST(ModbusWrites, Row22RefusalOfBothFunctionsIsARefusal) {
  for (const std::string code : {"1", "2", "3", "4"}) {
    Desk desk("on=write at=0 exception:code=" + code);
    for (int i = 0; i < 3; ++i) {
      ASSERT_TRUE(desk.plant.sense()) << code << " " << i;
      EXPECT_EQ(desk.plant.actuate(command_of(22)).error(), Fault::write_refused) << code << " " << i;
    }
    EXPECT_EQ(desk.writes_taken(), 0U);
    const auto by_16 = [](const ChaosExchange& e) { return writes_setpoint(e) && e.request.function == 16; };
    EXPECT_LE(desk.count(by_16), 1U) << "the other function is tried once";
    desk.proxy.use({});
    ASSERT_TRUE(desk.plant.sense());
    EXPECT_TRUE(desk.plant.actuate(command_of(22)));
  }
}

TEST(ModbusWrites, Row22WithoutARefusalTheMapsFunctionIsUsed) {
  Desk desk;
  desk.expect_undisturbed();
  EXPECT_EQ(desk.count([](const ChaosExchange& e) { return e.request.function == 16; }), 0U);
}

TEST(ModbusWrites, Row22OverANumberThatNoSetpointCanBeNothingIsWritten) {
  const std::string impossible = "fc=3 at=0 set:addr=0,value=9000";  // 90 degC: a map of another scale, or a person's
  Desk desk(impossible);
  for (int i = 0; i < 3; ++i) {
    ASSERT_TRUE(desk.plant.sense());
    EXPECT_EQ(desk.plant.actuate(command_of(22)).error(), Fault::out_of_range);
  }
  EXPECT_EQ(desk.count(writes_setpoint), 0U);
  desk.proxy.use({});
  ASSERT_TRUE(desk.plant.sense());
  EXPECT_EQ(desk.plant.actuate(command_of(22))->setpoint_degc, 22.0);
  const std::size_t before = desk.count(writes_setpoint);
  desk.proxy.use(rules_of(impossible));
  ASSERT_TRUE(desk.plant.sense());
  EXPECT_EQ(desk.plant.actuate(command_of(23)).error(), Fault::out_of_range) << "22 was ours, 90 is not";
  EXPECT_EQ(desk.count(writes_setpoint), before);
}

TEST(ModbusWrites, Row26WriteOnlySetpointIsNeverReadAndNothingIsWrittenTwice) {
  const hal::PointMap map = room_map("on-change,6,18,self", "on-change,6,18,none");
  Desk desk("", 0.0, map, map);
  for (int i = 0; i < 6; ++i) {
    const auto reading = desk.plant.sense();
    desk.expect_right(reading);
    EXPECT_TRUE(std::isnan(reading->setpoint_degc));
    EXPECT_TRUE(std::isfinite(reading->supply_temp_degc)) << "what it is judged by";
    EXPECT_EQ(desk.plant.actuate(command_of(22.0 + i / 2))->setpoint_degc, 22.0 + i / 2);
  }
  EXPECT_EQ(desk.count(writes_setpoint), 3U);
  const auto reads = [](const ChaosExchange& e) { return e.request.function == 3 && e.request.addr == 0; };
  EXPECT_EQ(desk.count(reads), 0U);
}

TEST(ModbusWrites, Row26WriteOfUnknownFateIsRepeatedBeforeAnother) {
  for (const char* fault : {"mute", "drop", "reset", "late:s=0.8", "truncate:bytes=5"}) {
    const hal::PointMap map = room_map("on-change,6,18,self", "on-change,6,18,none");
    Desk desk(std::string("n=4 on=write at=0 ") + fault, 0.0, map, map);
    ASSERT_TRUE(desk.plant.sense());  // inputs, fingerprint
    ASSERT_TRUE(desk.plant.actuate(command_of(22.0)));
    EXPECT_EQ(desk.plant.actuate(command_of(25.0)).error(), Fault::not_applied) << fault;
    ASSERT_TRUE(desk.plant.sense());
    const auto again = desk.plant.actuate(command_of(20.0));
    ASSERT_TRUE(again) << fault;
    EXPECT_EQ(again->setpoint_degc, 25.0) << fault << ": 20 would be two steps from 22 or 25, whichever stands";
    EXPECT_EQ(desk.plant.actuate(command_of(20.5))->setpoint_degc, 20.5) << fault;
  }
}

TEST(ModbusWrites, Row26WriteOnlySetpointNeedsASupplySensor) {
  std::string csv = hal::default_point_map(5, 5, 2);
  csv.replace(csv.find("on-change,6,18,self"), 19, "on-change,6,18,none");
  csv.replace(csv.find("supply_temp"), 11, "spare_value");
  const hal::PointMap map = hal::PointMap::parse(csv, "points.csv");
  try {
    map.check_topology(5, 5, 2);
    FAIL() << "nobody could tell whether the AHU follows";
  } catch (const hal::InputError& e) {
    EXPECT_NE(std::string(e.what()).find("supply_temp"), std::string::npos) << e.what();
  }
}

TEST(ModbusWrites, Row26WithoutAWriteOnlyRegisterWhatStandsIsReadFirst) {
  for (const char* fault : {"mute", "drop", "reset"}) {
    Desk desk(std::string("n=5 on=write at=0 ") + fault);
    ASSERT_TRUE(desk.plant.sense());  // three exchanges; then what stands, the write, the read-back
    EXPECT_EQ(desk.plant.actuate(command_of(25.0)).has_value(), false) << fault;
    const auto reading = desk.plant.sense();
    ASSERT_TRUE(reading);
    EXPECT_EQ(reading->setpoint_degc, fault[0] == 'd' ? 21.0 : 25.0) << fault;
    EXPECT_EQ(desk.plant.actuate(command_of(22.0))->setpoint_degc, 22.0) << fault;
  }
}

TEST(ModbusWrites, Row26RegisterThatCannotBeReadAnyMoreIsSentTheSameValueAgain) {
  // The answer to a write is lost, and the register cannot be read any more: the controller does not know what stands.
  Desk desk("n=5 on=write at=0 mute\nn=6.. on=read fc=3 at=0 exception:code=2");
  ASSERT_TRUE(desk.plant.sense());
  EXPECT_FALSE(desk.plant.actuate(command_of(25.0)));
  const auto reading = desk.plant.sense();
  ASSERT_TRUE(reading);
  EXPECT_TRUE(std::isnan(reading->setpoint_degc));
  EXPECT_FALSE(desk.plant.actuate(command_of(9.0))) << "it cannot be read back";
  for (const ChaosExchange& e : desk.exchanges()) {
    if (!writes_setpoint(e)) continue;
    EXPECT_EQ(hal::get16(&e.asked[10]), 2500);
  }
}

TEST(ModbusWrites, Row26WhatStoodThereUnsentIsNeverSent) {
  // At the first row another's 29 degC stands there; then the register cannot be read any more.
  Desk desk("n=4.. on=read fc=3 at=0 exception:code=2");
  desk.served.server().set("setpoint", 29.0);
  ASSERT_EQ(desk.plant.sense()->setpoint_degc, 29.0);
  for (int row = 0; row < 3; ++row) {
    ASSERT_TRUE(desk.plant.sense());
    EXPECT_EQ(desk.plant.actuate(command_of(24.5)).error(), Fault::not_applied);
  }
  EXPECT_EQ(desk.count(writes_setpoint), 0U);
  EXPECT_TRUE(desk.plant.map_refused()) << "or nobody would know why";
}

TEST(ModbusWrites, Row26AnotherHandsValueIsNotSentAfterOnesOwn) {
  Desk desk;
  ASSERT_TRUE(desk.plant.sense());
  ASSERT_TRUE(desk.plant.actuate(command_of(22.0)));
  desk.served.server().set("setpoint", 27.0);
  ASSERT_EQ(desk.plant.sense()->setpoint_degc, 27.0);
  desk.proxy.use(rules_of("on=write at=0 exception:code=2"));
  ASSERT_EQ(desk.plant.actuate(command_of(24.0)).error(), Fault::write_refused);
  desk.proxy.use(rules_of("on=read fc=3 at=0 exception:code=2"));
  const std::size_t before = desk.count(writes_setpoint);
  for (int row = 0; row < 3; ++row) {
    ASSERT_TRUE(desk.plant.sense());
    EXPECT_EQ(desk.plant.actuate(command_of(24.0)).error(), Fault::not_applied);
  }
  EXPECT_EQ(desk.count(writes_setpoint), before) << "neither 27 nor 22: nobody knows what stands";
}

TEST(ModbusWrites, Row15WithoutARestartEachWriteArrives) {
  Desk desk;
  desk.expect_undisturbed();
  EXPECT_EQ(writes_before_reading(desk), 0U);
  EXPECT_EQ(desk.count(writes_setpoint), 19U) << "21.0 stood there already";
}

TEST(ModbusWrites, Row20WithoutAnotherFingerprintAReconnectChangesNothing) {
  Desk desk;
  desk.expect_undisturbed();
  desk.link.close();
  desk.expect_right(desk.plant.sense());
  EXPECT_TRUE(desk.plant.actuate(command_of(24)));
}

}  // namespace
}  // namespace airside::fault_matrix
