#include "tools/gap/map/mapped_log.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"
#include "tools/gap/map/mapped_table.hpp"

namespace airside::tools::gap {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// One column of the log on the grid of 6 min.
class Regrid {
 public:
  Regrid(const std::vector<CivilTime>& time, const MappedLog& log, CivilTime from, std::size_t rows)
      : time_(time),
        step_s_(60LL * log.step_min),
        end_after_s_(log.stamped_at_end ? 0 : step_s_),
        from_(from),
        rows_(rows) {}

  /// Of an instant: between its neighbours, or the mean of those about it where rows are denser.
  std::vector<double> instants(const std::vector<double>& values) const {
    std::vector<double> grid(rows_, unknown);
    std::size_t next = 0;
    for (std::size_t i = 0; i < rows_; ++i) {
      const std::int64_t t = time_of(i);
      double sum = 0;
      int count = 0;
      const auto first = std::lower_bound(time_.begin(), time_.end(), CivilTime{t - row_s / 2 + 1});
      for (auto row = first; row != time_.end() && row->seconds <= t + row_s / 2; ++row) {
        const double value = values[static_cast<std::size_t>(row - time_.begin())];
        if (std::isfinite(value)) sum += value, ++count;
      }
      if (count > 0 && step_s_ <= row_s) {
        grid[i] = sum / count;
        continue;
      }
      while (next < time_.size() && (time_[next].seconds < t || std::isnan(values[next]))) ++next;
      if (next == time_.size()) break;
      grid[i] = between_known(values, next, t);
    }
    return grid;
  }

  /// Of means over a row's step: by the time that they share with each 6 min.
  std::vector<double> means(const std::vector<double>& values) const {
    std::vector<double> sum(rows_, 0), shared(rows_, 0);
    for (std::size_t row = 0; row < time_.size(); ++row) {
      if (!std::isfinite(values[row])) continue;
      const std::int64_t end = time_[row].seconds + end_after_s_, begin = end - length_of(row);
      // Grid row i shows the 6 min that end at its time.
      auto i = static_cast<std::int64_t>(std::max<std::int64_t>(0, (begin - from_.seconds) / row_s));
      for (; i < static_cast<std::int64_t>(rows_); ++i) {
        const std::int64_t t = time_of(static_cast<std::size_t>(i));
        if (t - row_s >= end) break;
        const auto overlap = static_cast<double>(std::min(t, end) - std::max(t - row_s, begin));
        if (overlap <= 0) continue;
        sum[static_cast<std::size_t>(i)] += overlap * values[row];
        shared[static_cast<std::size_t>(i)] += overlap;
      }
    }
    for (std::size_t i = 0; i < rows_; ++i) sum[i] = shared[i] >= 0.5 * row_s ? sum[i] / shared[i] : unknown;
    return sum;
  }

  /// As it was last given.
  std::vector<double> held(const std::vector<double>& values) const {
    std::vector<double> grid(rows_, unknown);
    std::size_t next = 0;
    double last = unknown;
    std::int64_t since = 0;
    for (std::size_t i = 0; i < rows_; ++i) {
      for (; next < time_.size() && time_[next].seconds <= time_of(i); ++next) {
        if (std::isfinite(values[next])) last = values[next], since = time_[next].seconds;
      }
      if (time_of(i) - since < reach_s()) grid[i] = last;
    }
    return grid;
  }

 private:
  std::int64_t time_of(std::size_t i) const { return from_.seconds + static_cast<std::int64_t>(i) * row_s; }
  std::int64_t reach_s() const { return std::max<std::int64_t>(row_s, step_s_ * 3 / 2); }
  /// Rows denser than the step share its time.
  std::int64_t length_of(std::size_t row) const {
    return row == 0 ? step_s_ : std::min(step_s_, time_[row].seconds - time_[row - 1].seconds);
  }

  double between_known(const std::vector<double>& values, std::size_t next, std::int64_t t) const {
    if (time_[next].seconds == t) return values[next];
    std::size_t before = next;
    while (before > 0 && std::isnan(values[before - 1])) --before;
    if (before == 0) return unknown;
    --before;
    const std::int64_t a = time_[before].seconds, b = time_[next].seconds;
    if (b - a > reach_s()) return unknown;
    const double share = static_cast<double>(t - a) / static_cast<double>(b - a);
    return values[before] + share * (values[next] - values[before]);
  }

  const std::vector<CivilTime>& time_;
  std::int64_t step_s_, end_after_s_;
  CivilTime from_;
  std::size_t rows_;
};

/// degC, kW or a fraction of what the log has.
std::vector<double> in_units(const std::vector<double>& values, const std::vector<CivilTime>& time,
                             const MappedChannel& c, int step_min) {
  std::vector<double> out = values;
  if (c.counter) {
    for (std::size_t i = 0; i < out.size(); ++i) {
      const bool next = i > 0 && time[i].seconds - time[i - 1].seconds <= 90LL * step_min;
      const double rise = next ? values[i] - values[i - 1] : unknown;
      out[i] = rise >= 0 ? rise : unknown;  // a counter that was set back
    }
  }
  const double per_hour = c.unit.energy ? 60.0 / step_min : 1;
  for (double& x : out) x = (x * c.unit.factor + c.unit.offset) * per_hour;
  return out;
}

/// Where a channel's values go in a row of the log.
double* slot_of(hal::LogRow& row, const Mapping& m, const MappedChannel& c, std::size_t side) {
  const std::size_t zones = m.zones.size(), powers = m.of(MappedKind::power).size(), mau = 2 * zones + powers;
  switch (c.kind) {
    case MappedKind::room_temperature: return &row.value[m.place_of(c)];
    case MappedKind::power: return &row.value[2 * zones + m.place_of(c)];
    case MappedKind::preheated_temperature: return &row.value[mau];
    case MappedKind::outdoor_temperature: return &row.value[mau + 1];
    case MappedKind::supply_temperature: return &row.supply_temp_degc;
    case MappedKind::damper: return &row.side[side];
  }
  return nullptr;
}

std::string usual_column(const Mapping& m, const hal::TopologyCounts& counts, const MappedChannel& c) {
  const int zones = counts.vavs, mau = 2 * zones + counts.powers;
  const int place = static_cast<int>(m.place_of(c));
  switch (c.kind) {
    case MappedKind::room_temperature: return hal::column_of(counts.signal(place));
    case MappedKind::power: return hal::column_of(counts.signal(2 * zones + place));
    case MappedKind::preheated_temperature: return hal::column_of(counts.signal(mau));
    case MappedKind::outdoor_temperature: return hal::column_of(counts.signal(mau + 1));
    default: return "supply_temp_degc";
  }
}

/// Rows in which nothing at all is known are no rows.
bool is_empty(const hal::LogRow& row, const hal::TopologyCounts& counts) {
  const auto known = [](double x) { return std::isfinite(x); };
  for (int i = 0; i < counts.signals(); ++i) {
    if (!counts.stand_in(i) && known(row.value[static_cast<std::size_t>(i)])) return false;
  }
  return !known(row.supply_temp_degc) && std::none_of(row.side.begin(), row.side.end(), known);
}

std::vector<hal::LogRow> rows_of(const MappedTable& table, const Mapping& m, const hal::TopologyCounts& counts) {
  const std::int64_t first_s = table.time.front().seconds - 60LL * m.log.step_min;
  const CivilTime from{(first_s + row_s - 1) / row_s * row_s};
  const auto count = static_cast<std::size_t>((table.time.back().seconds - from.seconds) / row_s + 1);
  const auto further = m.further_commands();
  hal::LogRow blank;
  blank.value.assign(static_cast<std::size_t>(counts.signals()), unknown);
  for (int i = 0; i < counts.signals(); ++i)
    blank.value[static_cast<std::size_t>(i)] = counts.stand_in(i).value_or(unknown);
  blank.side.assign(counts.sides.size() + further.size(), unknown);
  std::vector<hal::LogRow> rows(count, blank);
  for (std::size_t i = 0; i < count; ++i) rows[i].time = {from.seconds + static_cast<std::int64_t>(i) * row_s};
  const Regrid regrid(table.time, m.log, from, count);
  std::size_t side = 0;
  for (std::size_t c = 0; c < m.channels.size(); ++c) {
    const MappedChannel& channel = m.channels[c];
    const auto values = in_units(table.channels[c], table.time, channel, m.log.step_min);
    const auto grid = channel.mean ? regrid.means(values) : regrid.instants(values);
    for (std::size_t i = 0; i < count; ++i) *slot_of(rows[i], m, channel, side) = grid[i];
    if (channel.kind == MappedKind::damper) ++side;
  }
  for (std::size_t c = 0; c < m.commands.size(); ++c) {
    const MappedCommand& command = m.commands[c];
    const auto grid = regrid.held(table.commands[c]);
    for (std::size_t i = 0; i < count; ++i) {
      const double x = grid[i] * command.unit.factor + command.unit.offset;
      (command.supply_setpoint ? rows[i].setpoint_degc : rows[i].side[side]) = x;
    }
    if (!command.supply_setpoint) ++side;
  }
  std::erase_if(rows, [&counts](const hal::LogRow& row) { return is_empty(row, counts); });
  return rows;
}

}  // namespace

CleanLog read_mapped_texts(const std::vector<std::string>& texts, const Mapping& mapping,
                           const CleanUpContext& context) {
  if (context.station == nullptr) throw hal::InputError(context.place, "no station", "its clock", "give the weather");
  MappedTable table = read_mapped_table(texts, mapping, context.station->location().utc_offset_h, context.place);
  CleanUpContext partial = context;
  partial.partial = true;
  partial.largest_zone_kw = std::numeric_limits<double>::infinity();
  CleanLog log = clean_up(rows_of(table, mapping, context.counts), partial);
  for (Remark& remark : log.remarks) {
    for (const MappedChannel& c : mapping.channels) {
      if (remark.column != usual_column(mapping, context.counts, c)) continue;
      remark.column = c.column;
      break;
    }
  }
  log.remarks.insert(log.remarks.begin(), table.remarks.begin(), table.remarks.end());
  return log;
}

CleanLog read_mapped_log(const std::string& path, const Mapping& mapping, const CleanUpContext& context) {
  namespace fs = std::filesystem;
  std::vector<std::string> files{path}, texts;
  std::error_code ignored;
  if (fs::is_directory(path, ignored)) {
    files.clear();
    for (const auto& entry : fs::directory_iterator(path)) {
      if (entry.path().extension() == ".csv") files.push_back(entry.path().string());
    }
    std::sort(files.begin(), files.end());
  }
  for (const std::string& file : files) texts.push_back(hal::read_text_file(file, "a log in CSV"));
  if (texts.empty()) throw hal::InputError(path, "a folder without *.csv", "log files", "give the log's own folder");
  return read_mapped_texts(texts, mapping, context);
}

}  // namespace airside::tools::gap
