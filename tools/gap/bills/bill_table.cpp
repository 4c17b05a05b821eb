#include "tools/gap/bills/bill_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"

namespace airside::tools::gap {

namespace {

std::vector<std::string> fields_of(std::string_view line) {
  std::vector<std::string> fields;
  while (true) {
    const std::size_t end = line.find(',');
    std::string_view field = line.substr(0, end);
    while (!field.empty() && (field.front() == ' ' || field.front() == '\t')) field.remove_prefix(1);
    while (!field.empty() && (field.back() == ' ' || field.back() == '\t' || field.back() == '\r'))
      field.remove_suffix(1);
    fields.emplace_back(field);
    if (end == std::string_view::npos) return fields;
    line.remove_prefix(end + 1);
  }
}

/// The table while its lines are read.
class BillReader {
 public:
  BillReader(std::string path, std::span<const std::string> meters) : path_(std::move(path)) {
    table_.place = path_;
    known_.assign(meters.begin(), meters.end());
  }

  void take(std::string_view line) {
    ++line_;
    const std::vector<std::string> fields = fields_of(line);
    if (fields.size() == 1 && fields.front().empty()) return;
    if (columns_.empty())
      take_header(fields);
    else
      take_row(fields);
  }

  BillTable finish() {
    const auto columns = static_cast<Eigen::Index>(table_.meters.size());
    table_.kwh.resize(static_cast<Eigen::Index>(rows_.size()), columns);
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      for (Eigen::Index m = 0; m < columns; ++m)
        table_.kwh(static_cast<Eigen::Index>(i), m) = rows_[i][static_cast<std::size_t>(m)];
    }
    if (!table_.kwh.array().isFinite().any())
      throw hal::InputError(path_, "no bill", "a header and a line a period, `from,to,METER,...`", "add the bills");
    return std::move(table_);
  }

 private:
  [[noreturn]] void refuse(const std::string& column, const std::string& found, const std::string& expected,
                           const std::string& remedy) const {
    throw hal::InputError(fmt::format("{}:{}: {}", path_, line_, column), found, expected, remedy);
  }

  void take_header(const std::vector<std::string>& names) {
    const auto column = [&](const std::string& name) {
      const auto at = std::find(names.begin(), names.end(), name);
      if (at != names.end()) columns_.push_back(static_cast<std::size_t>(at - names.begin()));
      return at != names.end();
    };
    const std::string found = fmt::format("the columns {}", fmt::join(names, ", "));
    for (const char* name : {"from", "to"}) {
      if (!column(name))
        refuse("header", found, fmt::format("a column {}", name), "add the first and the last day of each bill");
    }
    for (const std::string& meter : known_) {
      if (column(meter)) table_.meters.push_back(meter);
    }
    if (table_.meters.empty()) {
      refuse("header", found, fmt::format("a column of a meter: {}", fmt::join(known_, ", ")),
             "name the columns as the mapping file does");
    }
  }

  CivilTime date(const std::vector<std::string>& fields, std::size_t column, const char* name) const {
    const std::string& text = fields[columns_[column]];
    const auto time = hal::parse_civil_text(text + "T00:00");
    if (!time || text.size() != hal::date_text_size)
      refuse(name, text.empty() ? "nothing" : text, "a date such as 2021-07-01", "write year, month and day");
    return *time;
  }

  double number(const std::string& text, const std::string& meter) const {
    if (text.empty()) return std::numeric_limits<double>::quiet_NaN();
    double value = 0;
    const auto [end, fault] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (fault != std::errc{} || end != text.data() + text.size() || !std::isfinite(value) || value < 0)
      refuse(meter, text, "energy in kWh, 0 or more", "write a number with a point, or leave it empty for no bill");
    return value;
  }

  void take_row(const std::vector<std::string>& fields) {
    if (fields.size() <= *std::max_element(columns_.begin(), columns_.end()))
      refuse("line", fmt::format("{} fields", fields.size()), "one for each column of the header",
             "add what is missing");
    BillPeriod period{date(fields, 0, "from"), date(fields, 1, "to")};
    period.to.seconds += seconds_per_day;
    const std::string shown = fields[columns_[0]] + " to " + fields[columns_[1]];
    if (!(period.from < period.to))
      refuse("to", shown, "a last day that is not before the first", "exchange the dates");
    if (hal::civil_date(period.from).year != hal::civil_date({period.to.seconds - 1}).year)
      refuse("to", shown, "a period within one calendar year", "divide the bill at New Year by its days");
    if (!table_.periods.empty() && period.from < table_.periods.back().to) {
      refuse(
          "from", shown,
          "a first day after " + hal::civil_text({table_.periods.back().to.seconds - 1}).substr(0, hal::date_text_size),
          "order the lines by date; the last day is part of a bill");
    }
    table_.periods.push_back(period);
    std::vector<double> row;
    for (std::size_t m = 0; m < table_.meters.size(); ++m)
      row.push_back(number(fields[columns_[2 + m]], table_.meters[m]));
    rows_.push_back(std::move(row));
  }

  std::string path_;
  int line_ = 0;
  std::vector<std::string> known_;
  std::vector<std::size_t> columns_;
  std::vector<std::vector<double>> rows_;
  BillTable table_;
};

}  // namespace

BillTable parse_bills(std::string_view text, const std::string& path, std::span<const std::string> meters) {
  BillReader reader(path, meters);
  for (std::size_t from = 0; from < text.size();) {
    const std::size_t end = std::min(text.find('\n', from), text.size());
    reader.take(text.substr(from, end - from));
    from = end + 1;
  }
  return reader.finish();
}

BillTable read_bills(const std::string& path, std::span<const std::string> meters) {
  return parse_bills(hal::read_text_file(path, "bills as CSV"), path, meters);
}

}  // namespace airside::tools::gap
