#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <memory>
#include <vector>

#include "hal/text/input_error.hpp"
#include "sim/weather/recording.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "sim/weather/weather.hpp"

namespace airside::sim {
namespace {

CivilTime at(int month, int day, int hour, int minute = 0, int year = 2021) {
  return {civil_midnight(year, month, day).seconds + hour * 3600 + minute * 60};
}

Weather two_hours() {
  std::vector<WeatherRecord> records(3);
  records[0].outdoor_temp_degc = 20;
  records[1].outdoor_temp_degc = 26;
  records[2].outdoor_temp_degc = 28;
  records[1].rain = 1;
  for (auto& r : records) r.direct_normal_w_m2 = 100;
  records[1].direct_normal_w_m2 = 300;
  return Weather({"here", 24.8, 120.97, 8, 0}, "three hours", 3600, 181 * 24 + 10, records);  // 1 July 10:00
}

TEST(Sun, StandsInTheZenithOfTheTropicAtMidsummerNoon) {
  const Location tropic{"tropic", 23.44, 120, 8, 0};
  const SunDirection sun = sun_at(tropic, at(6, 21, 12, 2));
  EXPECT_GT(sun.up, 0.9998);
}

TEST(Sun, RisesInTheEastAndSetsInTheWest) {
  const Location place{"equator", 0, 0, 0, 0};
  const SunDirection morning = sun_at(place, at(3, 21, 6, 30)), evening = sun_at(place, at(3, 21, 17, 45));
  EXPECT_GT(morning.east, 0.98);
  EXPECT_LT(evening.east, -0.98);
  EXPECT_LT(sun_at(place, at(3, 21, 0)).up, -0.9);
}

TEST(Sun, AgreesWithPublishedAnglesAtGreenwich) {
  // 21 June 12:00 UT, 51.48 N: the sun's altitude is 90 - 51.48 + 23.44 = 61.96 deg, almost due south.
  const SunDirection sun = sun_at({"Greenwich", 51.48, 0, 0, 0}, at(6, 21, 12, 2));
  EXPECT_NEAR(std::asin(sun.up) * 57.29578, 61.96, 0.15);
  EXPECT_LT(sun.north, -0.46);
  EXPECT_NEAR(sun.east, 0, 0.01);
}

TEST(Facades, SeeTheBeamOnlyWhenTheyFaceIt) {
  WeatherRecord clear;
  clear.direct_normal_w_m2 = 800;
  const auto west = facade_irradiance_w_m2(clear, {-0.8, -0.1, 0.59});
  EXPECT_NEAR(west[static_cast<int>(Facade::west)], 640, 1e-9);
  EXPECT_NEAR(west[static_cast<int>(Facade::south)], 80, 1e-9);
  EXPECT_EQ(west[static_cast<int>(Facade::east)], 0);
  EXPECT_EQ(west[static_cast<int>(Facade::north)], 0);
  const auto night = facade_irradiance_w_m2(clear, {-0.8, -0.1, -0.1});
  for (double w : night) EXPECT_EQ(w, 0);
}

TEST(Weather, IsLinearWithinTheHourWithRadiationAtMidHour) {
  const Weather weather = two_hours();
  EXPECT_DOUBLE_EQ(weather.at(at(7, 1, 11)).outdoor_temp_degc, 20);
  EXPECT_DOUBLE_EQ(weather.at(at(7, 1, 11, 30)).outdoor_temp_degc, 23);
  EXPECT_DOUBLE_EQ(weather.at(at(7, 1, 12)).outdoor_temp_degc, 26);
  EXPECT_DOUBLE_EQ(weather.at(at(7, 1, 11, 30)).direct_normal_w_m2, 300);
  EXPECT_DOUBLE_EQ(weather.at(at(7, 1, 12)).direct_normal_w_m2, 200);
  EXPECT_EQ(weather.at(at(7, 1, 11, 59)).rain, 1);
  EXPECT_EQ(weather.at(at(7, 1, 12, 0)).rain, 0);
}

TEST(Weather, RefusesTimesItDoesNotCoverAndSaysWhichItDoes) {
  const Weather weather = two_hours();
  EXPECT_NO_THROW(weather.at(at(7, 1, 13)));
  EXPECT_NO_THROW(weather.require(at(7, 1, 10), at(7, 1, 13)));
  try {
    weather.require(at(7, 1, 10), at(7, 2, 0));
    FAIL() << "took a period that is not covered";
  } catch (const hal::InputError& error) {
    EXPECT_NE(error.expected().find("07-01 10:00 to 07-01 13:00"), std::string::npos) << error.what();
  }
  EXPECT_THROW(weather.at(at(7, 1, 9, 59)), hal::InputError);
  EXPECT_THROW(Weather({}, "odd", 700, 0, {WeatherRecord{}}), hal::InputError);
  EXPECT_THROW(Weather({}, "none", 3600, 0, {}), hal::InputError);
  EXPECT_THROW(Weather({}, "over the year's end", 3600, 8759, {2, WeatherRecord{}}), hal::InputError);
}

TEST(Weather, AYearServesEveryYearAndRunsOverItsEnd) {
  const auto weather = synthetic_weather(3);
  EXPECT_EQ(weather->at(at(7, 4, 15, 12, 2021)).outdoor_temp_degc,
            weather->at(at(7, 4, 15, 12, 2030)).outdoor_temp_degc);
  EXPECT_EQ(weather->at(at(2, 29, 9, 0, 2024)).outdoor_temp_degc, weather->at(at(2, 28, 9, 0, 2024)).outdoor_temp_degc);
  EXPECT_EQ(weather->at(at(12, 31, 9, 0, 2024)).outdoor_temp_degc,
            weather->at(at(12, 31, 9, 0, 2023)).outdoor_temp_degc);
  const double before = weather->at(at(12, 31, 23, 57)).outdoor_temp_degc;
  EXPECT_NEAR(weather->at(at(1, 1, 0, 3)).outdoor_temp_degc, before, 1.0);
}

TEST(SyntheticWeather, IsTheSameForASeedAndDifferentForAnother) {
  const auto a = synthetic_weather(1), b = synthetic_weather(1), c = synthetic_weather(2);
  EXPECT_EQ(a->at(at(7, 9, 14)).outdoor_temp_degc, b->at(at(7, 9, 14)).outdoor_temp_degc);
  EXPECT_NE(a->at(at(7, 9, 14)).outdoor_temp_degc, c->at(at(7, 9, 14)).outdoor_temp_degc);
}

TEST(SyntheticWeather, HasAHotHumidSunnyJulyWithSomeRain) {
  double low = 0, high = 0, brightest = 0;
  int rain_hours = 0;
  constexpr int seeds = 10;
  for (std::uint64_t seed = 0; seed < seeds; ++seed) {
    const auto weather = synthetic_weather(seed);
    for (int day = 1; day <= 31; ++day) {
      double least = 99, most = -99;
      for (int hour = 0; hour < 24; ++hour) {
        const WeatherRecord now = weather->at(at(7, day, hour));
        least = std::min(least, now.outdoor_temp_degc);
        most = std::max(most, now.outdoor_temp_degc);
        brightest = std::max(brightest, now.global_horizontal_w_m2);
        rain_hours += now.rain > 0;
        EXPECT_GE(now.relative_humidity_pct, 35);
        EXPECT_LE(now.relative_humidity_pct, 100);
        if (hour < 4) {
          EXPECT_EQ(now.global_horizontal_w_m2, 0);
        }
      }
      low += least / (31 * seeds);
      high += most / (31 * seeds);
    }
  }
  std::printf("July: %.1f to %.1f degC a day, sun up to %.0f W/m2, %.0f h of rain a month\n", low, high, brightest,
              rain_hours / static_cast<double>(seeds));
  EXPECT_NEAR(low, 26.5, 1.5);
  EXPECT_NEAR(high, 34, 1.5);
  EXPECT_GT(brightest, 800);
  EXPECT_LT(brightest, 1050);
  EXPECT_GT(rain_hours, 20 * seeds);
  EXPECT_LT(rain_hours, 200 * seeds);
}

TEST(SyntheticWeather, IsCoolerInWinterAndCloudsPersistFromDayToDay) {
  const auto weather = synthetic_weather(5);
  EXPECT_GT(weather->at(at(7, 20, 3)).outdoor_temp_degc, weather->at(at(1, 20, 3)).outdoor_temp_degc + 6);
  std::vector<double> clearness;
  for (int day = 0; day < 365; ++day) {
    double sum = 0;
    for (int hour = 9; hour < 16; ++hour) {
      sum += weather->at({at(1, 1, hour).seconds + day * 86400}).direct_normal_w_m2;
    }
    clearness.push_back(sum);
  }
  double mean = 0;
  for (double c : clearness) mean += c / 365;
  double together = 0, alone = 0;
  for (std::size_t d = 0; d + 1 < clearness.size(); ++d) {
    together += (clearness[d] - mean) * (clearness[d + 1] - mean);
    alone += (clearness[d] - mean) * (clearness[d] - mean);
  }
  EXPECT_GT(together / alone, 0.3);
}

bool same_sky(const Sky& a, const Sky& b) {
  return a.sun.east == b.sun.east && a.sun.north == b.sun.north && a.sun.up == b.sun.up &&
         a.humidity_kg_kg == b.humidity_kg_kg && a.weather.outdoor_temp_degc == b.weather.outdoor_temp_degc &&
         a.weather.direct_normal_w_m2 == b.weather.direct_normal_w_m2 && a.weather.rain == b.weather.rain;
}

TEST(Skies, ThatAreKeptAreThoseThatAreComputed) {
  const Weather weather = two_hours();
  Weather kept = two_hours();
  kept.keep_skies();
  for (int minute = 0; minute <= 180; minute += 3) {
    for (const int year : {2021, 2024}) {
      const CivilTime t = at(7, 1, 10, minute, year);
      EXPECT_TRUE(same_sky(kept.sky_at(t), weather.sky_at(t))) << minute;
    }
  }
  const CivilTime noon = at(7, 1, 12);
  EXPECT_EQ(weather.sky_at(noon).weather.outdoor_temp_degc, weather.at(noon).outdoor_temp_degc);
  EXPECT_EQ(weather.sky_at(noon).sun.up, sun_at(weather.location(), noon).up);
  EXPECT_THROW((void)kept.sky_at(at(7, 1, 14)), hal::InputError);
}

Recording day_of(const std::shared_ptr<const Weather>& station, double outdoor_degc) {
  Recording recording{at(7, 10, 0), std::vector<RecordedRow>(rows_per_day), station};
  for (RecordedRow& row : recording.rows) row.outdoor_temp_degc = outdoor_degc;
  return recording;
}

TEST(MeasuredWeathers, AreSharedByRecordingsOfOneStationStartAndMeasurement) {
  const std::shared_ptr<const Weather> station = synthetic_weather(1);
  MeasuredWeathers memory;
  const auto first = memory.of(day_of(station, 30));
  EXPECT_EQ(memory.of(day_of(station, 30)), first);
  EXPECT_NE(memory.of(day_of(station, 31)), first);
  EXPECT_NE(memory.of(day_of(std::make_shared<const Weather>(*station), 30)), first);
  Recording later = day_of(station, 30);
  later.from = at(7, 11, 0);
  EXPECT_NE(memory.of(later), first);
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  EXPECT_EQ(memory.of(day_of(station, unknown)), memory.of(day_of(station, unknown))) << "not measured";
  for (int i = 0; i < 8; ++i) (void)memory.of(day_of(station, 40 + i));
  EXPECT_NE(memory.of(day_of(station, 30)), first) << "the oldest is forgotten";
  const auto anew = measured_weather(day_of(station, 30));
  for (int minute = 0; minute < 1440; minute += 3) {
    EXPECT_TRUE(same_sky(first->sky_at(at(7, 10, 0, minute)), anew->sky_at(at(7, 10, 0, minute)))) << minute;
  }
}

}  // namespace
}  // namespace airside::sim
