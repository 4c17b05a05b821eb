// A point map is taken whole or refused with a place, a finding and a remedy.

#include "hal/points/point_map.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <vector>

#include "hal/points/signal_limits.hpp"

namespace airside::hal {
namespace {

const std::string header =
    "name,unit,fc,addr,type,byte_order,word_order,scale,offset,min,max,max_rate,stale_s,sentinel,write_policy,"
    "fc_write,default,readback\n";
const std::string good = "room_temp_1,degc,4,0,int16,big,big,0.01,0,5,45,1,1200,0x8000,,,,\n";

struct BrokenMap {
  const char* name;
  std::string text;
  const char* place;    ///< part of place()
  const char* finding;  ///< part of what()
};

class BrokenPointMap : public testing::TestWithParam<BrokenMap> {};

TEST_P(BrokenPointMap, IsRefusedWithPlaceFindingAndRemedy) {
  const BrokenMap& broken = GetParam();
  try {
    const PointMap map = PointMap::parse(broken.text, "points.csv");
    FAIL() << "accepted " << map.points().size() << " points";
  } catch (const InputError& error) {
    EXPECT_NE(error.place().find("points.csv"), std::string::npos) << error.what();
    EXPECT_NE(error.place().find(broken.place), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find(broken.finding), std::string::npos) << error.what();
    EXPECT_FALSE(error.expected().empty());
    EXPECT_FALSE(error.remedy().empty());
  }
}

std::string row(const std::string& text) { return header + text + "\n"; }

INSTANTIATE_TEST_SUITE_P(
    Table, BrokenPointMap,
    testing::Values(
        BrokenMap{"Empty", "", "points.csv", "no header"}, BrokenMap{"HeaderOnly", header, "points.csv", "no points"},
        BrokenMap{"UnknownColumn", "nmae," + header + good, ":1, header", "nmae"},
        BrokenMap{"ColumnTwice", "name," + header + "x," + good, ":1, header", "twice"},
        BrokenMap{"MissingColumn", header.substr(5) + good.substr(12), ":1, header", "no column \"name\""},
        BrokenMap{"TooFewCells", row("room_temp_1,degc,4"), ":2", "3 cells"},
        BrokenMap{"TooManyCells", row(good.substr(0, good.size() - 1) + ",,"), ":2", "20 cells"},
        BrokenMap{"OpenQuote", row("\"room_temp_1,degc,4,0,int16,,,0.01,0,5,45,1,1200,,,,,"), ":2", "not closed"},
        BrokenMap{"TextAfterQuote", row("\"a\"b,degc,4,0,int16,,,0.01,0,5,45,1,1200,,,,,"), ":2", "closing quote"},
        BrokenMap{"BadName", row("Room 1,degc,4,0,int16,,,0.01,0,5,45,1,1200,,,,,"), "column name", "Room 1"},
        BrokenMap{"DuplicateName", header + good + "room_temp_1,degc,4,9,int16,,,0.01,0,5,45,1,1200,,,,,\n", ":3",
                  "first on line 2"},
        BrokenMap{"OverlapOfWideValue", header + "a,,3,10,float32,,,1,0,0,1,,,,,,,\nb,,3,11,uint16,,,1,0,0,1,,,,,,,\n",
                  ":3, column addr", "overlaps a"},
        BrokenMap{"WrongUnit", row("room_temp_1,degf,4,0,int16,,,0.01,0,5,45,1,1200,,,,,"), "column unit", "degf"},
        BrokenMap{"BadFunction", row("x,,7,0,int16,,,1,0,5,45,,,,,,,"), "column fc", "\"7\""},
        BrokenMap{"BadType", row("x,,4,0,int24,,,1,0,5,45,,,,,,,"), "column type", "int24"},
        BrokenMap{"RegisterTypeOfCoil", row("x,,1,0,int16,,,1,0,0,1,,,,,,,"), "column type", "function 1"},
        BrokenMap{"CoilTypeOfRegister", row("x,,3,0,coil,,,1,0,0,1,,,,,,,"), "column type", "coil"},
        BrokenMap{"AddressText", row("x,,4,4O001,int16,,,1,0,5,45,,,,,,,"), "column addr", "4O001"},
        BrokenMap{"AddressNegative", row("x,,4,-1,int16,,,1,0,5,45,,,,,,,"), "column addr", "-1"},
        BrokenMap{"AddressBeyondSpace", row("x,,4,65535,float32,,,1,0,5,45,,,,,,,"), "column addr", "65534"},
        BrokenMap{"BadByteOrder", row("x,,4,0,int16,middle,,1,0,5,45,,,,,,,"), "column byte_order", "middle"},
        BrokenMap{"BadWordOrder", row("x,,4,0,int32,,BIG,1,0,5,45,,,,,,,"), "column word_order", "BIG"},
        BrokenMap{"ScaleZero", row("x,,4,0,int16,,,0,0,5,45,,,,,,,"), "column scale", "\"0\""},
        BrokenMap{"ScaleText", row("x,,4,0,int16,,,\"0,01\",0,5,45,,,,,,,"), "column scale", "0,01"},
        BrokenMap{"ScaleNan", row("x,,4,0,int16,,,nan,0,5,45,,,,,,,"), "column scale", "nan"},
        BrokenMap{"OffsetText", row("x,,4,0,int16,,,1,1e999,5,45,,,,,,,"), "column offset", "1e999"},
        BrokenMap{"NoLimits", row("x,,4,0,int16,,,1,0,,45,,,,,,,"), "column min", "empty"},
        BrokenMap{"MinAboveMax", row("x,,4,0,int16,,,1,0,46,45,,,,,,,"), "column min", "46"},
        BrokenMap{"LimitNotRepresentable", row("x,,4,0,int16,,,0.001,0,5,45,,,,,,,"), "column max", "raw 45000"},
        BrokenMap{"NegativeLimitOfUnsigned", row("x,,4,0,uint16,,,0.01,0,-5,45,,,,,,,"), "column min", "raw -500"},
        BrokenMap{"RateZero", row("x,,4,0,int16,,,1,0,5,45,0,,,,,,"), "column max_rate", "\"0\""},
        BrokenMap{"StaleNegative", row("x,,4,0,int16,,,1,0,5,45,,-1,,,,,"), "column stale_s", "-1"},
        BrokenMap{"SentinelTooWide", row("x,,4,0,int16,,,1,0,5,45,,,0x18000,,,,"), "column sentinel", "0x18000"},
        BrokenMap{"SentinelText", row("x,,4,0,int16,,,1,0,5,45,,,FFFF,,,,"), "column sentinel", "FFFF"},
        BrokenMap{"WriteToInputRegister", row("x,,4,0,int16,,,1,0,5,45,,,,on-change,6,,"), "column fc_write",
                  "read-only"},
        BrokenMap{"WriteToDiscreteInput", row("x,,2,0,discrete,,,,,,,,,,on-change,5,,"), "column fc_write",
                  "read-only"},
        BrokenMap{"SingleWriteOfWideValue", row("x,,3,0,int32,,,1,0,5,45,,,,on-change,6,,"), "column fc_write", "torn"},
        BrokenMap{"RegisterWriteOfCoil", row("x,,1,0,coil,,,,,,,,,,on-change,6,,"), "column fc_write", "5 for a coil"},
        BrokenMap{"PolicyWithoutFunction", row("x,,3,0,int16,,,1,0,5,45,,,,on-change,,,"), "column write_policy",
                  "on-change"},
        BrokenMap{"FunctionWithoutPolicy", row("x,,3,0,int16,,,1,0,5,45,,,,,6,,"), "column write_policy", "empty"},
        BrokenMap{"DefaultOutsideLimits", row("x,,3,0,int16,,,1,0,5,45,,,,on-change,6,46,"), "column default", "46"},
        BrokenMap{"DefaultOfReadOnly", row("x,,3,0,int16,,,1,0,5,45,,,,,,7,"), "column default", "not writable"},
        BrokenMap{"ReadbackOfReadOnly", row("x,,3,0,int16,,,1,0,5,45,,,,,,,self"), "column readback", "not writable"},
        BrokenMap{"ReadbackUnknown", row("x,,3,0,int16,,,1,0,5,45,,,,on-change,6,,y"), "column readback", "\"y\""},
        BrokenMap{"SetpointNotWritable", row("setpoint,degc,3,0,int16,,,0.01,0,8,32,,,,,,,"), "column fc_write",
                  "setpoint"},
        BrokenMap{"ClockOfWrongType", row("clock_s,s,4,0,uint16,,,1,0,0,9,,,,,,,"), "column type", "int32"}),
    [](const auto& test) { return std::string(test.param.name); });

TEST(PointMap, NamesEveryMistakeWithItsLine) {
  const std::string text =
      header + good +                                                       // line 2
      "room_temp_2,degf,5,4O001,int16,,,0,0,45,5,1,1200,0x18000,,,,\n"      // 3: five mistakes that show
      "room_temp_3,degc,4\n"                                                // 4
      "room_temp_4,degc,4,0,int16,,,0.01,0,5,45,1,1200,,,,,\n"              // 5: overlaps 2
      "room_temp_1,degc,4,9,int16,,,0.01,0,5,45,1,1200,,,,,\n"              // 6: again
      "setpoint,degc,3,0,int16,,,0.01,0,8,32,,,,on-change,6,,rom_temp_1\n"  // 7
      "\"open,degc,4,20,int16,,,0.01,0,5,45,1,1200,,,,,\n";                 // 8
  std::vector<InputError> complaints;
  const PointMap map = PointMap::parse(text, "points.csv", complaints);
  std::vector<std::string> places;
  for (const InputError& e : complaints) {
    places.push_back(e.place());
    EXPECT_FALSE(e.found().empty() || e.expected().empty() || e.remedy().empty()) << e.what();
  }
  EXPECT_EQ(places, (std::vector<std::string>{
                        "points.csv:3, column fc", "points.csv:3, column addr", "points.csv:3, column scale",
                        "points.csv:3, column min", "points.csv:3, column unit", "points.csv:4", "points.csv:8, cell 1",
                        "points.csv:5, column addr", "points.csv:6, column name", "points.csv:7, column readback"}));
  EXPECT_NE(complaints.back().remedy().find("did you mean \"room_temp_1\""), std::string::npos);
  // A row that is wrong is still a row: its signal is not missing too.
  EXPECT_TRUE(map.has({SignalKind::room_temp, 3}));
  try {
    PointMap::parse(text, "points.csv");
    FAIL();
  } catch (const InputError& first) {
    EXPECT_EQ(first.place(), places.front()) << "the daemon names the first";
  }
}

TEST(PointMap, FunctionThatIsNoneIsToldFromThoseThatRead) {
  const auto complaint_of = [](const std::string& cells) {
    std::vector<InputError> complaints;
    PointMap::parse(row(cells), "points.csv", complaints);
    return complaints.empty() ? std::string() : std::string(complaints.front().what());
  };
  for (const char* word : {"1 reads coils", "2 discrete inputs", "3 holding registers", "4 input registers"})
    EXPECT_NE(complaint_of("x,,7,0,int16,,,1,0,5,45,,,,,,,").find(word), std::string::npos) << word;
  EXPECT_NE(complaint_of("x,,5,0,coil,,,,,,,,,,,,,").find("function 5 writes"), std::string::npos);
  EXPECT_NE(complaint_of("x,,16,0,int16,,,1,0,5,45,,,,,,,").find("3 for a holding register"), std::string::npos);
  EXPECT_NE(complaint_of("x,,Holding,0,int16,,,1,0,5,45,,,,,,,").find("3, holding"), std::string::npos);
  EXPECT_NE(complaint_of("x,,3,0,int16,,,1,0,5,45,,,,on-change,15,,").find("5 writes a coil"), std::string::npos);
}

TEST(PointMap, MissingPointNamesTheRowThatIsNearlyCalledSo) {
  std::string csv = default_point_map(3, 0, 0);
  csv.replace(csv.find("room_temp_2"), 11, "rom_temp_2");
  const PointMap map = PointMap::parse(csv, "points.csv");
  const std::vector<InputError> complaints = map.topology_complaints(3, 0, 0);
  ASSERT_EQ(complaints.size(), 1U);
  EXPECT_NE(complaints[0].remedy().find("has \"rom_temp_2\""), std::string::npos) << complaints[0].what();
}

TEST(PointMap, EverythingAgainstTheTopologyIsNamedAtOnce) {
  const PointMap map = PointMap::parse(default_point_map(5, 2, 1), "points.csv");
  const std::vector<InputError> complaints = map.topology_complaints(6, 0, 2);
  std::string all;
  for (const InputError& e : complaints) all += e.what() + std::string("\n");
  for (const char* part : {"no point \"room_temp_6\"", "\"vav_on_6\", \"power_2\"", "\"fcu_temp_2\"", "\"fcu_on_1\""})
    EXPECT_NE(all.find(part), std::string::npos) << part << "\n" << all;
  EXPECT_THROW(map.check_topology(6, 0, 2), InputError);
}

TEST(PointMap, TakesColumnsInAnyOrderCommentsQuotesAndWindowsLineEnds) {
  const PointMap map = PointMap::parse(
      "\xEF\xBB\xBF# from the controls engineer\r\n"
      "readback,unit,fc,addr,type,byte_order,word_order,scale,offset,min,max,max_rate,stale_s,sentinel,write_policy,"
      "fc_write,default,name\r\n\r\n"
      "self,degc,3,0x10,int16,little,, 0.1 ,-2,8,32,,,\"0x8000 -1\",on-change,6,18,\"setpoint\"\r\n",
      "points.csv");
  const Point& p = map.at("setpoint");
  EXPECT_EQ(p.addr, 16);
  EXPECT_EQ(p.byte_order, Endian::little);
  EXPECT_EQ(p.scale, 0.1);
  EXPECT_EQ(p.offset, -2.0);
  EXPECT_EQ(p.sentinels, 2);
  EXPECT_EQ(p.sentinel[1], 0xFFFFU);
  EXPECT_EQ(p.default_value, 18.0);
  EXPECT_EQ(p.readback, "self");
}

TEST(PointMap, DefaultMapFitsEachTopologyAndNoOther) {
  for (const auto& [vavs, fcus, powers] : {std::array{5, 5, 2}, std::array{3, 0, 1}, std::array{8, 4, 2}}) {
    const PointMap map = PointMap::parse(default_point_map(vavs, fcus, powers), "points.csv");
    EXPECT_NO_THROW(map.check_topology(vavs, fcus, powers));
    EXPECT_THROW(map.check_topology(vavs + 1, fcus, powers), InputError);
    EXPECT_THROW(map.check_topology(vavs - 1, fcus, powers), InputError);
    EXPECT_THROW(map.check_topology(vavs, fcus + 1, powers), InputError);
    EXPECT_TRUE(map.extras().empty());
  }
}

TEST(PointMap, MissingSignalIsNamed) {
  std::string csv = default_point_map(5, 5, 2);
  const std::size_t at = csv.find("outdoor_temp");
  csv.replace(at, 12, "weather_temp");
  const PointMap map = PointMap::parse(csv, "points.csv");
  EXPECT_EQ(map.extras(), std::vector<std::string>{"weather_temp"});
  try {
    map.check_topology(5, 5, 2);
    FAIL();
  } catch (const InputError& error) {
    EXPECT_NE(std::string(error.what()).find("outdoor_temp"), std::string::npos);
  }
}

TEST(PointMap, LimitsFollowTheLayoutOrder) {
  const PointMap map = PointMap::parse(default_point_map(5, 5, 2), "points.csv");
  const auto limits = signal_limits<FiveZone>(map);
  EXPECT_EQ(limits[Layout<FiveZone>::outdoor_temp].min, -40.0);
  EXPECT_EQ(limits[Layout<FiveZone>::room_temp].max_rate_per_min, 1.0);
  EXPECT_EQ(limits[Layout<FiveZone>::power].max, 500.0);
  EXPECT_EQ(limits[Layout<FiveZone>::rain].stale_s, 1200.0);
  EXPECT_EQ(limits[Layout<FiveZone>::rain].max_rate_per_min, SignalLimits{}.max_rate_per_min);
}

TEST(PointMap, FingerprintSeesEveryColumnButNotTheOrderOfRows) {
  const std::string a = "a,degc,3,0,int32,big,big,0.1,0,5,45,1,1200,0x8000,on-change,16,18,self\n";
  const std::string b = "b,degc,3,9,int16,big,big,0.1,0,5,45,1,1200,0x8000,,,,\n";
  const auto print = [&](const std::string& rows) { return PointMap::parse(header + rows, "p").fingerprint(); };
  const std::uint64_t base = print(a + b);
  EXPECT_EQ(base, print("# a comment\n" + b + a));
  for (const char* other : {"c,degc,3,0,int32,big,big,0.1,0,5,45,1,1200,0x8000,on-change,16,18,self\n",
                            "a,kw,3,0,int32,big,big,0.1,0,5,45,1,1200,0x8000,on-change,16,18,self\n",
                            "a,degc,3,2,int32,big,big,0.1,0,5,45,1,1200,0x8000,on-change,16,18,self\n",
                            "a,degc,3,0,uint32,big,big,0.1,0,5,45,1,1200,0x8000,on-change,16,18,self\n",
                            "a,degc,3,0,int32,little,big,0.1,0,5,45,1,1200,0x8000,on-change,16,18,self\n",
                            "a,degc,3,0,int32,big,little,0.1,0,5,45,1,1200,0x8000,on-change,16,18,self\n",
                            "a,degc,3,0,int32,big,big,0.01,0,5,45,1,1200,0x8000,on-change,16,18,self\n",
                            "a,degc,3,0,int32,big,big,0.1,1,5,45,1,1200,0x8000,on-change,16,18,self\n",
                            "a,degc,3,0,int32,big,big,0.1,0,6,45,1,1200,0x8000,on-change,16,18,self\n",
                            "a,degc,3,0,int32,big,big,0.1,0,5,46,1,1200,0x8000,on-change,16,18,self\n",
                            "a,degc,3,0,int32,big,big,0.1,0,5,45,2,1200,0x8000,on-change,16,18,self\n",
                            "a,degc,3,0,int32,big,big,0.1,0,5,45,1,1201,0x8000,on-change,16,18,self\n",
                            "a,degc,3,0,int32,big,big,0.1,0,5,45,1,1200,0x8001,on-change,16,18,self\n",
                            "a,degc,3,0,int32,big,big,0.1,0,5,45,1,1200,0x8000,refresh,16,18,self\n",
                            "a,degc,3,0,int32,big,big,0.1,0,5,45,1,1200,0x8000,on-change,16,19,self\n",
                            "a,degc,3,0,int32,big,big,0.1,0,5,45,1,1200,0x8000,on-change,16,18,none\n"}) {
    EXPECT_NE(base, print(other + b)) << other;
  }
}

TEST(PointMap, MissingFileSaysSo) {
  EXPECT_THROW(PointMap::load("/nonexistent/points.csv"), InputError);
  EXPECT_THROW(PointMap::load("/"), InputError);
}

}  // namespace
}  // namespace airside::hal
