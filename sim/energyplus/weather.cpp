#include "sim/energyplus/weather.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdlib>
#include <fstream>
#include <sstream>
#include <string_view>

#include "airside/splitmix64.hpp"
#include "hal/text/input_error.hpp"

namespace airside::sim {
namespace {

// Columns of an EPW record.
constexpr std::size_t hour_column = 3, dry_bulb = 6, dew_point = 7, first_solar = 13, last_solar = 15,
                      precipitation = 33;
constexpr std::size_t first_value = 6, weather_codes = 27, last_value = 31, header_lines = 8;

double number(const std::string& text) { return std::strtod(text.c_str(), nullptr); }

void scale(std::string& field, double factor) {
  const double value = number(field);
  if (value < 9999) field = fmt::format("{:.1f}", value * factor);
}

void shift(std::string& field, double offset_k) {
  const double value = number(field);
  if (value < 99) field = fmt::format("{:.1f}", value + offset_k);
}

std::vector<std::string> fields_of(const std::string& line) {
  std::vector<std::string> fields(1);
  for (const char c : line) {
    if (c == ',') {
      fields.emplace_back();
    } else if (c != '\r') {
      fields.back() += c;
    }
  }
  return fields;
}

/// Columns that only the engine reads, such as the dew point: it ends over the first one that is no number.
void refuse_text(const std::vector<std::string>& record, const std::string& place) {
  for (std::size_t i = first_value; i <= last_value; ++i) {
    std::string_view field = record[i];
    while (field.starts_with(' ')) field.remove_prefix(1);
    while (field.ends_with(' ')) field.remove_suffix(1);
    if (i == weather_codes || field.empty()) continue;
    double value = 0;
    const auto [end, error] = std::from_chars(field.data(), field.data() + field.size(), value);
    if (error == std::errc() && end == field.data() + field.size()) continue;
    throw hal::InputError(fmt::format("{}: column {}", place, i + 1), fmt::format("\"{}\"", field), "a number",
                          "repair the line or fetch the file again");
  }
}

}  // namespace

EpwFile read_epw_file(const std::filesystem::path& file, const EpwDemand& demand) {
  std::ifstream in(file, std::ios::binary);
  if (!in) throw hal::InputError(file.string(), "no readable file", "an EPW weather file", "check the path");
  std::ostringstream all;
  all << in.rdbuf();
  const std::string text = std::move(all).str();
  (void)read_epw_text(text, file.string(), demand);
  std::istringstream lines(text);
  EpwFile weather;
  int at = 0;
  bool in_header = true;
  for (std::string line; std::getline(lines, line);) {
    ++at;
    if (line.ends_with('\r')) line.pop_back();
    if (in_header) {
      weather.header.push_back(line);
      in_header = !line.starts_with("DATA PERIODS");
      if (!in_header && weather.header.size() != header_lines) {
        throw hal::InputError(fmt::format("{}:{}: DATA PERIODS", file.string(), at),
                              fmt::format("a header of {} lines", at), "eight lines, as EnergyPlus reads them",
                              "put the missing header lines back, or fetch the file again");
      }
    } else if (!line.empty()) {
      weather.records.push_back(fields_of(line));
      refuse_text(weather.records.back(), fmt::format("{}:{}", file.string(), at));
    }
  }
  return weather;
}

EpwFile changed_epw(EpwFile weather, const WeatherChange& change, std::uint64_t seed) {
  SplitMix64 stream(seed ^ 0x57024u);
  bool storm = false;
  double from_hour = 0, to_hour = 0;
  std::string day;
  for (auto& record : weather.records) {
    const std::string today = record[1] + "-" + record[2];
    if (today != day) {
      day = today;
      storm = stream.uniform() < change.storms_per_week / 7.0;
      from_hour = 13.0 + stream.below(4);
      to_hour = from_hour + 1.0 + stream.below(2);
    }
    if (change.dry_bulb_offset_k != 0) {
      shift(record[dry_bulb], change.dry_bulb_offset_k);
      shift(record[dew_point], change.dry_bulb_offset_k);
    }
    const double now = number(record[hour_column]);
    const bool raining = storm && now >= from_hour && now < to_hour;
    const double sun = change.solar_factor * (raining ? 0.33 : 1.0);
    if (sun != 1.0)
      for (std::size_t i = first_solar; i <= last_solar; ++i) scale(record[i], sun);
    if (!raining) continue;
    // The air cools to, but not below, what it can hold.
    const double cooled = std::max(number(record[dry_bulb]) - 3.0, number(record[dew_point]));
    record[dry_bulb] = fmt::format("{:.1f}", cooled);
    record.resize(std::max(record.size(), precipitation + 1), "0");
    record[precipitation] = "6.0";
  }
  return weather;
}

void write_epw(const EpwFile& weather, const std::filesystem::path& file) {
  std::ofstream out(file, std::ios::binary);
  for (const auto& line : weather.header) out << line << '\n';
  for (const auto& record : weather.records) {
    for (std::size_t i = 0; i < record.size(); ++i) out << (i > 0 ? "," : "") << record[i];
    out << '\n';
  }
}

}  // namespace airside::sim
