#pragma once
// A made-up year of hot and humid weather, for plants that have no EPW file at hand.

#include <cstdint>
#include <memory>
#include <string>

#include "sim/weather/weather.hpp"

namespace airside::sim {

/// What kind of year; the defaults give a July of 26 to 35 degC a day with sun up to 900 W/m2 (docs/method.md, open
/// point 22).
struct Climate {
  Location location{"synthetic Taiwan-like site", 24.8, 120.97, 8.0, 30.0};
  double mean_temp_degc = 24.4;      ///< of the year
  double seasonal_swing_k = 6.4;     ///< half the difference of July and January
  double daily_swing_k = 4.0;        ///< half the day's range under a clear sky
  double day_temp_sd_k = 0.9;        ///< spells of warm and cool days
  double mean_cloudiness = 0.42;     ///< 0 clear .. 1 overcast
  double rain_hours_per_year = 700;  ///< falls on cloudy days
};

/// A year of hourly records: clouds persist from day to day, rain falls under clouds and cools the air.
/// `of`: for its description, where `seed` is derived from what a person typed: "of room 301, seed 3"; empty: the seed.
/// Cost: 8760 records, about 3 ms.
std::shared_ptr<const Weather> synthetic_weather(std::uint64_t seed, const Climate& climate = {},
                                                 const std::string& of = "");

}  // namespace airside::sim
