// Rows of BACnet objects in a point map, and the table [bacnet] of a site file.

#include <fmt/format.h>

#include "hal/points/point_map.hpp"
#include "hal/points/register_codec.hpp"
#include "hal/site/site_file.hpp"
#include "hal/site/site_settings.hpp"
#include "support/complaint.hpp"

namespace airside::hal {
namespace {

const std::string header = "name,unit,protocol,object,min,max\n";
const std::string room = "room_temp_1,degc,bacnet,1201:analog-input:3,5,45\n";
const std::string setpoint = "setpoint,degc,bacnet,1201:analog-output:1,8,32\n";
const std::string own = "heartbeat,,bacnet,gateway,0,65535\nmap_fingerprint,,bacnet,gateway,0,4294967295\n";
const std::string good = header + room + setpoint + own;

PointMap parse(const std::string& text) { return PointMap::parse(text, "points.csv"); }

TEST(BacnetRow, TakesItsRegistersFromItsPlace) {
  const PointMap map =
      parse(header + "# a comment is no row\n" + room + "vav_on_1,,bacnet,7:binary-value:2,0,1\n" + setpoint + own);
  EXPECT_EQ(map.protocol(), Protocol::bacnet);
  int place = 0;
  for (const Point& p : map.points()) {
    EXPECT_EQ(p.addr, 2 * place++) << p.name;
    const bool written = p.name == "setpoint" || p.name == "heartbeat";
    EXPECT_EQ(p.fc, written ? 3 : 4) << p.name;
    EXPECT_EQ(p.fc_write, written ? 16 : 0) << p.name;
    EXPECT_EQ(p.write_policy, written ? WritePolicy::refresh : WritePolicy::none) << p.name;
    EXPECT_EQ(p.type, p.name == "map_fingerprint" ? PointType::uint32 : PointType::float32) << p.name;
  }
  EXPECT_EQ(map.at("room_temp_1").object, "1201:analog-input:3:present-value");
  EXPECT_EQ(map.at("heartbeat").object, "gateway");
}

TEST(BacnetRow, KeepsWhatItSaysOfTheNumber) {
  const PointMap map = parse(
      "name,unit,protocol,object,min,max,scale,offset,max_rate,write_policy,readback\n"
      "room_temp_1,degc,bacnet,1:analog-input:3,5,45,0.5555555556,-17.77777778,1,,\n"
      "loop_setpoint,degc,bacnet,1:loop:4:setpoint,8,32,,,,,\n"
      "setpoint,degc,bacnet,1:analog-value:4,8,32,1,0,,on-change,loop_setpoint\n"
      "heartbeat,,bacnet,1:multi-state-value:2,1,2,,,,,\nmap_fingerprint,,bacnet,gateway,0,4294967295,,,,,\n");
  const Expected<Registers> warm = encode(map.at("room_temp_1"), 25.0);
  ASSERT_TRUE(warm.has_value());
  EXPECT_EQ(warm->word[0], 0x429A);  // 77 degF as float32
  EXPECT_EQ(map.at("setpoint").write_policy, WritePolicy::on_change);
  EXPECT_EQ(map.at("setpoint").readback, "loop_setpoint");
}

TEST(BacnetRow, FingerprintKnowsTheObject) {
  const PointMap one = parse(good), other = parse(replaced(good, "analog-input:3", "analog-input:4"));
  EXPECT_NE(one.fingerprint(), other.fingerprint());
  EXPECT_EQ(one.fingerprint(), parse(replaced(good, "analog-input:3", "analog-input:3:present-value")).fingerprint());
}

TEST(BacnetRow, MapOfModbusRegistersKeepsItsFingerprint) {
  const std::string text = default_point_map(5, 5, 2);
  std::string with_columns = replaced(text, "default,readback\n", "default,readback,protocol,object\n");
  for (std::size_t at = with_columns.find("object\n") + 7; at < with_columns.size();) {
    const std::size_t end = with_columns.find('\n', at);
    with_columns.insert(end, ",modbus,");
    at = end + 9;
  }
  EXPECT_EQ(parse(text).fingerprint(), parse(with_columns).fingerprint());
}

struct BrokenRow {
  const char* from;
  const char* to;
  Complaint complaint;
};

TEST(BacnetRow, IsRefusedWithPlaceFindingExpectationAndRemedy) {
  const std::vector<BrokenRow> cases = {
      {"room_temp_1,degc,bacnet",
       "room_temp_1,degc,bacnt",
       {":2, column protocol", "bacnt", "modbus, bacnet", "use one"}},
      {"1201:analog-input:3", "1201", {":2, column object", "1201", "DEVICE:TYPE:INSTANCE", "--discover"}},
      {"1201:analog-input:3", "", {":2, column object", "an empty cell", "DEVICE:TYPE:INSTANCE", "--discover"}},
      {"1201:analog-input:3", "gateway", {":2, column object", "gateway", "an object of a device", "DEVICE:TYPE"}},
      {"1201:analog-input:3", "1201:analog-input", {"column object", "analog-input", "INSTANCE", "--discover"}},
      {"1201:analog-input:3", "AHU:analog-input:3", {"column object", "AHU", "0 to 4194302", "instance numbers"}},
      {"1201:analog-input:3", "1201:analog-input:4194303", {"column object", "4194303", "0 to 4194302", "instance"}},
      {"1201:analog-input:3", "1201:analog-input:-3", {"column object", "-3", "0 to 4194302", "instance"}},
      {"1201:analog-input:3", "1201:AI:3", {"column object", "\"AI\"", "analog-input, analog-output", "lower case"}},
      {"1201:analog-input:3", "1201:analog-input:3:setpoint", {"column object", "setpoint", "of a loop", "leave"}},
      {"1201:analog-input:3", "1201:analog-input:3:units", {"column object", "units", "present-value", "leave"}},
      {"1201:analog-output:1",
       "1201:analog-input:1",
       {":3, column object", "analog-input", "analog-output", "setpoint"}},
      {"1201:analog-output:1",
       "1201:binary-value:1",
       {":3, column object", "binary-value", "analog-output", "setpoint"}},
      {"1201:analog-output:1",
       "1201:analog-input:3",
       {":3, column object", "analog-input:3", "since setpoint", "name"}},
      {"bacnet,gateway,0,65535",
       "bacnet,1:binary-input:1,0,1",
       {":4, column object", "binary-input", "binary-output", "gateway"}},
      {"map_fingerprint,,bacnet,gateway",
       "map_fingerprint,,bacnet,1:analog-value:9",
       {":5", "1:analog-value:9", "gateway", "write"}},
      {"heartbeat,,bacnet,gateway,0,65535\n",
       "",
       {"points.csv", "no point \"heartbeat\"", "without new values", "add a row"}},
      {"map_fingerprint,,bacnet,gateway,0,4294967295\n",
       "",
       {"points.csv", "map_fingerprint", "same map", "add a row"}},
      {"heartbeat,",
       "a,,bacnet,1201:analog-input:3,0,1\nheartbeat,",
       {":4, column object", "first on line 2", "once", "correct"}},
      {"heartbeat,",
       "clock_s,s,bacnet,1:analog-value:1,0,9\nheartbeat,",
       {":4, column name", "clock_s", "no clock", "system"}},
  };
  for (const BrokenRow& broken : cases) {
    SCOPED_TRACE(broken.to);
    expect_complaint(broken.complaint, [&] { parse(replaced(good, broken.from, broken.to)); });
  }
}

TEST(BacnetRow, LeavesWhatItsPlaceDecidesEmpty) {
  const std::string wide = "name,unit,protocol,object,min,max,fc,addr,type,write_policy\n";
  const auto map_with = [&](const std::string& cells) {
    return wide + "room_temp_1,degc,bacnet,1:analog-input:3,5,45," + cells + "\n" +
           "setpoint,degc,bacnet,1:analog-output:1,8,32,,,,\n" +
           "heartbeat,,bacnet,gateway,0,65535,,,,\nmap_fingerprint,,bacnet,gateway,0,4294967295,,,,\n";
  };
  EXPECT_NO_THROW(parse(map_with(",,,")));
  for (const auto& [column, cells] :
       {std::pair{"column fc", "4,,,"}, {"column addr", ",7,,"}, {"column type", ",,int16,"}}) {
    expect_complaint({column, "\"", "an empty cell, since the place", "clear the cell"},
                     [&, c = cells] { parse(map_with(c)); });
  }
  expect_complaint({"column write_policy", "refresh", "only setpoint and heartbeat", "clear"},
                   [&] { parse(map_with(",,,refresh")); });
}

TEST(BacnetRow, IsNotMixedWithRowsOfModbus) {
  const std::string modbus =
      replaced(default_point_map(5, 5, 2), "default,readback\n", "default,readback,protocol,object\n");
  std::string mixed = modbus.substr(0, modbus.find("object\n") + 7);
  mixed += "room_temp_1,degc,,,,,,,,5,45,,,,,,,,bacnet,1201:analog-input:3\n";
  mixed += "room_temp_2,degc,4,1,int16,big,big,0.01,0,5,45,1.0,1200,0x8000,,,,,,\n";
  expect_complaint({":7, column protocol", "modbus, while line 6 has bacnet", "one protocol", "stand-ins"},
                   [&] { parse(mixed); });
  expect_complaint(
      {"column object", "1201:analog-input:3", "an empty cell in a row of Modbus", "bacnet into the column"},
      [&] { parse(replaced(mixed, "bacnet,1201", "modbus,1201")); });
}

TEST(BacnetRow, HeartbeatThatTheAhuDoesNotWatchIsAWarning) {
  EXPECT_NE(warning_of(parse(good)).find("line 4: the heartbeat is the gateway's own: where this box loses power"),
            std::string::npos);
  const auto with_heartbeat = [](const char* object) {
    return parse(replaced(good, "bacnet,gateway,0,65535", object));
  };
  EXPECT_EQ(warning_of(with_heartbeat("bacnet,1201:analog-value:40,0,65535")), "");
  EXPECT_NE(warning_of(with_heartbeat("bacnet,1305:analog-value:40,0,65535"))
                .find("of device 1305, the setpoint of device 1201"),
            std::string::npos);
}

// ---- [bacnet]

const std::string bacnet = "[bacnet]\naddress = \"192.168.1.30/24\"\n";
const std::string modbus = "[modbus]\nhost = \"127.0.0.1\"\nport = 1502\n";

SiteFile site_with(const std::string& more) {
  return parse_site_text("[site]\nname = \"B\"\ntopology = \"1vav-0fcu-0power\"\n" + more, "site.toml", SiteRules{});
}

TEST(BacnetSection, HasDefaultsForAllButTheAddress) {
  const SiteFile site = site_with(modbus + bacnet);
  ASSERT_TRUE(site.bacnet.has_value());
  EXPECT_EQ(site.bacnet->address, "192.168.1.30/24");
  EXPECT_EQ(site.bacnet->priority, 10);
  EXPECT_EQ(site.bacnet->port, 47808);
  EXPECT_FALSE(site_with(modbus).bacnet.has_value());
}

TEST(BacnetSection, ExampleIsThatOfTheSiteFileWithItsCommentsRemoved) {
  std::string text = example_site_text("1vav-0fcu-0power");
  for (const char* mark : {"# [bacnet]", "# address", "# priority"}) text = replaced(text, mark, mark + 2);
  const SiteFile site = parse_site_text(text, "site.toml", SiteRules{});
  ASSERT_TRUE(site.bacnet.has_value());
  EXPECT_EQ(site.bacnet->address, "192.168.1.30/24");
  EXPECT_EQ(site.bacnet->priority, BacnetSection{}.priority);
}

TEST(BacnetSection, TakesDevicesOfEveryKindOfAddress) {
  const auto site =
      site_with(bacnet + "devices = [\"1201@192.168.1.50\", \"1202@192.168.1.50:47809\", \"1305@2001:5\"]\n");
  EXPECT_EQ(site.bacnet->devices.size(), 3U);
}

TEST(BacnetSection, IsRefusedWithPlaceFindingExpectationAndRemedy) {
  const std::vector<std::pair<std::string, Complaint>> cases = {
      {"[bacnet]\n", {"bacnet.address", "nothing", "a text", "192.168.1.30/24"}},
      {"[bacnet]\naddress = \"192.168.1.30\"\n", {"bacnet.address", "192.168.1.30", "prefix", "ip -4 address"}},
      {"[bacnet]\naddress = \"eth0/24\"\n", {"bacnet.address", "eth0/24", "IPv4", "ip -4 address"}},
      {"[bacnet]\naddress = \"192.168.1.30/33\"\n", {"bacnet.address", "/33", "8 to 32", "write it as"}},
      {bacnet + "priority = 7\n", {"bacnet.priority", "7", "8 to 16", ""}},
      {bacnet + "priority = 17\n", {"bacnet.priority", "17", "8 to 16", ""}},
      {bacnet + "prioriti = 9\n", {"bacnet", "prioriti", "", "priority"}},
      {bacnet + "poll_s = 60.0\n", {"bacnet.poll_s", "60", "two times poll_s", "believe values for longer"}},
      {bacnet + "stale_s = 20.0\n", {"bacnet.stale_s", "20", "two times poll_s", "read more often"}},
      {bacnet + "devices = [\"1201\"]\n", {"bacnet.devices", "1201", "INSTANCE@ADDRESS", "Who-Is"}},
      {bacnet + "devices = [\"1201@ahu-3\"]\n", {"bacnet.devices", "1201@ahu-3", "INSTANCE@ADDRESS", "correct it"}},
      {bacnet + "devices = [\"1201@0:5\"]\n", {"bacnet.devices", "1201@0:5", "network 2001", "correct it"}},
      {bacnet + "devices = [\"1201@2001:256\"]\n", {"bacnet.devices", "2001:256", "station 5", "correct it"}},
      {bacnet + "devices = [\"7@10.0.0.1\", \"7@10.0.0.2\"]\n", {"bacnet.devices", "device 7 twice", "once", "remove"}},
  };
  for (const auto& [text, complaint] : cases) {
    SCOPED_TRACE(text);
    expect_complaint(complaint, [&, t = text] { site_with(modbus + t); });
  }
}

TEST(BacnetSection, AgreesWithModbusAndThePointMap) {
  const PointMap map = parse(good);
  EXPECT_NO_THROW(refuse_contradiction(site_with(modbus + bacnet), map));
  EXPECT_NO_THROW(refuse_contradiction(site_with(replaced(modbus, "127.0.0.1", "localhost") + bacnet), map));
  const std::vector<std::pair<std::string, Complaint>> cases = {
      {modbus, {"[bacnet]", "rows of BACnet in points.csv", "how airside-bacnet reaches", "add [bacnet]"}},
      {replaced(modbus, "127.0.0.1", "192.168.1.9") + bacnet, {"[modbus] host", "192.168.1.9", "127.0.0.1", "host ="}},
      {"[modbus]\ntransport = \"rtu\"\ndevice = \"/dev/ttyS0\"\n" + bacnet,
       {"[modbus]", "rtu", "by tcp", "transport ="}},
      {modbus + bacnet + "timeout_s = 5.0\n", {"timeout_s", "5", "deadline_s of [modbus], 5 s", "raise deadline_s"}},
      {modbus + "heartbeat_s = 30\n" + bacnet, {"heartbeat_timeout_s", "60", "three times heartbeat_s", "raise"}},
  };
  for (const auto& [text, complaint] : cases) {
    SCOPED_TRACE(text);
    expect_complaint(complaint, [&, t = text] { refuse_contradiction(site_with(t), map); });
  }
  const PointMap registers = parse(default_point_map(1, 0, 0));
  expect_complaint({"[bacnet]", "no row of BACnet", "both or neither", "take the table out"},
                   [&] { refuse_contradiction(site_with(modbus + bacnet), registers); });
  EXPECT_NO_THROW(refuse_contradiction(site_with(modbus), registers));
}

}  // namespace
}  // namespace airside::hal
