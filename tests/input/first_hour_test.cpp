// What a controls engineer meets in the first hour: a map with several mistakes, and an AHU that does not answer.

#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "input/program_desk.hpp"

namespace airside {
namespace {

/// How often a part stands in a text.
int times(const std::string& text, const std::string& part) {
  int count = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(Check, NamesEveryMistakeOfAPointMapInOneGo) {
  const Desk desk;
  desk.site();
  desk.edit("points.csv", "room_temp_1,degc,4", "room_temp_1,degc,5");
  desk.edit("points.csv", "room_temp_2,degc", "room_temp_2,degf");
  desk.edit("points.csv", "\nfcu_temp_1,", "\nfcu_temp_9,");
  const Outcome text = desk.run("airside", {"check", "site.toml"});
  EXPECT_EQ(text.code, 1);
  for (const char* part : {"points.csv:6, column fc: found \"5\"", "points.csv:7, column unit: found \"degf\"",
                           "points.csv:11, column name: found \"fcu_temp_9\"", "no point \"fcu_temp_1\""})
    EXPECT_EQ(times(text.out, part), 1) << part << "\n" << text.out;
  EXPECT_NE(text.err.find("not in order, 4 complaints"), std::string::npos) << text.err;
  const nlohmann::json said = nlohmann::json::parse(desk.run("airside", {"check", "--json", "site.toml"}).out);
  EXPECT_EQ(said["checked"][1]["more"].size(), 3U) << said.dump(1);
  EXPECT_EQ(times(desk.run("airsided", {"--check", "--site", "site.toml"}).err, "points.csv:"), 1) << "the first alone";

  std::string many =
      "name,unit,fc,addr,type,byte_order,word_order,scale,offset,min,max,max_rate,stale_s,sentinel,"
      "write_policy,fc_write,default,readback\n";
  for (int i = 0; i < 70; ++i) many += fmt::format("p{},,9,{},int16,,,1,0,0,1,,,,,,,\n", i, i);
  desk.write("many.csv", many);
  const Outcome listed = desk.run("airside", {"check", "--points", "many.csv", "--topology", "1vav-0fcu-0power"});
  EXPECT_EQ(times(listed.out, "many.csv:"), 50) << listed.out;
  EXPECT_EQ(times(listed.out, "WRONG"), 50);
  EXPECT_EQ(times(listed.out, " more\n"), 1) << listed.out;
}

TEST(Check, TellsAnotherSpellingOfAUnitFromAnotherUnit) {
  const Desk desk;
  desk.site();
  desk.edit("points.csv", "room_temp_1,degc", "room_temp_1,degC");
  desk.edit("points.csv", "room_temp_2,degc", "room_temp_2,degf");
  const std::string said = desk.run("airside", {"check", "site.toml"}).out;
  EXPECT_EQ(times(said, "; write degc\n"), 1) << said;
  EXPECT_EQ(times(said, "; convert with scale and offset"), 1) << said;
}

TEST(Check, RefusesASetpointThatItsOwnRowCallsImpossibleAndSoDoesTheDaemon) {
  const Desk desk;
  desk.site();
  desk.edit("site.toml", "off_degc = 25.0", "off_degc = 36.0");
  for (const Outcome& one :
       {desk.run("airside", {"check", "site.toml"}), desk.run("airsided", {"--check", "--site", "site.toml"})}) {
    EXPECT_EQ(one.code, 1);
    EXPECT_EQ(
        times(one.out + one.err, "[expert] off_degc: found 36 degC; expected 8 to 32 degC, the limits of setpoint"), 1)
        << one.out << one.err;
  }
}

TEST(Check, HintsAtAPointThatASiteMayDoWithoutAndThatWasMisspelt) {
  const Desk desk;
  desk.site();
  desk.edit("points.csv", "\nheartbeat,", "\nheart_beat,");
  const Outcome text = desk.run("airside", {"check", "site.toml"});
  EXPECT_EQ(times(text.out + text.err, "\"heart_beat\" means nothing to airside; if it is heartbeat, correct its name"),
            1)
      << text.out << text.err;
  desk.edit("points.csv", "\nheart_beat,", "\nheat_meter,");
  const Outcome other = desk.run("airside", {"check", "site.toml"});
  EXPECT_EQ(times(other.out + other.err, "means nothing to airside"), 0) << other.out << other.err;
}

TEST(Probe, SaysWhereTheHostIsNamedAndWhatRefuses) {
  const Desk desk;
  desk.site();
  desk.edit("site.toml", "port = 502", "port = 9");
  for (const char* command : {"probe", "doctor"}) {
    const Outcome refused = desk.run("airside", {command, "site.toml"});
    EXPECT_EQ(refused.code, 1);
    for (const char* part : {"connection refused by 127.0.0.1:9: nothing listens",
                             "listens on port 9 (most listen on 502)", "firewall", "nc -vz 127.0.0.1 9"})
      EXPECT_EQ(times(refused.out + refused.err, part), 1) << command << part << "\n" << refused.out << refused.err;
  }
  desk.edit("site.toml", "port = 9", "port = 502");
  desk.edit("site.toml", "host = \"127.0.0.1\"", "host = \"127.0.0.9\"");
  const Outcome usual = desk.run("airside", {"doctor", "site.toml"});
  EXPECT_EQ(times(usual.out + usual.err, "listens on port 502, as most do, and"), 1) << usual.out << usual.err;
  desk.edit("site.toml", "host = \"127.0.0.9\"", "host = \"no-such-host.invalid\"");
  EXPECT_EQ(times(desk.run("airside", {"probe", "site.toml"}).err, "site.toml:39:1: modbus.host: found"), 1);
  EXPECT_EQ(times(desk.run("airside", {"doctor", "site.toml"}).out, "site.toml:39:1: modbus.host: \"no-such"), 1);
}

TEST(Doctor, KnowsThatAGatewayIsNotInstalledAndThatNoAhuWatches) {
  if (fs::exists("/etc/systemd/system/airside-bacnet.service")) GTEST_SKIP() << "airside-bacnet is installed here";
  const Desk desk;
  desk.write("a.toml",
             "[site]\nname = \"AHU 9\"\nvavs = 1\nfcus = 0\npowers = 0\n[bus]\ntransport = \"bacnet\"\nport = 9\n"
             "address = \"192.168.1.30/24\"\n[signals]\nroom_temp = { object = \"1201:analog-input:3\" }\n"
             "setpoint = { object = \"1201:analog-output:1\" }\n");
  ASSERT_EQ(desk.run("airside", {"init", "ahu", "--answers", "a.toml"}).code, 0);
  const Outcome checked = desk.run("airside", {"check", "ahu/site.toml"}),
                seen = desk.run("airside", {"doctor", "ahu/site.toml"});
  EXPECT_EQ(checked.code, 0) << checked.err;
  EXPECT_EQ(times(checked.out + checked.err, "the heartbeat is the gateway's own: where this box loses power"), 1)
      << checked.out << checked.err;
  for (const char* part : {"install the gateway airside-bacnet", "the heartbeat is the gateway's own"})
    EXPECT_EQ(times(seen.out, part), 1) << part << "\n" << seen.out << seen.err;
}

}  // namespace
}  // namespace airside
