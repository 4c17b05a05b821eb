#include "tools/gap/map/mapped_table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <ctime>
#include <limits>
#include <numeric>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/toml_section.hpp"

namespace airside::tools::gap {

namespace {

constexpr double not_there = std::numeric_limits<double>::quiet_NaN();

std::string_view without_blanks(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// Fields of a line without their quotes; separators within quotes do not divide.
std::vector<std::string> cells_of(std::string_view line, char separator) {
  std::vector<std::string> cells(1);
  bool quoted = false;
  for (const char c : line) {
    if (c == '"')
      quoted = !quoted;
    else if (c == separator && !quoted)
      cells.emplace_back();
    else
      cells.back() += c;
  }
  for (std::string& cell : cells) cell = std::string(without_blanks(cell));
  return cells;
}

double number_in(std::string cell, bool decimal_comma) {
  if (decimal_comma) std::replace(cell.begin(), cell.end(), ',', '.');
  if (!cell.empty() && cell.front() == '+') cell.erase(0, 1);
  double value = 0;
  const auto end = cell.data() + cell.size();
  const auto result = std::from_chars(cell.data(), end, value);
  return result.ec == std::errc{} && result.ptr == end ? value : not_there;
}

/// "Z", "+02:00" or "-0600" at a text's end, taken off it; h east of UTC.
std::optional<double> taken_offset(std::string& text) {
  if (text.ends_with('Z')) {
    text.pop_back();
    return 0;
  }
  constexpr std::size_t date_end = 10;
  const auto sign = text.find_last_of("+-");
  if (sign == std::string::npos || sign <= date_end) return std::nullopt;
  std::string digits = text.substr(sign + 1);
  std::erase(digits, ':');
  int value = 0;
  const auto end = digits.data() + digits.size();
  if (digits.size() != 4 || std::from_chars(digits.data(), end, value).ptr != end) return std::nullopt;
  const int whole_h = value / 100;
  const double hours = whole_h + value % 100 / 60.0;
  const double offset = text[sign] == '-' ? -hours : hours;
  text.resize(sign);
  return offset;
}

struct WrittenTime {
  CivilTime time;
  std::optional<double> offset_h;  ///< that stands beside it
};

std::optional<WrittenTime> written_time(std::string field, const std::string& format) {
  if (format == "unix") {
    const double seconds = number_in(field, false);
    if (!std::isfinite(seconds)) return std::nullopt;
    return WrittenTime{{std::llround(seconds)}, 0.0};
  }
  if (format == "iso") {
    const auto offset = taken_offset(field);
    if (const auto dot = field.find('.'); dot != std::string::npos) field.resize(dot);
    const auto time = hal::parse_civil_text(without_blanks(field));
    if (!time) return std::nullopt;
    return WrittenTime{*time, offset};
  }
  std::tm parts{};
  parts.tm_mday = 1;
  const char* rest = strptime(field.c_str(), format.c_str(), &parts);
  if (rest == nullptr || *rest != '\0') return std::nullopt;
  return WrittenTime{hal::civil_time({parts.tm_year + 1900, parts.tm_mon + 1, parts.tm_mday, parts.tm_hour,
                                      parts.tm_min, parts.tm_sec}),
                     std::nullopt};
}

/// From a wall clock's time to standard time of the same place.
CivilTime standard_time(CivilTime wall, DaylightSaving rule, double zone_h, std::optional<CivilTime> before) {
  if (rule == DaylightSaving::none) return wall;
  const CivilTime summer{wall.seconds - seconds_per_hour};
  const bool can_be_summer = local_time(rule, zone_h, summer) == wall;
  const bool can_be_winter = local_time(rule, zone_h, wall) == wall;
  const bool passed = before && can_be_winter && summer <= *before;
  return can_be_summer && !passed ? summer : wall;
}

class TableReader {
 public:
  TableReader(const Mapping& mapping, double zone_h, const std::string& place)
      : mapping_(mapping), zone_h_(zone_h), place_(place) {
    table_.channels.resize(mapping.channels.size());
    table_.commands.resize(mapping.commands.size());
  }

  void read(std::string_view text) {
    if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
    int line_number = 0;
    bool header = true;
    while (!text.empty()) {
      const auto end = std::min(text.find('\n'), text.size());
      const std::string_view line = text.substr(0, end);
      text.remove_prefix(std::min(end + 1, text.size()));
      ++line_number;
      if (without_blanks(line).empty() || line.front() == '#') continue;
      if (header)
        take_header(cells_of(line, mapping_.log.separator), line_number);
      else
        take_line(cells_of(line, mapping_.log.separator), line_number);
      header = false;
    }
  }

  MappedTable table() {
    if (table_.time.empty()) {
      throw hal::InputError(
          fmt::format("{}:{}", place_, std::max(1, first_unread_)),
          unread_ > 0 ? "`" + unread_text_ + "` as a time" : "no row",
          "times in the format \"" + mapping_.log.format + "\" in the column \"" + mapping_.log.time + "\"",
          "correct time or format in [log] of " + mapping_.path);
    }
    sort();
    say();
    return std::move(table_);
  }

 private:
  void take_header(const std::vector<std::string>& names, int line) {
    const auto at = [&](const std::string& column, const std::string& asked) {
      const auto found = std::find(names.begin(), names.end(), column);
      if (found != names.end()) return static_cast<std::size_t>(found - names.begin());
      constexpr std::size_t most_near = 5;
      const auto near = hal::near_names(column, names, most_near);
      throw hal::InputError(fmt::format("{}:{}", place_, line),
                            "no column \"" + column + "\"" +
                                (near.empty() ? "" : fmt::format("; near it: \"{}\"", fmt::join(near, "\", \""))),
                            "the column that " + asked + " names",
                            names.size() == 1 ? "is the separator right? See [log] of " + mapping_.path
                                              : "correct the name in the mapping, or the log's header");
    };
    width_ = names.size();
    time_ = at(mapping_.log.time, mapping_.path + ": log.time");
    at_.clear();
    for (const MappedChannel& c : mapping_.channels) at_.push_back(at(c.column, c.place));
    for (const MappedCommand& c : mapping_.commands) at_.push_back(at(c.column, c.place));
  }

  void take_line(const std::vector<std::string>& cells, int line) {
    std::optional<CivilTime> time;
    if (cells.size() == width_) time = mapped_time(cells[time_], mapping_.log, zone_h_, last_);
    if (!time) {
      if (unread_++ == 0) {
        first_unread_ = line;
        unread_text_ = cells[std::min(time_, cells.size() - 1)].substr(0, 40);
      }
      return;
    }
    last_ = time;
    table_.time.push_back(*time);
    const std::size_t channels = table_.channels.size();
    for (std::size_t i = 0; i < at_.size(); ++i) {
      const std::string& cell = cells[at_[i]];
      const double value = number_in(cell, mapping_.log.decimal_comma);
      if (!cell.empty() && std::isnan(value) && words_++ == 0) {
        first_word_ = line;
        word_ = cell.substr(0, 20);
      }
      (i < channels ? table_.channels[i] : table_.commands[i - channels]).push_back(value);
    }
  }

  /// By time, the last of equal ones.
  void sort() {
    std::vector<std::size_t> order(table_.time.size()), kept;
    std::iota(order.begin(), order.end(), 0U);
    std::stable_sort(order.begin(), order.end(),
                     [this](std::size_t a, std::size_t b) { return table_.time[a] < table_.time[b]; });
    for (const std::size_t row : order) {
      if (!kept.empty() && table_.time[kept.back()] == table_.time[row]) kept.pop_back(), ++repeated_;
      kept.push_back(row);
    }
    const auto reordered = [&kept](auto& list) {
      auto before = std::move(list);
      list.clear();
      for (const std::size_t row : kept) list.push_back(before[row]);
    };
    reordered(table_.time);
    for (auto& column : table_.channels) reordered(column);
    for (auto& column : table_.commands) reordered(column);
  }

  void say() {
    const auto remark = [this](Defect defect, std::size_t count, std::string text) {
      if (count == 0) return;
      table_.remarks.push_back(
          {defect, Action::left_out, "", table_.time.front(), table_.time.back(), count, std::move(text), "", ""});
    };
    remark(Defect::unreadable, unread_,
           fmt::format("{} lines of {} without a time of the format, or of another number of fields than the header, "
                       "first line {} with `{}`; left out",
                       unread_, place_, first_unread_, unread_text_));
    remark(Defect::unreadable, words_,
           fmt::format("{} fields of {} that are no numbers, first `{}` in line {}; left out", words_, place_, word_,
                       first_word_));
    remark(Defect::duplicate, repeated_,
           fmt::format("{} rows of {} with the time of another; the last one counts", repeated_, place_));
    if (table_.remarks.empty() || unread_ <= table_.time.size()) return;
    table_.remarks.front().action = Action::refused;
    table_.remarks.front().expected = "times in the format \"" + mapping_.log.format + "\"";
    table_.remarks.front().remedy = "correct format in [log] of " + mapping_.path;
  }

  const Mapping& mapping_;
  double zone_h_;
  const std::string& place_;
  MappedTable table_;
  std::vector<std::size_t> at_;
  std::size_t width_ = 0, time_ = 0, unread_ = 0, words_ = 0, repeated_ = 0;
  int first_unread_ = 0, first_word_ = 0;
  std::string unread_text_, word_;
  std::optional<CivilTime> last_;
};

}  // namespace

std::optional<CivilTime> mapped_time(const std::string& field, const MappedLog& log, double zone_h,
                                     std::optional<CivilTime> before) {
  const auto written = written_time(field, log.format);
  if (!written) return std::nullopt;
  const double offset_h = written->offset_h ? *written->offset_h : log.utc_offset_h.value_or(zone_h);
  CivilTime time = written->time;
  const auto moved_s = std::llround((zone_h - offset_h) * static_cast<double>(seconds_per_hour));
  if (!written->offset_h) {
    if (before) before->seconds -= moved_s;
    time = standard_time(time, log.daylight_saving, offset_h, before);
  }
  return CivilTime{time.seconds + moved_s};
}

MappedTable read_mapped_table(const std::vector<std::string>& texts, const Mapping& mapping, double zone_h,
                              const std::string& place) {
  TableReader reader(mapping, zone_h, place);
  for (const std::string& text : texts) reader.read(text);
  return reader.table();
}

}  // namespace airside::tools::gap
