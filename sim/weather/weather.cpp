#include "sim/weather/weather.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "hal/text/input_error.hpp"

namespace airside::sim {
namespace {

using std::numbers::pi;
constexpr std::int64_t year_s = 365LL * 86400;
constexpr double sun_is_up = 0.01;  // sine of 0.6 deg; below it the hour's mean radiation would divide by nearly 0

std::chrono::year_month_day date_of(CivilTime t) {
  return std::chrono::year_month_day(std::chrono::sys_days(std::chrono::days(t.day())));
}

double interpolated(double a, double b, double share) { return a + (b - a) * share; }

// "07-01 06:00" of a second of the 365-day year, for messages.
std::string calendar_text(std::int64_t second) {
  const CivilTime t{civil_midnight(2023, 1, 1).seconds + second};
  return text_of(t).substr(5);
}

}  // namespace

CivilTime civil_midnight(int year, int month, int day) {
  using namespace std::chrono;
  const sys_days days_since(std::chrono::year(year) / month / day);
  return {static_cast<std::int64_t>(days_since.time_since_epoch().count()) * 86400};
}

std::string text_of(CivilTime t) {
  const auto date = date_of(t);
  char text[48];
  std::snprintf(text, sizeof text, "%04d-%02u-%02u %02d:%02d", static_cast<int>(date.year()),
                static_cast<unsigned>(date.month()), static_cast<unsigned>(date.day()), t.minute_of_day() / 60,
                t.minute_of_day() % 60);
  return text;
}

std::int64_t second_of_year(CivilTime t) {
  const auto date = date_of(t);
  std::int64_t day = t.day() - civil_midnight(static_cast<int>(date.year()), 1, 1).day();
  if (date.year().is_leap() && day >= 59) --day;
  return day * 86400 + t.second_of_day();
}

SunDirection sun_at(const Location& location, CivilTime t) {
  const double year_angle = 2 * pi * static_cast<double>(second_of_year(t) - 43200) / static_cast<double>(year_s);
  const double c1 = std::cos(year_angle), s1 = std::sin(year_angle);
  const double c2 = c1 * c1 - s1 * s1, s2 = 2 * s1 * c1;
  const double declination = 0.006918 - 0.399912 * c1 + 0.070257 * s1 - 0.006758 * c2 + 0.000907 * s2 -
                             0.002697 * (c1 * c2 - s1 * s2) + 0.00148 * (s1 * c2 + c1 * s2);
  const double equation_min = 229.18 * (0.000075 + 0.001868 * c1 - 0.032077 * s1 - 0.014615 * c2 - 0.040849 * s2);
  const double solar_min =
      t.second_of_day() / 60.0 + equation_min + 4 * (location.longitude_deg - 15 * location.utc_offset_h);
  const double hour_angle = (solar_min / 4 - 180) * pi / 180;
  const double latitude = location.latitude_deg * pi / 180;
  const double sin_d = std::sin(declination), cos_d = std::cos(declination);
  const double sin_l = std::sin(latitude), cos_l = std::cos(latitude);
  const double cos_h = std::cos(hour_angle);
  return {-cos_d * std::sin(hour_angle), cos_l * sin_d - sin_l * cos_d * cos_h, sin_l * sin_d + cos_l * cos_d * cos_h};
}

std::array<double, facades> facade_irradiance_w_m2(const WeatherRecord& weather, const SunDirection& sun) {
  const double direct = sun.up > sun_is_up ? weather.direct_normal_w_m2 : 0.0;
  const double rest = 0.5 * weather.diffuse_horizontal_w_m2 + 0.5 * 0.2 * weather.global_horizontal_w_m2;
  return {rest + direct * std::max(0.0, sun.north), rest + direct * std::max(0.0, sun.east),
          rest + direct * std::max(0.0, -sun.north), rest + direct * std::max(0.0, -sun.east)};
}

double humidity_ratio(double temp_degc, double relative_humidity_pct, double pressure_pa) {
  const double saturation_pa = 611.2 * std::exp(17.62 * temp_degc / (243.12 + temp_degc));
  const double vapour_pa = std::min(0.9 * pressure_pa, relative_humidity_pct / 100 * saturation_pa);
  return 0.622 * vapour_pa / (pressure_pa - vapour_pa);
}

Weather::Weather(Location location, std::string description, int interval_s, int first_interval,
                 std::vector<WeatherRecord> records)
    : location_(std::move(location)),
      description_(std::move(description)),
      interval_s_(interval_s),
      first_interval_(first_interval),
      intervals_per_year_(0),
      records_(std::move(records)) {
  if (interval_s < 60 || interval_s > 3600 || 3600 % interval_s != 0) {
    throw hal::InputError(description_, "interval of " + std::to_string(interval_s) + " s",
                          "a divisor of an hour from 60 s to 3600 s", "resample the series");
  }
  intervals_per_year_ = static_cast<std::size_t>(year_s / interval_s);
  const auto last = static_cast<std::size_t>(std::max(0, first_interval)) + records_.size();
  if (records_.empty() || first_interval < 0 || last > intervals_per_year_) {
    throw hal::InputError(description_, std::to_string(records_.size()) + " records",
                          "1 to " + std::to_string(intervals_per_year_) + " records within one calendar year",
                          "cut the series at the turn of the year");
  }
}

const WeatherRecord& Weather::record(std::int64_t interval) const {
  const auto count = static_cast<std::int64_t>(records_.size());
  std::int64_t index = interval - first_interval_;
  if (covers_year()) index = (index % count + count) % count;
  return records_[static_cast<std::size_t>(std::clamp<std::int64_t>(index, 0, count - 1))];
}

void Weather::refuse(CivilTime t) const {
  throw hal::InputError(description_, "a request for the weather of " + text_of(t),
                        "a time from " + calendar_text(first_interval_ * interval_s_) + " to " +
                            calendar_text((first_interval_ + static_cast<std::int64_t>(records_.size())) * interval_s_),
                        "choose another start date or a weather file that covers the period");
}

WeatherRecord Weather::at(CivilTime t) const { return under(sun_at(location_, t), t); }

Sky Weather::sky_at(CivilTime t) const {
  if (!skies_.empty()) {
    const std::int64_t second = second_of_year(t);
    const std::int64_t index = second / interval_s_ - first_interval_;
    if (second % interval_s_ == 0 && index >= 0 && index < std::ssize(skies_))
      return skies_[static_cast<std::size_t>(index)];
  }
  Sky sky;
  sky.sun = sun_at(location_, t);
  sky.weather = under(sky.sun, t);
  sky.humidity_kg_kg =
      humidity_ratio(sky.weather.outdoor_temp_degc, sky.weather.relative_humidity_pct, sky.weather.pressure_pa);
  return sky;
}

void Weather::keep_skies() {
  std::vector<Sky> skies;
  skies.reserve(records_.size() + 1);
  const CivilTime new_year = civil_midnight(2021, 1, 1);
  for (std::int64_t i = 0; i <= std::ssize(records_); ++i) {
    skies.push_back(sky_at({new_year.seconds + (first_interval_ + i) * interval_s_}));
  }
  skies_ = std::move(skies);
}

WeatherRecord Weather::under(const SunDirection& sun, CivilTime t) const {
  const std::int64_t second = second_of_year(t);
  const std::int64_t interval = second / interval_s_;
  const auto count = static_cast<std::int64_t>(records_.size());
  const std::int64_t index = interval - first_interval_;
  // The very end of the last record still has a value: a run may stop there.
  const bool at_end = index == count && second % interval_s_ == 0;
  if (!covers_year() && (index < 0 || (index >= count && !at_end))) refuse(t);

  const double share = static_cast<double>(second % interval_s_) / interval_s_;
  const WeatherRecord& before = record(interval - 1);
  const WeatherRecord& here = record(interval);
  const WeatherRecord& earlier = share < 0.5 ? before : here;
  const WeatherRecord& later = share < 0.5 ? here : record(interval + 1);
  const double mid_share = share < 0.5 ? share + 0.5 : share - 0.5;

  WeatherRecord now;
  now.outdoor_temp_degc = interpolated(before.outdoor_temp_degc, here.outdoor_temp_degc, share);
  now.relative_humidity_pct = interpolated(before.relative_humidity_pct, here.relative_humidity_pct, share);
  now.wind_speed_m_s = interpolated(before.wind_speed_m_s, here.wind_speed_m_s, share);
  now.pressure_pa = interpolated(before.pressure_pa, here.pressure_pa, share);
  now.rain = here.rain;
  if (sun.up > 0) {
    now.direct_normal_w_m2 = interpolated(earlier.direct_normal_w_m2, later.direct_normal_w_m2, mid_share);
    now.diffuse_horizontal_w_m2 =
        interpolated(earlier.diffuse_horizontal_w_m2, later.diffuse_horizontal_w_m2, mid_share);
    now.global_horizontal_w_m2 = interpolated(earlier.global_horizontal_w_m2, later.global_horizontal_w_m2, mid_share);
  }
  return now;
}

void Weather::require(CivilTime from, CivilTime to) const {
  if (covers_year()) return;
  for (CivilTime t = from; t < to; t.seconds += interval_s_) at(t);
  at(to);
}

}  // namespace airside::sim
