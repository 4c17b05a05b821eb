// A log says which of its numbers were sensed, and is read by sites that sense less or more than it has.

#include <cmath>

#include "hal/site/site_log.hpp"
#include "hal/site/site_settings.hpp"
#include "support/complaint.hpp"

namespace airside::hal {
namespace {

const TopologyCounts plain = counts_of<ThreeVav>();

StandIns stand_ins() {
  StandIns in;
  in.set("rain", 0);
  in.set("power", 4);
  return in;
}

/// A site of three VAVs without rain sensor and meter, with two dampers and a point for the fan.
TopologyCounts lacking() {
  std::string csv = default_point_map(3, 0, 1, stand_ins());
  csv += "damper_1,,4,100,uint16,big,big,0.01,0,0,1,,,,,,,\ndamper_3,,4,101,uint16,big,big,0.01,0,0,1,,,,,,,\n";
  csv += "supply_flow,m3/s,4,102,uint16,big,big,0.001,0,0,9,,,,,,,\nahu_on,,4,103,uint16,big,big,1,0,0,1,,,,,,,\n";
  return counts_of(plain, PointMap::parse(csv, "points.csv"), stand_ins());
}

const char* const whole_log =
    "time,room_temp_1_degc,room_temp_2_degc,room_temp_3_degc,vav_on_1,vav_on_2,vav_on_3,power_1_kw,mau_temp_degc,"
    "outdoor_temp_degc,rain,setpoint_degc\n"
    "2021-07-01T00:00:00,25.1,25.2,25.3,1,1,0,7.5,18,29.5,1,20.5\n"
    "2021-07-01T00:06:00,25.2,25.2,25.3,1,1,0,7.25,18,29.25,1,20.5\n";

TEST(LogSignals, HeaderMarksStandInsAndHasAColumnForEachSideSignal) {
  EXPECT_EQ(log_header(lacking(), false),
            "time,room_temp_1_degc,room_temp_2_degc,room_temp_3_degc,vav_on_1,vav_on_2,vav_on_3,power_1_kw_stand_in,"
            "mau_temp_degc,outdoor_temp_degc,rain_stand_in,setpoint_degc,supply_temp_degc,damper_1,damper_3,"
            "supply_flow_m3s,ahu_on\n");
  EXPECT_EQ(log_header(plain, false).find("stand_in"), std::string::npos) << "a whole site's logs stay as they are";
}

TEST(LogSignals, RowsComeBackAsTheyWereWritten) {
  const TopologyCounts site = lacking();
  LogRow row = make_log_row(site);
  row.time = {1625097600};
  row.value = {25.1, 25.2, 25.3, 1, 1, 0, 4, 18, 29.5, 0};
  row.setpoint_degc = 21;
  row.side = {0.5, 1, 2.125, 1};
  char text[max_log_row_text];
  const std::size_t size = format_log_row(text, row, false);
  const std::string log = log_header(site, false) + std::string(text, size);
  const Log back = read_log_text(log, "room.csv", site);
  EXPECT_EQ(back.rows[0].value, row.value);
  EXPECT_EQ(back.rows[0].side, row.side);
  EXPECT_TRUE(back.extra_columns.empty());
  EXPECT_TRUE(back.stood_in[6]);
  EXPECT_FALSE(back.stood_in[7]);
  const Log other = read_log_text(log, "room.csv", plain);
  EXPECT_EQ(other.rows[0].value, row.value) << "a site that has the sensor by now";
  EXPECT_TRUE(other.stood_in[6]) << "and is told that this was none";
  EXPECT_TRUE(other.extra_columns.empty());
}

TEST(LogSignals, SiteReadsItsStandInWhateverTheFileHas) {
  const Log log = read_log_text(whole_log, "room.csv", lacking());
  ASSERT_EQ(log.rows.size(), 2U);
  EXPECT_EQ(log.rows[0].value[6], 4.0) << "not the 7.5 kW of a meter that this site has not";
  EXPECT_EQ(log.rows[0].value[9], 0.0);
  EXPECT_TRUE(std::isnan(log.rows[0].side[0]));
}

TEST(LogSignals, ColumnsOfStandInsMayBeMissingAndNoOthers) {
  std::string text = whole_log;
  for (const char* part : {",power_1_kw", ",7.5", ",7.25"}) text = replaced(text, part, "");
  EXPECT_EQ(read_log_text(text, "room.csv", lacking()).rows[1].value[6], 4.0);
  expect_complaint({"power_1_kw", "no such column", "power_1_kw", "add it"},
                   [&] { read_log_text(text, "room.csv", plain); });
  const std::string no_outdoor = replaced(text, ",outdoor_temp_degc", ",weather_degc");
  expect_complaint({"outdoor_temp_degc", "no such column", "outdoor_temp_degc", ""},
                   [&] { read_log_text(no_outdoor, "room.csv", lacking()); });
}

TEST(LogSignals, WriterRefusesARowOfAnotherSite) {
  LogWriter writer("room.csv", lacking(), false);
  EXPECT_THROW(writer.append(make_log_row(plain)), std::runtime_error);
}

}  // namespace
}  // namespace airside::hal
