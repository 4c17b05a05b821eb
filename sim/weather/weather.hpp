#pragma once
// Weather at a site: a table of records over (part of) a calendar year, read at any civil time, with the sun's
// position and the irradiance of the four façades. EPW files, synthetic years and measured series all become one.

#include <array>
#include <string>
#include <vector>

#include "airside/civil_time.hpp"

namespace airside::sim {

/// Where the weather was measured.
struct Location {
  std::string name = "unnamed";
  double latitude_deg = 24.8;     ///< north positive, -90..90
  double longitude_deg = 120.97;  ///< east positive, -180..180
  double utc_offset_h = 8;        ///< of local standard time
  double elevation_m = 0;
};

/// One interval of a table: temperatures, humidity, wind and pressure hold at its end; radiation is its mean.
struct WeatherRecord {
  double outdoor_temp_degc = 0;
  double relative_humidity_pct = 0;
  double direct_normal_w_m2 = 0;
  double diffuse_horizontal_w_m2 = 0;
  double global_horizontal_w_m2 = 0;
  double wind_speed_m_s = 0;
  double pressure_pa = 101325;
  double rain = 0;  ///< 1 if it rained in the interval
};

/// Unit vector from the ground to the sun.
struct SunDirection {
  double east = 0, north = 0, up = -1;
};

/// One instant above a site.
struct Sky {
  WeatherRecord weather;
  SunDirection sun;
  double humidity_kg_kg = 0;  ///< humidity_ratio() of the outdoor air
};

enum class Facade { north = 0, east = 1, south = 2, west = 3 };
constexpr std::size_t facades = 4;

/// Direction of the sun at civil time t (equation of time and declination after Spencer 1971, < 0.3 deg off).
SunDirection sun_at(const Location& location, CivilTime t);

/// Beam, sky and ground-reflected irradiance on the four vertical façades, order of Facade.  W/m2.
///   I = direct * max(0, cos incidence) + diffuse / 2 + albedo * global / 2, albedo 0.2.
std::array<double, facades> facade_irradiance_w_m2(const WeatherRecord& weather, const SunDirection& sun);

/// Mass of water per mass of dry air, from temperature and relative humidity (Magnus formula).  kg/kg.
double humidity_ratio(double temp_degc, double relative_humidity_pct, double pressure_pa);

/// A table over the 365-day calendar; the year of the asked time does not matter, 29 February reads 28 February.
class Weather {
 public:
  /// `records[i]` covers the interval that starts (first_interval + i) * interval_s after 1 January 00:00.
  /// Errors: hal::InputError if the interval does not divide an hour, the table is empty or leaves the year.
  Weather(Location location, std::string description, int interval_s, int first_interval,
          std::vector<WeatherRecord> records);

  /// Weather at t: linear in time (radiation between mid-intervals, zero with the sun down), rain as a step.
  /// Errors: hal::InputError if the table does not cover t.
  WeatherRecord at(CivilTime t) const;

  /// at(), and what goes with it.  Errors: as at().
  Sky sky_at(CivilTime t) const;

  /// Computes sky_at() of each record's end once, for a table that is lived through often; the values stay the same.
  /// Cost: 96 bytes and one sky_at() a record.
  void keep_skies();

  /// Throws hal::InputError unless every instant from `from` to `to` is covered.
  void require(CivilTime from, CivilTime to) const;

  bool covers_year() const { return records_.size() == intervals_per_year_; }
  const Location& location() const { return location_; }
  const std::string& description() const { return description_; }
  int interval_s() const { return interval_s_; }
  /// Intervals between 1 January 00:00 and the first record.
  int first_interval() const { return static_cast<int>(first_interval_); }
  const std::vector<WeatherRecord>& records() const { return records_; }

 private:
  const WeatherRecord& record(std::int64_t interval) const;
  WeatherRecord under(const SunDirection& sun, CivilTime t) const;
  [[noreturn]] void refuse(CivilTime t) const;

  Location location_;
  std::string description_;
  int interval_s_;
  std::int64_t first_interval_;
  std::size_t intervals_per_year_;
  std::vector<WeatherRecord> records_;
  std::vector<Sky> skies_;  ///< of the start of each record and the end of the last; empty: not kept
};

/// Civil time of a date at midnight.
CivilTime civil_midnight(int year, int month, int day);
/// "2021-07-01 07:12".
std::string text_of(CivilTime t);
/// Seconds from 1 January 00:00 in the 365-day calendar, 29 February folded onto 28 February.
std::int64_t second_of_year(CivilTime t);

}  // namespace airside::sim
