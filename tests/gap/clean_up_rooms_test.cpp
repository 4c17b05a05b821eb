// What the clean-up says of many rooms and seasons; minutes of work under a sanitizer.

#include <algorithm>
#include <cmath>

#include "gap/clean_up_case.hpp"
#include "hal/text/input_error.hpp"

namespace airside::tools::gap {
namespace {

TEST(CleanUp, SaysNothingAboutCleanLogsOfManyRoomsAndSeasons) {
  const std::vector<sim::RcRoom> rooms{sim::make_room(), sim::make_room(3, 0, 1), sim::make_room(8, 4, 2),
                                       sim::load_room("301-real"), sim::load_room("702")};
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const int month = static_cast<int>(1 + 7 * seed % 12);
    const Logged log = log_of(rooms[seed % rooms.size()], seed, sim::civil_midnight(2023, month, 5), seed % 2 == 0);
    const CleanLog clean = clean_up(log.rows, log.context);
    EXPECT_TRUE(clean.remarks.empty()) << "seed " << seed << ", month " << month << told(clean.remarks);
    expect_same_rows(clean.rows, log.rows);
    clean.require_usable();
    CleanUpContext alone = log.context;
    alone.station = nullptr;
    EXPECT_TRUE(clean_up(log.rows, alone).remarks.empty()) << told(clean_up(log.rows, alone).remarks);
    alone.station = sim::synthetic_weather(seed + 100);  // a typical year: another year's weather, and no unit
    for (const Remark& r : clean_up(log.rows, alone).remarks) EXPECT_EQ(r.defect, Defect::other_weather) << r.text;
  }
}

TEST(CleanUp, LeavesWhatTheWorkflowIsToNameAlone) {
  const std::vector<std::vector<Hidden>> cases{
      {{"room_sensor_bias", 2, 4.0}},
      {{"room_sensor_drift", 0, 0.25}},
      {{"room_sensor_lag", 1, 9000}},
      {{"fcu_sensor_bias", 3, -3.0}},
      {{"swapped_sensors", 1, 1}},
      {{"vav_stuck", 2, 0.3}},
      {{"fcu_runs_unrecorded", 1, 1}},
      {{"sun_differs", 0, 0.6}},
      {{"outdoor_sensor_bias", 0, 5}},
      {{"outdoor_sensor_bias", 0, -5}},
      {{"fcu_dial", 2, 2}},
  };
  std::uint64_t seed = 40;
  for (const auto& hidden : cases) {
    ++seed;
    const int month = static_cast<int>(1 + 5 * seed % 12);
    const Logged log = log_of(sim::make_room(), seed, sim::civil_midnight(2023, month, 5), seed % 2 == 0, hidden);
    const CleanLog clean = clean_up(log.rows, log.context);
    EXPECT_TRUE(clean.remarks.empty()) << hidden[0].effect << told(clean.remarks);
  }
}

struct UnitCase {
  const char* text;
  std::function<double(double)> shown;
  double tolerance;
};

TEST(CleanUp, ConvertsTemperaturesInOtherUnits) {
  const std::vector<UnitCase> units{
      {"Fahrenheit", [](double v) { return hundredths(1.8 * v + 32); }, 0.01},
      {"kelvin", [](double v) { return hundredths(v + 273.15); }, 0.011},
      {"tenths", [](double v) { return std::round(10 * v); }, 0.051},
      {"tenths", [](double v) { return 10 * v; }, 1e-9},
  };
  const std::vector<std::pair<const char*, Column>> columns{
      {"room_temp_3_degc", room(3)},  {"fcu_temp_1_degc", fcu(1)}, {"mau_temp_degc", mau},
      {"outdoor_temp_degc", outdoor}, {"setpoint_degc", setpoint}, {"supply_temp_degc", supply}};
  for (const Logged* log : {&july(), &january()}) {
    for (const auto& [name, column] : columns) {
      for (const UnitCase& unit : units) {
        SCOPED_TRACE(std::string(name) + " in " + unit.text);
        Rows rows = log->rows;
        map(rows, column, unit.shown);
        const CleanLog clean = clean_up(rows, log->context);
        const Remark r = only_remark(clean, Defect::wrong_unit, Action::fixed, name);
        EXPECT_NE(r.text.find(unit.text), std::string::npos) << r.text;
        expect_near(clean.rows, log->rows, column, unit.tolerance);
      }
    }
  }
}

TEST(CleanUp, NamesSwappedColumns) {
  struct Pair {
    Column a, b;
    const char *first, *second;
  };
  const std::vector<Pair> pairs{
      {outdoor, mau, "outdoor_temp_degc", "mau_temp_degc"},     {room(2), fcu_on(1), "room_temp_2_degc", "fcu_on_1"},
      {room(4), vav_on(4), "room_temp_4_degc", "vav_on_4"},     {room(1), power(1), "room_temp_1_degc", "power_1_kw"},
      {room(5), power(2), "room_temp_5_degc", "power_2_kw"},    {fcu(3), fcu_on(3), "fcu_temp_3_degc", "fcu_on_3"},
      {setpoint, room(3), "setpoint_degc", "room_temp_3_degc"}, {setpoint, supply, "setpoint_degc", "supply_temp_degc"},
      {power(2), vav_on(2), "power_2_kw", "vav_on_2"},          {outdoor, rain, "outdoor_temp_degc", "rain"},
      {room(1), mau, "room_temp_1_degc", "mau_temp_degc"},      {mau, fcu_on(5), "mau_temp_degc", "fcu_on_5"},
  };
  for (const Logged* log : {&july(), &january()}) {
    for (const Pair& p : pairs) {
      SCOPED_TRACE(std::string(p.first) + " and " + p.second);
      Rows rows = log->rows;
      swap(rows, p.a, p.b);
      const CleanLog clean = clean_up(rows, log->context);
      EXPECT_FALSE(clean.usable());
      const auto named = [&](const Remark& r) {
        return r.defect == Defect::swapped && r.text.find(p.first) != std::string::npos &&
               r.text.find(p.second) != std::string::npos;
      };
      EXPECT_TRUE(std::any_of(clean.remarks.begin(), clean.remarks.end(), named)) << told(clean.remarks);
    }
  }
}

}  // namespace
}  // namespace airside::tools::gap
