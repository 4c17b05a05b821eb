#include "sim/weather/epw.hpp"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <fstream>
#include <sstream>
#include <string_view>
#include <vector>

#include "hal/text/foreign_text.hpp"
#include "hal/text/input_error.hpp"

namespace airside::sim {
namespace {

using Columns = std::vector<std::string_view>;
constexpr std::size_t least_columns = 32;  // up to days since last snow; the last three came later
constexpr std::size_t most_columns = 35;
constexpr int longest_bridge_h = 6;

// A value column: its place, what it may be, and from which number on it means "missing".
struct Column {
  std::size_t index;
  const char* name;
  double lowest, highest, missing_from;
  double WeatherRecord::*member;
};
constexpr std::array columns = {
    Column{6, "dry bulb temperature", -70, 70, 99.9, &WeatherRecord::outdoor_temp_degc},
    Column{8, "relative humidity", 0, 110, 999, &WeatherRecord::relative_humidity_pct},
    Column{9, "atmospheric pressure", 31000, 120000, 999999, &WeatherRecord::pressure_pa},
    Column{14, "direct normal radiation", 0, 1600, 9999, &WeatherRecord::direct_normal_w_m2},
    Column{15, "diffuse horizontal radiation", 0, 1200, 9999, &WeatherRecord::diffuse_horizontal_w_m2},
    Column{21, "wind speed", 0, 40, 999, &WeatherRecord::wind_speed_m_s},
    Column{13, "global horizontal radiation", 0, 1600, 9999,
           &WeatherRecord::global_horizontal_w_m2},  // last: a gap is filled from the other two
};
constexpr std::size_t global_column = 6;
constexpr std::size_t weather_codes_column = 27, precipitation_column = 33;

Columns split(std::string_view line) {
  Columns parts;
  while (true) {
    const std::size_t comma = line.find(',');
    std::string_view part = line.substr(0, comma);
    while (!part.empty() && part.front() == ' ') part.remove_prefix(1);
    while (!part.empty() && (part.back() == ' ' || part.back() == '\r')) part.remove_suffix(1);
    parts.push_back(part);
    if (comma == std::string_view::npos) return parts;
    line.remove_prefix(comma + 1);
  }
}

class Reader {
 public:
  Reader(std::istream& file, const std::string& path) : path_(path), file_(file) {
    if (!file_) fail_file("no readable file", "an EPW weather file", "check the path");
  }

  std::shared_ptr<const Weather> read(const EpwDemand& demand) {
    read_header();
    read_records();
    bridge_gaps();
    auto weather = std::make_shared<const Weather>(location_, path_, interval_s_, first_interval_, std::move(records_));
    if (demand.whole_year && !weather->covers_year()) {
      fail_file(std::to_string(weather->records().size()) + " records of " + std::to_string(interval_s_ / 60) + " min",
                std::to_string(365 * 86400 / interval_s_) + " records, a whole year",
                "use a file of a whole year, or ask only for the period it covers");
    }
    if (demand.from && demand.to) weather->require(*demand.from, *demand.to);
    return weather;
  }

 private:
  [[noreturn]] void fail(const std::string& field, std::string found, std::string expected, std::string remedy) const {
    throw hal::InputError(path_ + ":" + std::to_string(line_number_) + ": " + field, std::move(found),
                          std::move(expected), std::move(remedy));
  }
  [[noreturn]] void fail_file(std::string found, std::string expected, std::string remedy) const {
    throw hal::InputError(path_, std::move(found), std::move(expected), std::move(remedy));
  }

  double number(const Columns& parts, std::size_t index, const char* field, double lowest, double highest) const {
    const std::string_view text = index < parts.size() ? parts[index] : std::string_view();
    double value = 0;
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size() || !std::isfinite(value)) {
      fail(field, "\"" + std::string(text) + "\"", "a number", "repair the line or fetch the file again");
    }
    if (value < lowest || value > highest) {
      fail(field, std::string(text), "a value from " + shown(lowest) + " to " + shown(highest),
           "repair the value or mark it as missing");
    }
    return value;
  }
  int integer(const Columns& parts, std::size_t index, const char* field, int lowest, int highest) const {
    const double value = number(parts, index, field, lowest, highest);
    if (value != std::floor(value)) fail(field, shown(value), "a whole number", "repair the line");
    return static_cast<int>(value);
  }
  static std::string shown(double value) {
    std::string text = std::to_string(value);
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
    return text;
  }

  bool next_line(std::string& line) {
    if (!std::getline(file_, line)) return false;
    ++line_number_;
    return true;
  }

  void read_header() {
    std::string line;
    line_number_ = 0;
    if (!next_line(line)) fail_file("an empty file", "an EPW weather file", "fetch the file again");
    hal::refuse_foreign_text(line, path_ + ":1", "an EPW weather file");
    if (line.starts_with("LOCATION;")) {
      fail("LOCATION", "columns separated by `;`", "columns separated by `,`",
           "fetch the file again; save no EPW file from a spreadsheet");
    }
    Columns parts = split(line);
    if (parts[0] != "LOCATION" || parts.size() < 10) {
      fail("LOCATION", "\"" + line.substr(0, 40) + "\"",
           "LOCATION,city,state,country,source,WMO,latitude,longitude,time zone,elevation",
           "see that the file is an EPW file and starts with its LOCATION line");
    }
    location_.name = std::string(parts[1]);
    location_.latitude_deg = number(parts, 6, "latitude", -90, 90);
    location_.longitude_deg = number(parts, 7, "longitude", -180, 180);
    location_.utc_offset_h = number(parts, 8, "time zone", -12, 14);
    location_.elevation_m = number(parts, 9, "elevation", -1000, 9999.9);
    while (next_line(line)) {
      parts = split(line);
      if (parts[0] != "DATA PERIODS") {
        if (!parts[0].empty() && parts[0].front() >= '0' && parts[0].front() <= '9') break;
        continue;
      }
      if (integer(parts, 1, "number of data periods", 1, 99) != 1) {
        fail("number of data periods", std::string(parts[1]), "1", "split the file into one file a period");
      }
      const int per_hour = integer(parts, 2, "records per hour", 1, 60);
      if (60 % per_hour != 0)
        fail("records per hour", std::to_string(per_hour), "a divisor of 60", "resample the file");
      interval_s_ = 3600 / per_hour;
      return;
    }
    fail("DATA PERIODS", "no such line before the records", "DATA PERIODS,1,1,Data,Sunday,1/1,12/31",
         "fetch the file again");
  }

  // Interval of the year that a record covers, -1 for 29 February.
  std::int64_t interval_of(const Columns& parts) {
    const int month = integer(parts, 1, "month", 1, 12);
    static constexpr int length[] = {31, 29, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31};
    const int day = integer(parts, 2, "day", 1, length[month - 1]);
    const int hour = integer(parts, 3, "hour", 1, 24);
    const int per_hour = 3600 / interval_s_;
    // Hourly files write minute 0 or 60. Finer ones count 6, 12 .. 60 or, as EnergyPlus asks of some, 0, 6 .. 54.
    int minute = integer(parts, 4, "minute", 0, 60);
    if (records_.empty()) minute_of_start_ = per_hour > 1 && minute == 0;
    if (per_hour == 1) minute = 60;
    if (minute_of_start_) minute += interval_s_ / 60;
    if (minute * 60 % interval_s_ != 0) {
      fail("minute", std::to_string(minute), "a multiple of " + std::to_string(interval_s_ / 60),
           "see the records per hour in DATA PERIODS");
    }
    if (month == 2 && day == 29) return -1;
    const std::int64_t midnight = second_of_year(civil_midnight(2023, month, day));
    return midnight / interval_s_ + (hour - 1) * per_hour + minute * 60 / interval_s_ - 1;
  }

  void read_records() {
    std::string line;
    while (next_line(line)) {
      if (line.empty() || line == "\r") continue;
      const Columns parts = split(line);
      if (parts.size() < least_columns || parts.size() > most_columns) {
        fail("columns", std::to_string(parts.size()) + " columns",
             std::to_string(least_columns) + " to " + std::to_string(most_columns) + " columns",
             "repair the line or fetch the file again");
      }
      const std::int64_t interval = interval_of(parts);
      if (interval < 0) continue;
      if (records_.empty()) first_interval_ = static_cast<int>(interval);
      const std::int64_t expected = first_interval_ + static_cast<std::int64_t>(records_.size());
      if (interval != expected) {
        const CivilTime due{civil_midnight(2023, 1, 1).seconds + expected * interval_s_};
        fail("date", "the interval that starts " + date_text(interval), "the one that starts " + text_of(due).substr(5),
             "put in the missing records or remove the double ones; files may not run over the turn of the year");
      }
      add_record(parts);
    }
    if (records_.empty()) fail_file("no records after the header", "one record an interval", "fetch the file again");
  }

  std::string date_text(std::int64_t interval) const {
    return text_of({civil_midnight(2023, 1, 1).seconds + interval * interval_s_}).substr(5);
  }

  void add_record(const Columns& parts) {
    WeatherRecord record;
    std::array<bool, columns.size()> missing{};
    for (std::size_t c = 0; c < columns.size(); ++c) {
      const Column& column = columns[c];
      const bool blank = column.index < parts.size() && parts[column.index].empty();
      const double value = blank ? column.missing_from : number(parts, column.index, column.name, -1e9, 1e9);
      missing[c] = value >= column.missing_from;
      if (!missing[c]) record.*column.member = number(parts, column.index, column.name, column.lowest, column.highest);
    }
    record.relative_humidity_pct = std::min(record.relative_humidity_pct, 100.0);
    record.rain = rains(parts) ? 1.0 : 0.0;
    records_.push_back(record);
    missing_.push_back(missing);
    lines_.push_back(line_number_);
  }

  // Present weather: observed unless the flag is 9; nine digits, 9 = none; the 2nd tells of rain, the 3rd of drizzle.
  // Depth in mm, 999 missing.
  bool rains(const Columns& parts) const {
    const std::string_view codes = parts[weather_codes_column];
    const bool observed = parts[weather_codes_column - 1] != "9" && codes.size() == 9;
    if (observed && (codes[1] < '9' || codes[2] < '9')) return true;
    if (parts.size() <= precipitation_column || parts[precipitation_column].empty()) return false;
    const double depth_mm = number(parts, precipitation_column, "liquid precipitation depth", 0, 9999);
    return depth_mm > 0 && depth_mm < 999;
  }

  void bridge_gaps() {
    const std::size_t count = records_.size();
    const auto longest = static_cast<std::size_t>(longest_bridge_h * 3600 / interval_s_);
    for (std::size_t c = 0; c < columns.size(); ++c) {
      double WeatherRecord::*const member = columns[c].member;
      // Global radiation follows from the other two; wind and pressure are not worth a refusal.
      const bool replaceable = member == &WeatherRecord::wind_speed_m_s || member == &WeatherRecord::pressure_pa;
      for (std::size_t i = 0; i < count; ++i) {
        if (!missing_[i][c]) continue;
        std::size_t end = i;
        while (end < count && missing_[end][c]) ++end;
        if (c == global_column) {
          for (std::size_t k = i; k < end; ++k) fill_global(k);
        } else if (end - i <= longest && i > 0 && end < count) {
          const double first = records_[i - 1].*member, last = records_[end].*member;
          for (std::size_t k = i; k < end; ++k) {
            const double share = static_cast<double>(k - i + 1) / static_cast<double>(end - i + 1);
            records_[k].*member = first + (last - first) * share;
          }
        } else if (replaceable) {
          const double standard = member == &WeatherRecord::pressure_pa
                                      ? 101325 * std::pow(1 - 2.25577e-5 * location_.elevation_m, 5.2559)
                                      : 2.0;
          for (std::size_t k = i; k < end; ++k) records_[k].*member = standard;
        } else {
          line_number_ = lines_[i];
          fail(columns[c].name, "no value over " + std::to_string(end - i) + " records",
               "gaps of at most 6 h inside the file", "fill the column from another station");
        }
        i = end;
      }
    }
  }

  void fill_global(std::size_t k) {
    WeatherRecord& r = records_[k];
    const CivilTime middle{civil_midnight(2023, 1, 1).seconds +
                           (first_interval_ + static_cast<std::int64_t>(k)) * interval_s_ + interval_s_ / 2};
    r.global_horizontal_w_m2 =
        r.diffuse_horizontal_w_m2 + r.direct_normal_w_m2 * std::max(0.0, sun_at(location_, middle).up);
  }

  std::string path_;
  std::istream& file_;
  int line_number_ = 0;
  Location location_;
  int interval_s_ = 3600, first_interval_ = 0;
  bool minute_of_start_ = false;  // minutes name the start of a record's interval, not its end
  std::vector<WeatherRecord> records_;
  std::vector<std::array<bool, columns.size()>> missing_;
  std::vector<int> lines_;
};

}  // namespace

std::shared_ptr<const Weather> read_epw(const std::string& path, const EpwDemand& demand) {
  std::ifstream file(path);
  return Reader(file, path).read(demand);
}

std::shared_ptr<const Weather> read_epw_text(const std::string& text, const std::string& path,
                                             const EpwDemand& demand) {
  std::istringstream file(text);
  return Reader(file, path).read(demand);
}

}  // namespace airside::sim
