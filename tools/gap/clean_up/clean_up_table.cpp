#include "tools/gap/clean_up/clean_up_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "hal/text/input_error.hpp"

namespace airside::tools::gap {

namespace {

// Medians of two weeks of an occupied building in any climate; Fahrenheit, kelvin and tenths lie outside.
constexpr std::array<RoleFacts, 10> role_facts{{
    {true, true, false, 10, 38, 2},    // room
    {true, true, false, 10, 38, 2},    // fcu
    {false, false, true, 0, 1, 0},     // vav_on
    {false, false, true, 0, 1, 0},     // fcu_on
    {false, false, false, 0, 0, 1},    // power
    {true, false, false, 3, 38, 3},    // mau
    {true, false, false, -45, 48, 3},  // outdoor
    {false, false, true, 0, 1, 0},     // rain
    {true, false, false, 8, 34, 0},    // setpoint
    {true, false, false, 6, 38, 4},    // supply
}};

}  // namespace

const RoleFacts& facts_of(Role role) { return role_facts[static_cast<std::size_t>(role)]; }

LogColumn& LogTable::only(Role role) {
  return *std::find_if(columns.begin(), columns.end(), [role](const LogColumn& c) { return c.role == role; });
}

LogTable table_of(std::span<const hal::LogRow> rows, const CleanUpContext& context) {
  LogTable table;
  const int signals = context.counts.signals();
  for (int i = 0; i < signals; ++i) {
    const SignalId id = context.counts.signal(i);
    const auto kind = static_cast<std::size_t>(id.kind);
    table.columns.push_back({static_cast<Role>(kind), hal::column_of(id), context.limits[kind], {}});
  }
  const hal::LogLimits air = context.limits[static_cast<std::size_t>(SignalKind::mau_temp)];
  table.columns.push_back({Role::setpoint,
                           hal::column_of({SignalKind::setpoint, 0}),
                           context.limits[static_cast<std::size_t>(SignalKind::setpoint)],
                           {}});
  table.columns.push_back({Role::supply, "supply_temp_degc", air, {}});
  for (LogColumn& column : table.columns) column.value.reserve(rows.size());
  for (const hal::LogRow& row : rows) {
    table.time.push_back(row.time);
    for (std::size_t i = 0; i < row.value.size(); ++i) table.columns[i].value.push_back(row.value[i]);
    table.columns[row.value.size()].value.push_back(row.setpoint_degc);
    table.columns[row.value.size() + 1].value.push_back(row.supply_temp_degc);
  }
  table.station = StationCourse(context.station.get(), table.time.front(), table.time.back());
  return table;
}

void write_back(const LogTable& table, std::vector<hal::LogRow>& rows) {
  const std::size_t signals = table.columns.size() - 2;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    for (std::size_t i = 0; i < signals; ++i) rows[r].value[i] = table.columns[i].value[r];
    rows[r].setpoint_degc = table.columns[signals].value[r];
    rows[r].supply_temp_degc = table.columns[signals + 1].value[r];
  }
}

std::vector<double> sorted_finite(std::span<const double> values) {
  std::vector<double> sorted;
  sorted.reserve(values.size());
  std::copy_if(values.begin(), values.end(), std::back_inserter(sorted), [](double v) { return std::isfinite(v); });
  std::sort(sorted.begin(), sorted.end());
  return sorted;
}

double quantile_of_sorted(std::span<const double> sorted, double share) {
  if (sorted.empty()) return no_value;
  return sorted[static_cast<std::size_t>(std::lround(share * static_cast<double>(sorted.size() - 1)))];
}

double median_of(std::span<const double> values) { return quantile_of_sorted(sorted_finite(values), 0.5); }

std::size_t count_finite(std::span<const double> values) {
  return static_cast<std::size_t>(
      std::count_if(values.begin(), values.end(), [](double v) { return std::isfinite(v); }));
}

StationCourse::StationCourse(const sim::Weather* station, CivilTime from, CivilTime to) {
  if (station == nullptr) return;
  const auto covers = [station](std::int64_t begin_s, std::int64_t end_s) {
    try {
      station->require({begin_s}, {end_s});
      return true;
    } catch (const hal::InputError&) {
      return false;
    }
  };
  const bool margins = covers(from.seconds - beyond_s, to.seconds + beyond_s);
  if (!margins && !covers(from.seconds, to.seconds)) return;
  first_s_ = from.seconds - beyond_s;
  for (std::int64_t t = first_s_; t <= to.seconds + beyond_s; t += row_s) {
    const bool covered = margins || (t >= from.seconds && t <= to.seconds);
    temp_degc_.push_back(covered ? station->at({t}).outdoor_temp_degc : no_value);
  }
}

double StationCourse::at(CivilTime t) const {
  const std::int64_t index = (t.seconds - first_s_) / row_s;
  return t.seconds < first_s_ || index >= std::ssize(temp_degc_) ? no_value
                                                                 : temp_degc_[static_cast<std::size_t>(index)];
}

Following follow(std::span<const CivilTime> time, std::span<const double> values, const StationCourse& station) {
  constexpr int furthest_min = 192;
  constexpr std::size_t least = 2 * rows_per_day;
  Following found;
  const auto sorted = sorted_finite(values);
  if (station.empty() || sorted.size() < least) return found;
  // Sentinels and spikes must not decide.
  const double middle = quantile_of_sorted(sorted, 0.5);
  const double reach = 4 * (quantile_of_sorted(sorted, 0.95) - quantile_of_sorted(sorted, 0.05));
  for (int lag_min = -furthest_min; lag_min <= furthest_min; lag_min += row_s / 60) {
    double n = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
    for (std::size_t i = 0; i < values.size(); ++i) {
      const double v = values[i] - middle, s = station.at({time[i].seconds - 60 * lag_min}) - 20;
      if (!(std::abs(v) <= reach) || !std::isfinite(s)) continue;
      n += 1, x += v, y += s, xx += v * v, yy += s * s, xy += v * s;
    }
    const double vxx = xx - x * x / n, vyy = yy - y * y / n, vxy = xy - x * y / n;
    if (n < static_cast<double>(least) || !(vxx > 0) || !(vyy > 0)) continue;
    const double unexplained = vxy > 0 ? 1 - vxy * vxy / (vxx * vyy) : 1;
    if (lag_min == 0) found.unexplained_0 = unexplained;
    if (unexplained < found.unexplained) found.unexplained = unexplained, found.lag_min = lag_min;
  }
  found.known = found.unexplained <= 0.3 && std::abs(found.lag_min) < furthest_min;
  return found;
}

}  // namespace airside::tools::gap
