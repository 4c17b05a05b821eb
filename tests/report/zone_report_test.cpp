// Reports of sites whose boxes modulate, and of sites without a meter.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "hal/points/point_map.hpp"
#include "support/program.hpp"
#include "tools/report/logged_method.hpp"
#include "tools/report/report.hpp"
#include "tools/report/run_record.hpp"

namespace airside::tools {
namespace {

constexpr CivilTime monday{18813LL * 86400};  // 2021-07-05

/// A site of two zones and two meters in a folder of its own, and a day's log of it.
class LoggedSite : public testing::Test {
 protected:
  void make(const std::string& more_points, const std::string& more_site, const hal::StandIns& stand_ins = {}) {
    std::ofstream(file("points.csv")) << hal::default_point_map(2, 0, 2, stand_ins) << more_points;
    std::ofstream(file("site.toml")) << "[site]\nname = \"Test\"\ntopology = \"2vav-0fcu-2power\"\n[modbus]\n"
                                        "transport = \"tcp\"\nhost = \"127.0.0.1\"\npoints = \"points.csv\"\n"
                                     << more_site;
    site_ = load_site(file("site.toml").string());
    hal::LogWriter log(file("log.csv").string(), site_.counts, true);
    for (int i = 0; i < rows_per_day; ++i) log.append(row(i));
    log.close();
  }

  /// People from 08:00 to 20:00; zone 1 is 1 K above its setpoint all day and its box open, zone 2 is as it should be.
  hal::LogRow row(int i) const {
    hal::LogRow row = hal::make_log_row(site_.counts);
    row.time = {monday.seconds + i * row_s};
    std::fill(row.value.begin(), row.value.end(), 1.0);
    row.value[0] = 25;
    row.value[1] = 23.9;
    row.setpoint_degc = row.supply_temp_degc = 14;
    for (std::size_t k = 0; k < row.side.size(); ++k) {
      const hal::SideColumn side = site_.counts.sides[k];
      if (side.signal == hal::SideSignal::damper) row.side[k] = side.place == 1 ? 0.97 : 0.5;
      if (side.signal == hal::SideSignal::zone_setpoint) row.side[k] = 24;
      if (side.signal == hal::SideSignal::zone_heating_setpoint) row.side[k] = side.place == 2 ? 24.65 : 21;
      if (side.signal == hal::SideSignal::occupied) row.side[k] = i >= 80 && i < 200 ? 1 : 0;
      if (side.signal == hal::SideSignal::ahu_on) row.side[k] = 1;
    }
    return row;
  }

  std::string page() const {
    const auto methods = read_logged_methods(site_, group_logs({file("log.csv").string()}, {}));
    RunRecord record = make_run_record(site_, methods[0].run);
    record.methods = {{"box", MethodResult::Kind::ours, {methods[0].metrics}}};
    return report_html(make_run_report(record));
  }
  Outcome report() const {
    return run_program("airside", {"report", "log.csv", "--site", "site.toml", "--json"}, folder_.path(),
                       scratch_.path());
  }
  fs::path file(const std::string& name) const { return folder_.path() / name; }

  TemporaryFolder folder_, scratch_;
  Site site_;
};

bool shows(const std::string& page, const std::string& text) { return page.find(text) != std::string::npos; }

constexpr const char* box_points =
    "damper_1,,4,200,uint16,big,big,0.001,0,0,1,,,0xFFFF,,,,\n"
    "damper_2,,4,201,uint16,big,big,0.001,0,0,1,,,0xFFFF,,,,\n"
    "zone_setpoint_1,degc,4,202,uint16,big,big,0.01,0,0,60,,,0xFFFF,,,,\n"
    "zone_setpoint_2,degc,4,203,uint16,big,big,0.01,0,0,60,,,0xFFFF,,,,\n"
    "occupied,,4,204,uint16,big,big,1,0,0,1,,,0xFFFF,,,,\n"
    "ahu_on,,4,205,uint16,big,big,1,0,0,1,,,0xFFFF,,,,\n";
constexpr const char* band_site =
    "[controller]\nobjective = \"band\"\n[twin]\nmodel = \"m.epJSON\"\ncontrol = \"own\"\n[twin.names]\n"
    "supply_setpoint_schedule = \"s\"\nsupply_air_node = \"n\"\nzones = [\"Saal Nord\", \"Saal West\"]\n"
    "powers = [\"Cooling:Electricity\", \"Heating:NaturalGas\"]\n";

TEST_F(LoggedSite, HasItsMetersNamedByTheSiteFile) {
  make(box_points, band_site);
  EXPECT_TRUE(shows(page(), "Cooling:Electricity"));
  site_.file.meters = {"fans", "heat pump"};
  const std::string drawn = page();
  EXPECT_TRUE(shows(drawn, "heat pump")) << "before the twin's names";
  EXPECT_FALSE(shows(drawn, "Cooling:Electricity"));
}

TEST_F(LoggedSite, IsJudgedByItsZonesWhereTheObjectiveIsTheBand) {
  make(box_points, band_site);
  const ZoneBand band = zone_band(site_, read_logged_methods(site_, group_logs({file("log.csv")}, {}))[0].run.rows);
  ASSERT_EQ(band.zones.size(), 2U);
  EXPECT_NEAR(band.zones[0].above_degch_per_day, 0.5 * 12, 1e-9) << "of twelve hours with people";
  EXPECT_NEAR(band.zones[0].most_above_k, 1, 1e-9);
  EXPECT_NEAR(band.zones[0].saturated_h_per_day, 12, 1e-9);
  EXPECT_EQ(band.zones[1].above_degch_per_day, 0);
  EXPECT_NEAR(band.zones[1].mean_damper, 0.5, 1e-9);
  EXPECT_EQ(band.worst().name, "Saal Nord");
  const std::string drawn = page();
  for (const char* text :
       {"the 2 zones were more than 0.5", "Zones too warm a day", "Dampers", "Each zone", "Saal West"})
    EXPECT_TRUE(shows(drawn, text)) << text;
  for (const char* text : {"Average error", "How far the controller trusts", "Error of each day", "room head"})
    EXPECT_FALSE(shows(drawn, text)) << text;
  const auto said = nlohmann::json::parse(report().out);
  EXPECT_NEAR(said["methods"]["log"]["zone_degree_hours_above_per_day_degch"], 6, 1e-9);
}

TEST_F(LoggedSite, ZonesAreTooColdByTheirHeatingSetpoints) {
  make(box_points, band_site);
  EXPECT_FALSE(shows(page(), "Zones too cold a day")) << "no point shows them";
  const std::string heating =
      "zone_heating_setpoint_1,degc,4,206,uint16,big,big,0.01,0,0,60,,,0xFFFF,,,,\n"
      "zone_heating_setpoint_2,degc,4,207,uint16,big,big,0.01,0,0,60,,,0xFFFF,,,,\n";
  make(box_points + heating, band_site);
  const auto said = nlohmann::json::parse(report().out);
  EXPECT_NEAR(said["methods"]["log"]["zone_degree_hours_below_per_day_degch"], 0.25 * 12, 1e-9) << "zone 2: 23.9";
  EXPECT_TRUE(shows(page(), "Zones too cold a day"));
  EXPECT_TRUE(shows(page(), "below their heating setpoints for 3.00&nbsp;K h"));
}

TEST_F(LoggedSite, IsJudgedByTheRoomsMeanOtherwise) {
  make(box_points, "");
  const std::string drawn = page();
  EXPECT_TRUE(shows(drawn, "Average error"));
  EXPECT_FALSE(shows(drawn, "Zones too warm a day"));
}

TEST_F(LoggedSite, GasIsNotCalledElectricity) {
  make(box_points, band_site);
  const std::string drawn = page();
  EXPECT_TRUE(shows(drawn, "Heating:NaturalGas"));
  EXPECT_TRUE(shows(drawn, "Energy a day"));
  EXPECT_FALSE(shows(drawn, "Electricity a day"));
}

TEST_F(LoggedSite, OfElectricMetersUsesElectricity) {
  make("", "");
  EXPECT_TRUE(shows(page(), "Electricity a day"));
  EXPECT_NEAR(nlohmann::json::parse(report().out)["methods"]["log"]["hvac_kwh"], 48, 1e-9);
}

TEST_F(LoggedSite, WithoutAMeterUsesNoEnergyThatAnybodyKnows) {
  hal::StandIns stand_ins;
  stand_ins.set("power", 4);
  make("", "[stand_in]\npower = 4\n", stand_ins);
  const std::string drawn = page();
  EXPECT_FALSE(shows(drawn, "Electricity a day"));
  EXPECT_FALSE(shows(drawn, "Electric power"));
  const Outcome said = report();
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_TRUE(nlohmann::json::parse(said.out)["methods"]["log"]["hvac_kwh"].is_null()) << said.out;
}

TEST(ReportTables, OfManyRoomsHaveARowARoom) {
  ReportTable table;
  table.columns = {{"room 1", "K", 2, true}, {"room 2", "K", 2, true}, {"room 3", "K", 2, true}};
  for (const double first : {1.0, 4.0}) {
    TableRow row;
    row.name = first < 2 ? "ours" : "peer";
    for (int i = 0; i < 3; ++i) row.cells.push_back({first + i, {}, ""});
    table.rows.push_back(row);
  }
  const ReportTable down = turned(table, "room");
  ASSERT_EQ(down.columns.size(), 2U);
  EXPECT_EQ(down.columns[1].name, "peer");
  EXPECT_EQ(down.columns[1].unit, "K");
  ASSERT_EQ(down.rows.size(), 3U);
  EXPECT_EQ(down.rows[2].name, "room 3");
  EXPECT_EQ(down.rows[2].cells[1].value, 6.0);
}

}  // namespace
}  // namespace airside::tools
