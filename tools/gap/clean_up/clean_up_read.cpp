// Reading of logs that the strict reader refuses. Lines are made harmless (times counted up, fields that are no
// numbers emptied), read by hal's own reader, and given their own times back: one understanding of columns.
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <iterator>
#include <limits>
#include <set>

#include "hal/log/log_columns.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"
#include "tools/gap/clean_up/clean_up_table.hpp"

namespace airside::tools::gap {

namespace {

constexpr double infinity = std::numeric_limits<double>::infinity();

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// Fields of a line with their quotes; commas within quotes do not divide.
std::vector<std::string_view> fields_of(std::string_view line) {
  std::vector<std::string_view> fields;
  std::size_t begin = 0;
  bool quoted = false;
  for (std::size_t i = 0; i <= line.size(); ++i) {
    if (i < line.size() && line[i] == '"') quoted = !quoted;
    if (i < line.size() && (line[i] != ',' || quoted)) continue;
    fields.push_back(line.substr(begin, i - begin));
    begin = i + 1;
  }
  return fields;
}

std::string_view unquoted(std::string_view field) {
  field = trimmed(field);
  if (field.size() >= 2 && field.front() == '"' && field.back() == '"') field = field.substr(1, field.size() - 2);
  return trimmed(field);
}

bool is_number(std::string_view text) {
  if (!text.empty() && text.front() == '+') text.remove_prefix(1);
  double value = 0;
  const auto result = std::from_chars(text.data(), text.data() + text.size(), value);
  return result.ec == std::errc{} && result.ptr == text.data() + text.size();
}

/// Names of columns that hold numbers.
std::set<std::string, std::less<>> number_columns(const hal::TopologyCounts& counts) {
  std::set<std::string, std::less<>> names{"supply_temp_degc", hal::column_of({SignalKind::setpoint, 0})};
  for (int i = 0; i < counts.signals(); ++i) names.insert(hal::column_of(counts.signal(i)));
  for (const hal::ControllerColumn& c : hal::controller_columns) {
    if (c.number != nullptr) names.insert(c.name);
  }
  return names;
}

class DirtyReader {
 public:
  DirtyReader(std::string_view text, const std::string& name, const CleanUpContext& context)
      : text_(text), name_(name), context_(context), numbers_(number_columns(context.counts)) {}

  std::vector<hal::LogRow> read(std::vector<Remark>& remarks) {
    const std::string_view all = text_;
    if (text_.rfind("\xEF\xBB\xBF", 0) == 0) text_.remove_prefix(3);
    take_header(next_line());
    while (!text_.empty()) {
      const std::string_view line = next_line();
      if (!trimmed(line).empty()) take_row(line);
    }
    hal::LogReadOptions any;
    any.keep_missing = true;
    any.limits.fill({-infinity, infinity});
    // Without a single row there is nothing to be lenient about: the strict reader says why.
    if (times_.empty()) hal::read_log_text(all, name_, context_.counts);
    hal::Log log = hal::read_log_text(harmless_, name_, context_.counts, any);
    for (std::size_t i = 0; i < log.rows.size(); ++i) log.rows[i].time = times_[i];
    say(remarks);
    return std::move(log.rows);
  }

 private:
  std::string_view next_line() {
    const std::size_t end = text_.find('\n');
    const std::string_view line = text_.substr(0, end);
    text_.remove_prefix(end == std::string_view::npos ? text_.size() : end + 1);
    ++line_;
    return !line.empty() && line.back() == '\r' ? line.substr(0, line.size() - 1) : line;
  }

  void take_header(std::string_view line) {
    for (const std::string_view field : fields_of(line)) header_.emplace_back(unquoted(field));
    harmless_ = std::string(line) + "\n";
    const auto time = std::find(header_.begin(), header_.end(), "time");
    time_column_ = static_cast<std::size_t>(time - header_.begin());  // hal's reader complains where there is none
  }

  void take_row(std::string_view line) {
    const auto fields = fields_of(line);
    const bool whole = fields.size() == header_.size() && time_column_ < fields.size();
    const auto time = whole ? hal::parse_civil_text(unquoted(fields[time_column_])) : std::nullopt;
    if (!time) {
      if (cut_++ == 0) first_cut_ = line_;
      return;
    }
    for (std::size_t i = 0; i < fields.size(); ++i) {
      if (i > 0) harmless_ += ',';
      if (i == time_column_) {
        harmless_ += hal::civil_text({static_cast<std::int64_t>(times_.size()) * row_s});
      } else if (const auto text = unquoted(fields[i]);
                 numbers_.count(header_[i]) > 0 && !text.empty() && !is_number(text)) {
        if (words_++ == 0) first_word_ = line_, word_ = std::string(text.substr(0, 20));
      } else {
        harmless_ += fields[i];
      }
    }
    harmless_ += '\n';
    times_.push_back(*time);
  }

  void say(std::vector<Remark>& remarks) const {
    const auto [first, last] = std::minmax_element(times_.begin(), times_.end());
    Remark remark{Defect::unreadable, Action::left_out, "", *first, *last, cut_, "", "", ""};
    if (cut_ > 0) {
      remark.text = fmt::format(
          "{} line{} of {} without a time or of another number of fields than the header, first "
          "line {}; left out",
          cut_, cut_ == 1 ? "" : "s", name_, first_cut_);
      if (cut_ > times_.size()) {
        remark.action = Action::refused;
        remark.expected = "rows such as 2021-07-01T00:06:00,25.3,...";
        remark.remedy = "write ISO times without a zone, points as decimal marks, and as many fields as the header";
      }
      remarks.push_back(remark);
    }
    if (words_ > 0) {
      remarks.push_back({Defect::unreadable, Action::left_out, "", *first, *last, words_,
                         fmt::format("{} field{} of {} that are no numbers, first `{}` in line {}; left out", words_,
                                     words_ == 1 ? "" : "s", name_, word_, first_word_),
                         "", ""});
    }
  }

  std::string_view text_;
  const std::string& name_;
  const CleanUpContext& context_;
  std::set<std::string, std::less<>> numbers_;
  std::vector<std::string> header_;
  std::string harmless_, word_;
  std::vector<CivilTime> times_;
  std::size_t time_column_ = 0, cut_ = 0, words_ = 0;
  int line_ = 0, first_cut_ = 0, first_word_ = 0;
};

CleanLog cleaned(std::vector<hal::LogRow> rows, const CleanUpContext& context, std::vector<Remark> remarks) {
  CleanLog log = clean_up(std::move(rows), context);
  log.remarks.insert(log.remarks.begin(), remarks.begin(), remarks.end());
  return log;
}

}  // namespace

CleanLog read_dirty_log_text(std::string_view text, const CleanUpContext& context) {
  std::vector<Remark> remarks;
  std::vector<hal::LogRow> rows = DirtyReader(text, context.place, context).read(remarks);
  return cleaned(std::move(rows), context, std::move(remarks));
}

CleanLog read_dirty_log(const std::string& path, const CleanUpContext& context) {
  namespace fs = std::filesystem;
  std::error_code ignored;
  std::vector<std::string> files{path};
  if (fs::is_directory(path, ignored)) {
    files.clear();
    for (const fs::directory_entry& entry : fs::directory_iterator(path)) {
      if (entry.path().extension() == ".csv") files.push_back(entry.path().string());
    }
    std::sort(files.begin(), files.end());
    if (files.empty()) {
      throw hal::InputError(path, "a directory without *.csv", "log files",
                            "give the directory that the daemon logs to");
    }
  }
  std::vector<hal::LogRow> rows;
  std::vector<Remark> remarks;
  for (const std::string& file : files) {
    const std::string text = hal::read_text_file(file, "a CSV log");
    auto part = DirtyReader(text, file, context).read(remarks);
    std::move(part.begin(), part.end(), std::back_inserter(rows));
  }
  return cleaned(std::move(rows), context, std::move(remarks));
}

}  // namespace airside::tools::gap
