#include "sim/energyplus/weather.hpp"

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>

#include "energyplus/engine.hpp"
#include "hal/text/input_error.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "support/default_cycle.hpp"

namespace airside::sim {
namespace {

double field(const std::vector<std::string>& record, std::size_t i) { return std::strtod(record[i].c_str(), nullptr); }

EpwFile three_weeks() {
  EpwFile weather;
  weather.header.assign(8, "LOCATION,Somewhere");
  for (int day = 1; day <= 21; ++day) {
    for (int hour = 1; hour <= 24; ++hour) {
      std::vector<std::string> record(35, "0");
      record[1] = "7";
      record[2] = std::to_string(day);
      record[3] = std::to_string(hour);
      record[6] = "30.0";
      record[7] = "24.0";
      for (std::size_t i = 13; i <= 15; ++i) record[i] = "500";
      weather.records.push_back(record);
    }
  }
  return weather;
}

TEST(EpwWeather, MovesTemperatureAndSunAsAsked) {
  const EpwFile changed = changed_epw(three_weeks(), {1.5, 0.8, 0}, 1);
  for (const auto& record : changed.records) {
    EXPECT_EQ(record[6], "31.5");
    EXPECT_EQ(record[7], "25.5");
    EXPECT_EQ(record[14], "400.0");
    EXPECT_EQ(record[33], "0");
  }
}

TEST(EpwWeather, BringsStormsAsOftenAsAsked) {
  const EpwFile changed = changed_epw(three_weeks(), {0, 1, 7}, 1);
  int rainy_days = 0;
  std::string day;
  for (const auto& record : changed.records) {
    if (field(record, 33) == 0) continue;
    if (record[2] != day) ++rainy_days;
    day = record[2];
    EXPECT_EQ(record[6], "27.0");
    EXPECT_EQ(record[14], "165.0");
    EXPECT_TRUE(field(record, 3) >= 13 && field(record, 3) <= 18);
  }
  EXPECT_EQ(rainy_days, 21);
}

TEST(EpwWeather, RainsInTheEngineWhenAStormPasses) {
  AIRSIDE_NEEDS_ENGINE();
  EnergyPlusOptions options = one_day();
  options.weather_change.storms_per_week = 7;
  EnergyPlusPlant plant(options);
  int rainy_cycles = 0;
  while (plant.time() < plant.end()) {
    plant.advance_to({plant.time().seconds + cycle_s});
    rainy_cycles += plant.sensors().rain > 0.5;
  }
  EXPECT_GE(rainy_cycles, 2);
  EXPECT_LE(rainy_cycles, 12);
}

/// A whole year of made-up weather in which one field of a line is another; lines and columns from 0.
class BrokenYear {
 public:
  BrokenYear(int line, int column, const std::string& to) {
    write_epw(path_.string(), *synthetic_weather(1), 2021);
    std::ifstream in(path_);
    std::vector<std::string> lines;
    for (std::string text; std::getline(in, text);) lines.push_back(text);
    std::string& text = lines[static_cast<std::size_t>(line)];
    std::size_t at = 0;
    for (int i = 0; i < column; ++i) at = text.find(',', at) + 1;
    text.replace(at, std::min(text.find(',', at), text.size()) - at, to);
    std::ofstream out(path_);
    for (const std::string& one : lines) out << one << '\n';
  }
  ~BrokenYear() { std::filesystem::remove(path_); }
  std::string complaint(const EpwDemand& demand = {}) const {
    return message_of([&] { read_epw_file(path_, demand); });
  }

 private:
  std::filesystem::path path_ = std::filesystem::path(testing::TempDir()) / "airside-broken.epw";
};

TEST(EpwWeather, IsCheckedBeforeTheEngineSeesIt) {
  const std::string hot = BrokenYear(11, 6, "85").complaint();
  EXPECT_NE(hot.find(".epw:12: dry bulb temperature: found 85"), std::string::npos) << hot;
  const std::string dry = BrokenYear(11, 8, "-3").complaint();
  EXPECT_NE(dry.find(".epw:12: relative humidity: found -3"), std::string::npos) << dry;
  const std::string dew = BrokenYear(11, 7, "dewy").complaint();
  EXPECT_NE(dew.find(".epw:12: column 8: found \"dewy\""), std::string::npos) << dew;
  const std::string header = BrokenYear(0, 9, "6\nCOMMENTS 3,").complaint();
  EXPECT_NE(header.find(".epw:9: DATA PERIODS: found a header of 9 lines"), std::string::npos) << header;
}

TEST(EpwWeather, IsTakenWhole) {
  const auto path = std::filesystem::path(testing::TempDir()) / "airside-whole.epw";
  write_epw(path.string(), *synthetic_weather(1), 2021);
  const EpwFile whole = read_epw_file(path, {});
  EXPECT_EQ(whole.header.size(), 8u);
  EXPECT_EQ(whole.records.size(), 8760u);
  std::filesystem::remove(path);
}

TEST(EpwWeather, OfThePackageIsTaken) {
  AIRSIDE_NEEDS_ENGINE();
  EXPECT_EQ(read_epw_file(default_weather(find_energyplus()), {}).records.size(), 8760u);
}

}  // namespace
}  // namespace airside::sim
