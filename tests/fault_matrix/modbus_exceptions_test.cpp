// Rows 8 to 13: what each exception code is answered with.

#include "fault_matrix/modbus_rig.hpp"

namespace airside::fault_matrix {
namespace {

using Desk = ChaosDesk;

TEST(ModbusExceptions, Row08IllegalFunctionIsAskedOnceAndTheMapIsDoubted) {
  Desk desk("at=0 fc=4 exception:code=1", 5.0);
  EXPECT_EQ(desk.plant.sense().error(), Fault::no_reading) << "the clock is among what was refused";
  EXPECT_EQ(desk.count(reads_inputs), 1U) << "asked once";
  EXPECT_TRUE(desk.plant.map_refused());
  EXPECT_TRUE(desk.link.connected());
  EXPECT_EQ(desk.link.backoff_left_s(), 0.0) << "the request is at fault, not the device";
  desk.proxy.use({});
  desk.expect_right(desk.plant.sense());
  EXPECT_FALSE(desk.plant.map_refused());
}

TEST(ModbusExceptions, Row09OneMissingRegisterSplitsTheGroupOnceAndOnlyItsPointIsInvalid) {
  Desk desk("at=10 fc=4 exception:code=2", 5.0);
  const int lost = Desk::L::vav_on;  // at address 10
  ASSERT_EQ(desk.map.at("vav_on_1").addr, 10);
  for (int turn = 0; turn < 3; ++turn) {
    desk.expect_right(desk.plant.sense(), lost);
    EXPECT_TRUE(desk.plant.map_refused());
  }
  const auto whole = [](const ChaosExchange& e) { return reads_inputs(e) && e.request.count > 1; };
  EXPECT_EQ(desk.count(whole), 1U) << "the group is split once";
  const auto missing = [](const ChaosExchange& e) { return e.request.function == 4 && e.request.addr == 10; };
  EXPECT_EQ(desk.count(missing), 3U) << "and its missing point is asked for once a poll";
}

TEST(ModbusExceptions, Row10RefusedCountIsHalvedUntilItFitsAndNothingIsAskedTwice) {
  Desk desk("wider=9 exception:code=3", 5.0);
  desk.expect_right(desk.plant.sense());
  EXPECT_TRUE(desk.plant.map_refused());
  const std::vector<ChaosExchange> first = desk.exchanges();
  for (const ChaosExchange& a : first) {
    for (const ChaosExchange& b : first) {
      if (a.request.number == b.request.number) continue;
      EXPECT_FALSE(a.request.addr == b.request.addr && a.request.count == b.request.count &&
                   a.request.function == b.request.function)
          << "addr " << a.request.addr << " count " << a.request.count << " was asked for twice";
    }
  }
  desk.expect_right(desk.plant.sense());
  EXPECT_FALSE(desk.plant.map_refused()) << "the count is remembered";
}

TEST(ModbusExceptions, Row11DeviceFailureReconnectsWithBackOff) {
  Desk desk("n=4..5 exception:code=4", 0.1);
  const auto rest = [&] {
    hal::sleep_until_ns(hal::monotonic_ns() + hal::to_ns(desk.link.backoff_left_s() + 0.01), {});
  };
  desk.expect_right(desk.plant.sense());  // inputs, holding registers, fingerprint
  EXPECT_EQ(desk.plant.sense().error(), Fault::no_reading);
  EXPECT_FALSE(desk.link.connected()) << "4: the device is broken";
  EXPECT_NEAR(desk.link.backoff_left_s(), 0.1, 0.05);
  EXPECT_EQ(desk.plant.sense().error(), Fault::no_reading) << "not before its time";
  EXPECT_EQ(desk.plant.actuate(command_of(22)).error(), Fault::not_applied);
  EXPECT_EQ(desk.proxy.counters().exchanges, 4U);
  rest();
  EXPECT_EQ(desk.plant.sense().error(), Fault::no_reading);
  EXPECT_NEAR(desk.link.backoff_left_s(), 0.2, 0.05) << "twice as long";
  rest();
  desk.expect_right(desk.plant.sense());
  EXPECT_TRUE(desk.plant.actuate(command_of(22)));
  EXPECT_EQ(desk.link.generation(), 3U);
}

TEST(ModbusExceptions, Row11FailureWhileTheFingerprintIsReadIsNoOtherDevice) {
  for (const std::string code : {"4", "6", "11"}) {
    Desk desk("n=3..6 exception:code=" + code, 0.01);
    EXPECT_EQ(desk.plant.sense().error(), Fault::no_reading);
    EXPECT_FALSE(desk.plant.other_device());
    for (int i = 0; i < 5; ++i) {
      hal::sleep_until_ns(hal::monotonic_ns() + hal::to_ns(desk.link.backoff_left_s() + 0.01), {});
      (void)desk.plant.sense();
    }
    desk.expect_right(desk.plant.sense());
  }
}

TEST(ModbusExceptions, Row12BusyDeviceIsAskedThreeMoreTimesInsideTheDeadline) {
  for (const std::string code : {"5", "6"}) {
    Desk desk("n=1..3 exception:code=" + code, 5.0);
    desk.expect_right(desk.plant.sense());
    const auto holding = [](const ChaosExchange& e) { return e.request.function == 3; };
    EXPECT_EQ(desk.count(holding), 4U) << "the fourth was answered";
    EXPECT_EQ(desk.link.counters().exchanges, 3U) << "all of it is one exchange of the link";

    Desk always("exception:code=" + code, 5.0);
    std::array<std::uint16_t, 2> words{};
    hal::LinkResult<void> got;
    EXPECT_LT(Desk::seconds([&] { got = always.link.read(4, 0, words); }), Desk::deadline_s + Desk::busy_s);
    ASSERT_FALSE(got);
    EXPECT_EQ(std::to_string(got.error().exception), code);
    EXPECT_EQ(always.proxy.counters().exchanges, 4U);
    EXPECT_TRUE(always.link.connected());
    EXPECT_EQ(always.link.backoff_left_s(), 0.0);
  }
}

TEST(ModbusExceptions, Row13GatewayIsNamedAndGivenTime) {
  for (const std::string code : {"10", "11", "42"}) {
    Desk desk("n=4 exception:code=" + code, 0.1);
    desk.expect_right(desk.plant.sense());
    EXPECT_FALSE(desk.plant.sense());
    EXPECT_TRUE(desk.plant.gateway_failed());
    EXPECT_FALSE(desk.plant.map_refused());
    EXPECT_GT(desk.link.backoff_left_s(), 0.05);
    EXPECT_TRUE(desk.link.connected()) << "the gateway itself is well";
    hal::sleep_until_ns(hal::monotonic_ns() + hal::to_ns(desk.link.backoff_left_s() + 0.01), {});
    desk.expect_right(desk.plant.sense());
    EXPECT_FALSE(desk.plant.gateway_failed());
    EXPECT_EQ(desk.link.generation(), 1U);
  }
}

TEST(ModbusExceptions, Row08WithoutExceptionsNothingIsDisturbed) { Desk().expect_undisturbed(); }

TEST(ModbusExceptions, Row09WithoutAMissingRegisterGroupsStayWhole) {
  Desk desk;
  desk.expect_undisturbed();
  EXPECT_EQ(desk.count([](const ChaosExchange& e) { return reads_inputs(e) && e.request.count > 20; }), 20U);
  EXPECT_EQ(desk.count([](const ChaosExchange& e) { return e.request.function == 4; }), 21U) << "and the fingerprint";
}

TEST(ModbusExceptions, Row10WithoutALimitedCountOneRequestReadsAll) {
  Desk desk("wider=124 exception:code=3");
  desk.expect_undisturbed();
  EXPECT_EQ(desk.count(reads_inputs), 20U);
}

TEST(ModbusExceptions, Row11WithoutAFailureTheConnectionIsKept) {
  Desk desk("", 5.0);
  desk.expect_undisturbed();
}

TEST(ModbusExceptions, Row12WithoutABusyDeviceEachRequestIsSentOnce) {
  Desk desk;
  desk.expect_undisturbed();
  EXPECT_EQ(desk.proxy.counters().exchanges, desk.link.counters().exchanges);
}

TEST(ModbusExceptions, Row13WithoutAGatewaysComplaintThereIsNoAlarmAndNoWait) {
  Desk desk("", 5.0);
  desk.expect_undisturbed();
}

}  // namespace
}  // namespace airside::fault_matrix
