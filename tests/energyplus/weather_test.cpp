#include "sim/energyplus_weather.hpp"

#include <cstdlib>

#include "energyplus/engine.hpp"
#include "hal/input_error.hpp"

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

TEST(EpwWeather, NamesTheLineThatIsWrong) {
  const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / "airside-short.epw";
  EpwFile weather = three_weeks();
  weather.records[4].resize(10);
  write_epw(weather, file);
  const std::string message = message_of([&file] { read_epw(file); });
  EXPECT_NE(message.find(".epw:13"), std::string::npos) << message;
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace airside::sim
