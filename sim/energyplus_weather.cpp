#include "sim/energyplus_weather.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>

#include "airside/splitmix64.hpp"
#include "hal/input_error.hpp"

namespace airside::sim {
namespace {

// Columns of an EPW record.
constexpr std::size_t hour_column = 3, dry_bulb = 6, dew_point = 7, first_solar = 13, last_solar = 15,
                      precipitation = 33;
constexpr std::size_t needed_columns = 32, header_lines = 8;

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

}  // namespace

EpwFile read_epw(const std::filesystem::path& file) {
  const auto refuse = [&file](const std::string& place, const std::string& found) {
    throw hal::InputError(file.string() + place, found, "a weather file in EPW format",
                          "name another with --weather, or leave it out for the default");
  };
  std::error_code failed;
  if (!std::filesystem::is_regular_file(file, failed)) refuse("", "no such file");
  std::ifstream in(file, std::ios::binary);
  EpwFile weather;
  std::size_t at = 0;
  for (std::string line; std::getline(in, line);) {
    ++at;
    if (at == 1 && !line.starts_with("LOCATION,")) refuse(":1", "a first line that does not start with LOCATION");
    if (at <= header_lines) {
      weather.header.push_back(line.ends_with('\r') ? line.substr(0, line.size() - 1) : line);
    } else if (!line.empty() && line != "\r") {
      weather.records.push_back(fields_of(line));
      if (weather.records.back().size() < needed_columns)
        refuse(":" + std::to_string(at), std::to_string(weather.records.back().size()) + " columns");
    }
  }
  if (weather.records.size() < 24) refuse("", std::to_string(weather.records.size()) + " records");
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
