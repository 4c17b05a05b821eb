// What rows 8 to 26 do to a day of control: the real daemon, over the chaos proxy, on the served RC plant.
//   AIRSIDE_CHAOS_DAYS=n        simulated days under all faults (1)
//   AIRSIDE_CHAOS_P=percent     share of the exchanges that are spoilt (6)
//   AIRSIDE_CHAOS_SEED=n        of all draws (1)

#include "fault_matrix/modbus_daemon_rig.hpp"
#include "support/modbus_fixture.hpp"

namespace airside::fault_matrix {
namespace {

using closed_loop::from_environment;
using tools::ChaosExchange;

TEST(ModbusDaemon, Row15WithoutFaultsTheDayOverTheProxyIsTheDayInOneProcess) {
  ChaosLoop loop({.name = "honest", .deadline_s = 10});
  ASSERT_TRUE(loop.run()) << loop.said();
  closed_loop::expect_same_rows(loop.bench.log(), loop.bench.expected());
  loop.expect_safe();
  EXPECT_GT(loop.ledger.writes, 40U);
  EXPECT_EQ(loop.count(writes_heartbeat), static_cast<std::size_t>(rows_per_day));
  EXPECT_EQ(loop.status()["alarms"].size(), 0U) << loop.status();
}

TEST(ModbusDaemon, Row08RefusedFunctionIsExpertWithAnAlarmAndIsAskedOnceARow) {
  ChaosLoop loop({.name = "row08", .script = "n=1000.. fc=4 at=0 exception:code=1"});
  ASSERT_TRUE(loop.run()) << loop.said();
  EXPECT_EQ(loop.status()["state"], "expert");
  EXPECT_EQ(loop.status()["reason"], "no reading");
  EXPECT_TRUE(loop.has_alarm("no reading")) << loop.status();
  EXPECT_TRUE(loop.has_alarm("map refused")) << loop.status();
  EXPECT_NEAR(static_cast<double>(loop.count(reads_inputs)), rows_per_day, 2) << "no retry";
  loop.expect_safe();
}

TEST(ModbusDaemon, Row09MissingRegisterIsExpertThatNamesThePoint) {
  ChaosLoop loop({.name = "row09", .script = "n=1000.. fc=4 at=" + std::to_string(power_1_addr) + " exception:code=2"});
  ASSERT_TRUE(loop.run()) << loop.said();
  EXPECT_EQ(loop.status()["state"], "expert");
  EXPECT_EQ(loop.status()["reason"], "signal lost");
  EXPECT_EQ(loop.status()["fault_signal"], "power_1");
  EXPECT_TRUE(loop.has_alarm("signal lost")) << loop.status();
  EXPECT_TRUE(loop.has_alarm("map refused")) << loop.status();
  loop.expect_safe();
}

TEST(ModbusDaemon, Row02AnImpossibleValueIsToldAsSuch) {
  ChaosLoop loop({.name = "row02", .script = "n=1000.. fc=4 set:addr=1,value=9000"});
  ASSERT_TRUE(loop.run()) << loop.said();
  EXPECT_EQ(loop.status()["state"], "expert");
  EXPECT_EQ(loop.status()["reason"], "signal lost");
  EXPECT_EQ(loop.status()["fault"], "out of range") << "to the controller it is no number; people want to know why";
  EXPECT_EQ(loop.status()["fault_signal"], "room_temp_2");
  loop.expect_safe();
}

TEST(ModbusDaemon, Row22ASetpointThatCannotBeIsAnAlarmAndIsNotWrittenOver) {
  ChaosLoop loop({.name = "row22", .script = "fc=3 at=0 set:addr=0,value=9000"});
  ASSERT_TRUE(loop.run()) << loop.said();
  EXPECT_TRUE(loop.has_alarm("setpoint altered")) << loop.status();
  EXPECT_EQ(loop.count(writes_setpoint), 0U);
}

TEST(ModbusDaemon, Row13GatewayThatLosesTheDeviceIsExpertWithAnAlarm) {
  ChaosLoop loop({.name = "row13", .script = "n=1000.. fc=4 at=0 exception:code=11"});
  ASSERT_TRUE(loop.run()) << loop.said();
  EXPECT_EQ(loop.status()["state"], "expert");
  EXPECT_TRUE(loop.has_alarm("gateway failed")) << loop.status();
  loop.expect_safe();
}

TEST(ModbusDaemon, Row15RestartingServerLosesRowsAtMostAndIsVerifiedBeforeEachFirstWrite) {
  ChaosLoop loop({.name = "row15", .script = "p=0.02 refuse:s=0.03\np=0.01 reset:bytes=5"});
  ASSERT_TRUE(loop.run()) << loop.said();
  EXPECT_GT(loop.proxy->counters().connections, 20U);
  std::uint64_t verified = 0;
  for (const ChaosExchange& e : loop.exchanges()) {
    if (e.request.function == 4 && e.request.addr == fingerprint_addr && e.taken()) verified = e.connection;
    const bool writes = writes_setpoint(e) || writes_heartbeat(e);
    ASSERT_TRUE(!writes || e.connection == verified) << describe(e);
  }
  EXPECT_EQ(loop.bench.logged_rows(), loop.bench.rows());
  loop.expect_safe();
  EXPECT_GT(loop.ledger.writes, 20U);
}

TEST(ModbusDaemon, Row20DeviceExchangedDuringAReconnectIsReleased) {
  ChaosLoop loop({.name = "row20",
                  .script = "n=1000 reset\nn=1001.. set:addr=" + std::to_string(fingerprint_addr) + ",value=4711"});
  ASSERT_TRUE(loop.run()) << loop.said();
  EXPECT_EQ(loop.status()["state"], "release");
  EXPECT_EQ(loop.status()["reason"], "map differs");
  const auto late = [](const ChaosExchange& e) {
    return e.request.number > 1001 && (writes_setpoint(e) || writes_heartbeat(e));
  };
  EXPECT_EQ(loop.count(late), 0U);
  loop.expect_safe();
}

TEST(ModbusDaemon, Row20DaemonOfAnotherMapWaitsAndSaysWhy) {
  ChaosLoop loop({.name = "row20b",
                  .script = {},
                  .from = "room_temp_1,degc,4,0,int16,big,big,0.01",
                  .to = "room_temp_1,degc,4,0,int16,big,big,0.1",
                  .daemon_only = true});
  EXPECT_FALSE(loop.run(1.5)) << "it waits for the right device";
  EXPECT_TRUE(loop.has_said("is not the device that the point map describes")) << loop.said();
  EXPECT_EQ(loop.count([](const ChaosExchange& e) { return e.request.writes(); }), 0U);
}

/// `airside probe` of the loop's site.
hal::testing_peers::ProgramResult probe(const ChaosLoop& loop, const std::string& more = "") {
  return hal::testing_peers::run_program(loop.bench.program("airside").string() + " probe " +
                                         loop.bench.file("site.toml").string() + more);
}

TEST(ModbusDaemon, Row21ExchangedWordsAreExpertThatNamesThePointAndProbeNamesTheOrder) {
  ChaosLoop loop({.name = "row21", .script = "swap:addr=" + std::to_string(power_1_addr)});
  const auto sheet = probe(loop);
  EXPECT_EQ(sheet.status, 1);
  EXPECT_NE(sheet.output.find("power_1 would make sense in another order"), std::string::npos) << sheet.output;
  EXPECT_NE(sheet.output.find("CDAB gives"), std::string::npos) << sheet.output;
  EXPECT_EQ(loop.count([](const ChaosExchange& e) { return e.request.writes(); }), 0U) << "probe never writes";
  ASSERT_TRUE(loop.run()) << loop.said();
  EXPECT_EQ(loop.status()["state"], "expert");
  EXPECT_EQ(loop.status()["reason"], "signal lost");
  EXPECT_EQ(loop.status()["fault_signal"], "power_1");
  EXPECT_TRUE(loop.has_alarm("order doubted")) << loop.status();
  EXPECT_TRUE(loop.has_said("power_1: its words make sense only in another order")) << loop.said();
  EXPECT_EQ(loop.modes()["learn"] + loop.modes()["run"], 0U) << "nothing was controlled by a number that is none";
  loop.expect_safe();
}

TEST(ModbusDaemon, Row21WithoutExchangedWordsTheSheetIsInOrder) {
  ChaosLoop loop({.name = "row21w", .script = {}});
  const auto sheet = probe(loop);
  EXPECT_EQ(sheet.status, 0) << sheet.output;
  const auto as_json = probe(loop, " --json");
  const nlohmann::json all = nlohmann::json::parse(as_json.output, nullptr, false);
  ASSERT_FALSE(all.is_discarded()) << as_json.output;
  EXPECT_EQ(all["ok"], true);
  EXPECT_EQ(all["points"].size(), 31U) << "every point of the map";
  EXPECT_EQ(loop.count([](const ChaosExchange& e) { return e.request.writes(); }), 0U);
}

TEST(ModbusDaemon, Row22RefusedFunctionIsReplacedOnceAndNothingElseChanges) {
  ChaosLoop loop({.name = "row22", .script = "on=write fc=6 at=0 exception:code=1", .deadline_s = 10});
  ASSERT_TRUE(loop.run()) << loop.said();
  EXPECT_EQ(loop.count([](const ChaosExchange& e) { return writes_setpoint(e) && e.request.function == 6; }), 1U);
  closed_loop::expect_same_rows(loop.bench.log(), loop.bench.expected());
  loop.expect_safe();
}

TEST(ModbusDaemon, Row22RefusedWritesAreExpertThenRelease) {
  ChaosLoop loop({.name = "row22b", .script = "n=1000.. on=write at=0 exception:code=2"});
  ASSERT_TRUE(loop.run()) << loop.said();
  EXPECT_TRUE(loop.has_said("expert: the AHU refused a setpoint")) << loop.said();
  EXPECT_TRUE(loop.has_said("release: the AHU refused the schedule's setpoint too")) << loop.said();
  const auto refused = [](const ChaosExchange& e) { return e.request.number >= 1000 && writes_setpoint(e); };
  EXPECT_LT(loop.count(refused), 40U) << "tried again every hour, not every cycle";
  EXPECT_LT(loop.count(writes_heartbeat), 200U) << "the heartbeat stops, and the AHU takes over";
  loop.expect_safe();
}

TEST(ModbusDaemon, Row26WriteOnlySetpointThatNobodyFollowsIsSeenBySupplyAir) {
  ChaosLoop loop({.name = "row26",
                  .script = "n=600.. on=write at=0 swallow",
                  .from = "on-change,6,18,self",
                  .to = "on-change,6,18,none"});
  ASSERT_TRUE(loop.run()) << loop.said();
  EXPECT_TRUE(loop.has_said("supply air stays away from its setpoint")) << loop.said();
  EXPECT_GT(loop.modes()["run"], 10U);
  loop.expect_safe();
}

TEST(ModbusDaemon, Row26WithoutASwallowedWriteAWriteOnlySetpointIsLearnedFrom) {
  ChaosLoop loop({.name = "row26w", .script = {}, .from = "on-change,6,18,self", .to = "on-change,6,18,none"});
  ASSERT_TRUE(loop.run()) << loop.said();
  EXPECT_EQ(loop.modes()["learn"], loop.bench.rows());
  EXPECT_GT(loop.ledger.writes, 40U);
  loop.expect_safe();
}

TEST(ModbusDaemon, DaemonUnderFaultsWritesWithinLimitsAndOneStep) {
  const int days = from_environment("AIRSIDE_CHAOS_DAYS", 1);
  const double p = from_environment("AIRSIDE_CHAOS_P", 6) / 100.0;
  // Lies about writes too; what they forward stays within the limits, so that each step is the daemon's own.
  const double each = p / 37;
  const std::string lies = "p=" + std::to_string(30 * each) + " on=write at=0 clamp:low=2050,high=2400\n" +
                           "p=" + std::to_string(30 * each) + " on=write at=0 alter:add=50\n" +
                           "p=" + std::to_string(30 * each) + " on=write at=0 swallow\n";
  ChaosLoop loop({.name = "campaign",
                  .script = lies + every_fault(each),
                  .days = days,
                  .deadline_s = 0.1,
                  .seed = static_cast<std::uint64_t>(from_environment("AIRSIDE_CHAOS_SEED", 1))});
  ASSERT_TRUE(loop.run(3600)) << loop.said();
  const tools::ChaosCounters c = loop.proxy->counters();
  const auto modes = loop.modes();
  std::string by_mode;
  for (const auto& [mode, rows] : modes) by_mode += " " + mode + " " + std::to_string(rows);
  std::printf(
      "%d days: %llu exchanges, %llu faults of %zu kinds, %llu connections; %llu setpoints reached the server (%llu of "
      "them altered on the way), %llu outside limits, %llu beyond one step; widest step %.2f K; rows:%s\n",
      days, static_cast<unsigned long long>(c.exchanges), static_cast<unsigned long long>(c.faults), c.by_fault.size(),
      static_cast<unsigned long long>(c.connections), static_cast<unsigned long long>(loop.ledger.writes),
      static_cast<unsigned long long>(loop.ledger.altered), static_cast<unsigned long long>(loop.ledger.outside),
      static_cast<unsigned long long>(loop.ledger.too_wide), loop.ledger.widest_step_k, by_mode.c_str());
  loop.expect_safe();
  EXPECT_GT(loop.ledger.writes, 10U) << "it must have controlled";
  EXPECT_GT(c.faults, 50U);
  EXPECT_EQ(loop.bench.logged_rows(), loop.bench.rows()) << "no row is lost";
}

}  // namespace
}  // namespace airside::fault_matrix
