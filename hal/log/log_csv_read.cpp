#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <map>
#include <optional>

#include "hal/log/log_columns.hpp"
#include "hal/log/log_csv.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/text/foreign_text.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/number_text.hpp"

namespace airside::hal {
namespace {

std::string in_quotes(std::string_view text) {
  std::string shown(text.substr(0, 60));
  for (char& c : shown) {
    if (static_cast<unsigned char>(c) < 0x20) c = '?';
  }
  return "`" + shown + (text.size() > 60 ? "..." : "") + "`";
}

/// Splits one line at commas; a field in double quotes may hold commas and doubled quotes.
void split(std::string_view line, std::vector<std::string>& fields) {
  fields.clear();
  std::string field;
  bool inside = false;
  for (std::size_t i = 0; i < line.size(); ++i) {
    const char c = line[i];
    if (c == '"' && inside && i + 1 < line.size() && line[i + 1] == '"') {
      field += line[++i];
    } else if (c == '"' && (inside || field.empty())) {
      inside = !inside;
    } else if (c == ',' && !inside) {
      fields.push_back(std::move(field));
      field.clear();
    } else {
      field += c;
    }
  }
  fields.push_back(std::move(field));
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t')) text.remove_suffix(1);
  return text;
}

std::optional<double> parse_number(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  if (result.ec != std::errc{} || result.ptr != text.data() + text.size()) return std::nullopt;
  return value;
}

/// How many `base_1 .. base_n` columns a header has, whatever their unit; 0 when they do not run from 1 to n.
int count_places(const std::vector<std::string>& header, const char* base) {
  std::vector<int> places;
  const std::string prefix = std::string(base) + "_";
  for (const std::string& column : header) {
    if (column.rfind(prefix, 0) != 0) continue;
    int place = 0;
    const char* begin = column.data() + prefix.size();
    const auto result = std::from_chars(begin, column.data() + column.size(), place);
    if (result.ec == std::errc{} && place > 0) places.push_back(place);
  }
  std::sort(places.begin(), places.end());
  for (std::size_t i = 0; i < places.size(); ++i) {
    if (places[i] != static_cast<int>(i) + 1) return 0;
  }
  return static_cast<int>(places.size());
}

std::string shape_text(int vavs, int fcus, int powers) {
  return std::to_string(vavs) + "vav-" + std::to_string(fcus) + "fcu-" + std::to_string(powers) + "power";
}

class Reader {
 public:
  Reader(std::string_view text, const std::string& name, const TopologyCounts& counts, const LogReadOptions& options)
      : text_(text), name_(name), counts_(counts), options_(options) {}

  Log read() {
    check_text();
    std::string_view line;
    if (text_.rfind("\xEF\xBB\xBF", 0) == 0) text_.remove_prefix(3);
    next_line(line);
    read_header(line);
    while (next_line(line)) {
      if (trimmed(line).empty()) continue;
      read_row(line);
    }
    finish();
    return std::move(log_);
  }

 private:
  std::string place() const { return name_ + ":" + std::to_string(line_); }
  std::string place(std::string_view column) const { return place() + ": " + std::string(column); }

  void check_text() const {
    refuse_foreign_text(text_, name_ + ":1", "a CSV log in UTF-8 text");
    if (text_.find('\0') != std::string_view::npos) {
      throw InputError(name_ + ":1", "bytes that are not text", "a CSV log in UTF-8 text",
                       "export the log as plain CSV, not as a spreadsheet or database file");
    }
    if (text_.find_first_not_of(" \t\r\n") == std::string_view::npos) {
      throw InputError(name_ + ":1", "an empty file", "a header line that starts with `time`",
                       "check that the export finished and that this is the right file");
    }
  }

  bool next_line(std::string_view& line) {
    if (text_.empty()) return false;
    const std::size_t end = text_.find('\n');
    line = text_.substr(0, end);
    text_.remove_prefix(end == std::string_view::npos ? text_.size() : end + 1);
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    ++line_;
    return true;
  }

  void read_header(std::string_view line) {
    split(line, header_);
    for (std::string& column : header_) column = std::string(trimmed(column));
    refuse_other_separator(line, place());
    for (std::size_t i = 0; i < header_.size(); ++i) {
      if (header_[i].empty()) {
        throw InputError(place(), "no name for column " + std::to_string(i + 1), "a name for every column",
                         "name the column or remove it");
      }
      if (!index_.emplace(header_[i], i).second) {
        throw InputError(place(header_[i]), "the column twice", "each column once", "remove one of the two");
      }
    }
    if (!index_.count("time")) {
      throw InputError(place(), "no column `time` in " + in_quotes(line), "a header line that starts with `time`",
                       "name the column of ISO local times `time`, and take out lines above the header");
    }
    time_column_ = index_.at("time");
    used_.assign(header_.size(), false);
    used_[time_column_] = true;
    check_shape();
    for (int i = 0; i < counts_.signals(); ++i) {
      const bool lacks = counts_.stand_in(i).has_value();
      const auto column = find(counts_.signal(i));
      // A site without the sensor takes its stand-in whatever the file has.
      signal_column_.push_back(lacks ? not_read : column ? *column : refuse_missing(counts_.signal(i)));
      log_.stood_in.push_back(lacks || header_[signal_column_.back()].ends_with(stand_in_mark));
    }
    const SignalId setpoint{SignalKind::setpoint, 0};
    const auto found = find(setpoint);
    setpoint_column_ = found ? *found : refuse_missing(setpoint);
    supply_column_ = optional_column("supply_temp_degc", "supply_temp");
    for (const SideColumn& side : counts_.sides) {
      const std::string column = column_of(side);
      side_column_.push_back(optional_column(column, column));
    }
    for (const ControllerColumn& column : controller_columns) {
      controller_column_.push_back(optional_column(column.name, column.name));
      log_.has_controller = log_.has_controller || controller_column_.back().has_value();
    }
    for (std::size_t i = 0; i < header_.size(); ++i) {
      if (!used_[i] && !is_side_column(header_[i])) {
        extra_column_.push_back(i);
        log_.extra_columns.push_back(header_[i]);
      }
    }
  }

  /// A header that is complete for another room shape is another room's log, not a log with missing columns.
  void check_shape() const {
    const int vavs = count_places(header_, "room_temp"), fcus = count_places(header_, "fcu_temp");
    const int powers = count_places(header_, "power");
    const bool fcus_fit = fcus == counts_.fcus || stands_in(SignalKind::fcu_temp);
    const bool powers_fit = powers == counts_.powers || stands_in(SignalKind::power);
    if (vavs == counts_.vavs && fcus_fit && powers_fit) return;
    if (vavs == 0 || vavs != count_places(header_, "vav_on") || fcus != count_places(header_, "fcu_on")) return;
    if (powers == 0 && counts_.powers > 0) return;
    throw InputError(place(), "the columns of a " + shape_text(vavs, fcus, powers) + " room",
                     "those of " + shape_text(counts_.vavs, counts_.fcus, counts_.powers),
                     "give the log of this site, or change topology in [site] of the site file");
  }

  /// Whether the site lacks a sensor of a kind: then columns of it may be missing.
  bool stands_in(SignalKind kind) const {
    for (int i = 0; i < counts_.signals(); ++i) {
      if (counts_.signal(i).kind == kind && counts_.stand_in(i)) return true;
    }
    return false;
  }

  /// The column of a signal, as sensed or as what stood in for it; nothing where there is none.
  std::optional<std::size_t> find(SignalId id) {
    const std::string column = column_of(id);
    std::optional<std::size_t> taken;
    for (const std::string& name : {column + stand_in_mark, column}) {
      const auto found = index_.find(name);
      if (found == index_.end()) continue;
      used_[found->second] = true;
      taken = found->second;
    }
    return taken;
  }

  [[noreturn]] std::size_t refuse_missing(SignalId id) const {
    const std::string column = column_of(id);
    std::string base = text_of(id.kind).name;
    if (id.place > 0) base += "_" + std::to_string(id.place);
    refuse_other_unit(column, base);
    throw InputError(place(column), "no such column", "the column `" + column + "`",
                     "add it, or rename the column that holds it");
  }

  std::optional<std::size_t> optional_column(const std::string& column, const std::string& base) {
    if (const auto found = index_.find(column); found != index_.end()) {
      used_[found->second] = true;
      return found->second;
    }
    if (base != column) refuse_other_unit(column, base);
    return std::nullopt;
  }

  void refuse_other_unit(const std::string& column, const std::string& base) const {
    for (const std::string& other : header_) {
      if (other != base && other.rfind(base + "_", 0) != 0) continue;
      const bool none = other == base;
      const std::string unit = column.size() > base.size() ? column.substr(base.size() + 1) : "0/1, without unit";
      throw InputError(place(other),
                       none ? "a column without unit" : "the unit `" + other.substr(base.size() + 1) + "`",
                       "`" + unit + "` in the column `" + column + "`",
                       none ? "rename the column if its values are in that unit, else convert them first"
                            : "convert the values and rename the column");
    }
  }

  void read_row(std::string_view line) {
    split(line, fields_);
    if (fields_.size() != header_.size()) {
      throw InputError(place(), std::to_string(fields_.size()) + " fields",
                       std::to_string(header_.size()) + " as in the header",
                       text_.empty() ? "the last line looks cut off; remove it"
                                     : "check for decimal commas, a missing field or a cut line");
    }
    LogRow row;
    row.time = read_time();
    row.value.reserve(signal_column_.size());
    for (int i = 0; i < counts_.signals(); ++i) {
      const std::size_t column = signal_column_[static_cast<std::size_t>(i)];
      row.value.push_back(column == not_read ? *counts_.stand_in(i) : read_signal(column, counts_.signal(i).kind));
    }
    row.setpoint_degc = read_signal(setpoint_column_, SignalKind::setpoint);
    if (supply_column_) row.supply_temp_degc = read_optional(*supply_column_);
    for (const auto& column : side_column_) {
      row.side.push_back(column ? read_optional(*column) : ControllerColumns::none);
    }
    for (std::size_t i = 0; i < controller_columns.size(); ++i) {
      if (!controller_column_[i]) continue;
      const ControllerColumn& column = controller_columns[i];
      if (column.number != nullptr)
        row.controller.*column.number = read_optional(*controller_column_[i]);
      else
        row.controller.*column.text = fields_[*controller_column_[i]];
    }
    for (const std::size_t i : extra_column_) row.extra.push_back(fields_[i]);
    check_order(row.time);
    log_.rows.push_back(std::move(row));
    previous_line_ = line_;
  }

  CivilTime read_time() const {
    const std::string_view text = trimmed(fields_[time_column_]);
    const auto time = parse_civil_text(text);
    if (!time) {
      const bool zone = text.size() > 10 && text.find_first_of("Z+", 10) != std::string_view::npos;
      throw InputError(place("time"), text.empty() ? "nothing" : in_quotes(text), "a time such as 2021-07-01T00:06:00",
                       text.empty() ? "take out rows without a time"
                       : zone       ? "write local standard time without a zone"
                                    : "write ISO dates: year-month-day, then T, then hour:minute:second");
    }
    return *time;
  }

  double read_signal(std::size_t column, SignalKind kind) {
    const std::string_view text = trimmed(fields_[column]);
    const auto value = text.empty() ? std::optional(ControllerColumns::none) : parse_number(text);
    if (!value) refuse_number(column, text);
    const LogLimits& limits = options_.limits[static_cast<std::size_t>(kind)];
    if (*value >= limits.min && *value <= limits.max) return *value;
    if (options_.keep_missing) {
      ++log_.summary.missing_values;
      return ControllerColumns::none;
    }
    const std::string expected =
        "a number from " + number_text(limits.min) + " to " + number_text(limits.max) + " " + text_of(kind).unit;
    const bool fahrenheit = expected.ends_with(" degc") && *value > limits.max && *value <= 2 * limits.max + 32;
    throw InputError(place(header_[column]), text.empty() ? "an empty field" : in_quotes(text),
                     std::string(trimmed(expected)),
                     fahrenheit              ? "convert the column if it is in Fahrenheit, else correct the value"
                     : std::isfinite(*value) ? "correct the sensor's value or remove the row"
                                             : "remove the row; gaps between rows are allowed");
  }

  double read_optional(std::size_t column) const {
    const std::string_view text = trimmed(fields_[column]);
    if (text.empty()) return ControllerColumns::none;
    const auto value = parse_number(text);
    if (!value) refuse_number(column, text);
    return *value;
  }

  [[noreturn]] void refuse_number(std::size_t column, std::string_view text) const {
    const bool comma = text.find(',') != std::string_view::npos;
    throw InputError(place(header_[column]), in_quotes(text), "a number such as 25.3",
                     comma ? "write the decimal mark as a point" : "correct the field or leave the row out");
  }

  void check_order(CivilTime time) {
    if (time.second_of_day() % row_s != 0) {
      std::string found = civil_text(time);
      if (!log_.rows.empty()) {
        const std::int64_t spacing = time.seconds - log_.rows.back().time.seconds;
        found += ", " + std::to_string(spacing) + " s after line " + std::to_string(previous_line_);
      }
      throw InputError(place("time"), found, "rows at every 6 min, counted from midnight",
                       "resample the log to 00:00, 00:06, 00:12 ...");
    }
    if (log_.rows.empty()) return;
    const CivilTime last = log_.rows.back().time;
    if (time == last) {
      throw InputError(place("time"), civil_text(time) + ", the same as line " + std::to_string(previous_line_),
                       "each time once", "remove one of the two rows");
    }
    if (time < last) {
      throw InputError(
          place("time"),
          civil_text(time) + ", earlier than " + civil_text(last) + " of line " + std::to_string(previous_line_),
          "times that grow from row to row",
          "sort the rows; log in standard time so that no hour comes twice in autumn");
    }
    const std::int64_t missing = (time.seconds - last.seconds) / row_s - 1;
    if (missing == 0) {
      ++neighbours_;
    } else {
      log_.summary.missing_rows += static_cast<std::size_t>(missing);
      log_.summary.gaps.push_back({last, time, line_});
    }
  }

  void finish() {
    if (log_.rows.empty()) {
      throw InputError(place(), "a header without rows", "at least one row",
                       "check that the export finished and covers the days that you want");
    }
    if (neighbours_ == 0 && log_.rows.size() >= 3) {
      const std::int64_t spacing = log_.rows[1].time.seconds - log_.rows[0].time.seconds;
      throw InputError(name_ + ": time", "rows every " + number_text(static_cast<double>(spacing) / 60) + " min",
                       "rows every 6 min", "export the log with a 6-min interval");
    }
    log_.summary.rows = log_.rows.size();
    log_.summary.first = log_.rows.front().time;
    log_.summary.last = log_.rows.back().time;
  }

  static constexpr std::size_t not_read = std::numeric_limits<std::size_t>::max();

  std::string_view text_;
  const std::string& name_;
  const TopologyCounts& counts_;
  const LogReadOptions& options_;
  Log log_;
  int line_ = 0, previous_line_ = 0;
  std::size_t neighbours_ = 0;
  std::vector<std::string> header_, fields_;
  std::map<std::string, std::size_t, std::less<>> index_;
  std::vector<bool> used_;
  std::size_t time_column_ = 0, setpoint_column_ = 0;
  std::optional<std::size_t> supply_column_;
  std::vector<std::size_t> signal_column_, extra_column_;
  std::vector<std::optional<std::size_t>> side_column_, controller_column_;
};

}  // namespace

Log read_log_text(std::string_view text, const std::string& name, const TopologyCounts& counts,
                  const LogReadOptions& options) {
  return Reader(text, name, counts, options).read();
}

}  // namespace airside::hal
