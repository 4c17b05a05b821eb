#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <fstream>

#include "hal/text/input_error.hpp"
#include "sim/weather/epw.hpp"

namespace airside::sim {
namespace {

// Dew point by the Magnus formula, degC.
double dew_point_degc(double temp_degc, double relative_humidity_pct) {
  const double share = std::log(std::fmax(relative_humidity_pct, 1.0) / 100) + 17.62 * temp_degc / (243.12 + temp_degc);
  return 243.12 * share / (17.62 - share);
}

// Sky radiation from a clear-sky emissivity, W/m2 (Martin and Berdahl 1984, without its small terms).
double sky_radiation_w_m2(double temp_degc, double dew_degc) {
  const double hundredth = dew_degc / 100;
  const double emissivity = 0.711 + 0.56 * hundredth + 0.73 * hundredth * hundredth;
  return emissivity * 5.6697e-8 * std::pow(temp_degc + 273.15, 4);
}

// "7/ 1" of a second of the 365-day year, as EPW headers have it.
std::string month_day(CivilTime t) {
  const std::string text = text_of(t);
  return std::to_string(std::stoi(text.substr(5, 2))) + "/" + std::to_string(std::stoi(text.substr(8, 2)));
}

}  // namespace

void write_epw(const std::string& path, const Weather& weather, int year) {
  std::ofstream file(path);
  const Location& place = weather.location();
  const int per_hour = 3600 / weather.interval_s();
  // Positions are counted in the 365-day calendar; 2023 is such a year.
  const std::int64_t new_year = civil_midnight(2023, 1, 1).seconds;
  const std::int64_t first = new_year + static_cast<std::int64_t>(weather.first_interval()) * weather.interval_s();
  const std::int64_t last = first + (static_cast<std::int64_t>(weather.records().size()) - 1) * weather.interval_s();
  const int month = std::stoi(text_of({first}).substr(5, 2)), day = std::stoi(text_of({first}).substr(8, 2));
  static constexpr const char* weekdays[] = {"Monday", "Tuesday",  "Wednesday", "Thursday",
                                             "Friday", "Saturday", "Sunday"};

  std::string city = place.name;
  for (char& c : city)
    if (c == ',' || c == '\n') c = ' ';
  char line[512];
  std::snprintf(line, sizeof line, "LOCATION,%s,-,-,series,999999,%.5f,%.5f,%.2f,%.1f\n", city.c_str(),
                place.latitude_deg, place.longitude_deg, place.utc_offset_h, place.elevation_m);
  file << line
       << "DESIGN CONDITIONS,0\nTYPICAL/EXTREME PERIODS,0\nGROUND TEMPERATURES,0\n"
          "HOLIDAYS/DAYLIGHT SAVINGS,No,0,0,0\nCOMMENTS 1,"
       << weather.description() << "\nCOMMENTS 2,written by airside\nDATA PERIODS,1," << per_hour << ",Data,"
       << weekdays[civil_midnight(year, month, day).weekday()] << "," << month_day({first}) << "," << month_day({last})
       << "\n";

  fmt::memory_buffer lines;
  std::int64_t day_begin = -1;
  int month_of_day = 0, day_of_month = 0;
  for (std::size_t i = 0; i < weather.records().size(); ++i) {
    const WeatherRecord& r = weather.records()[i];
    const std::int64_t start = first + static_cast<std::int64_t>(i) * weather.interval_s();
    const int second = CivilTime{start}.second_of_day();
    if (start - second != day_begin) {
      day_begin = start - second;
      const std::string date = text_of({start});
      month_of_day = std::stoi(date.substr(5, 2));
      day_of_month = std::stoi(date.substr(8, 2));
    }
    const double dew = dew_point_degc(r.outdoor_temp_degc, r.relative_humidity_pct);
    fmt::format_to(
        fmt::appender(lines),
        "{},{},{},{},{},?9?9?9?9E0?9?9?9?9?9?9?9?9?9?9?9?9?9?9?9*9*9?9?9?9,{:.2f},{:.2f},{:.1f},{:.0f},9999,9999,{:.1f}"
        ","
        "{:.2f},{:.2f},{:.2f},999999,999999,999999,9999,0,{:.2f},5,5,9999,99999,0,{},999,0.0000,0,88,999,{:.1f},{:.2f}"
        "\n",
        year, month_of_day, day_of_month, second / 3600 + 1, (second % 3600 + weather.interval_s()) / 60,
        r.outdoor_temp_degc, dew, r.relative_humidity_pct, r.pressure_pa, sky_radiation_w_m2(r.outdoor_temp_degc, dew),
        r.global_horizontal_w_m2, r.direct_normal_w_m2, r.diffuse_horizontal_w_m2, r.wind_speed_m_s,
        r.rain > 0 ? "919999999" : "999999999", r.rain > 0 ? 3.0 : 0.0, 1.0 / per_hour);
  }
  file.write(lines.data(), static_cast<std::streamsize>(lines.size()));
  file.flush();
  if (!file)
    throw hal::InputError(path, "a file that cannot be written", "a writable place", "check folder, rights and space");
}

}  // namespace airside::sim
