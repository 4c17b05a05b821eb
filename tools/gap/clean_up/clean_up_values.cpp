// Single values and stretches of a column that no sensor can have measured.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "hal/text/civil_text.hpp"
#include "tools/gap/clean_up/clean_up_table.hpp"

namespace airside::tools::gap {

namespace {

/// Collects the values of a column that are taken out.
struct TakenOut {
  CivilTime from, to;
  std::size_t count = 0;
  double low = 0, high = 0;
  void take(double& value, CivilTime t) {
    if (count == 0) from = t, low = high = value;
    to = std::max(to, t);
    low = std::min(low, value), high = std::max(high, value);
    ++count;
    value = no_value;
  }
  std::string values() const { return low == high ? fmt::format("{:g}", low) : fmt::format("{:g} .. {:g}", low, high); }
};

void remark(Defect defect, const LogColumn& column, const TakenOut& out, std::string text,
            std::vector<Remark>& remarks) {
  if (out.count == 0) return;
  remarks.push_back({defect, Action::left_out, column.name, out.from, out.to, out.count, std::move(text), "", ""});
}

/// What devices write when they have no value: ends of 16-bit registers, also divided by 10 and 100, and habits.
bool is_sentinel(double v) {
  constexpr std::array numbers{65535.0, 6553.5,  655.35, 32767.0, 3276.7, 327.67, -32768.0, -3276.8,
                               -327.68, -9999.0, -999.0, -999.9,  9999.0, 999.9,  -127.0};
  return std::isinf(v) || std::abs(v) >= 1e9 ||
         std::any_of(numbers.begin(), numbers.end(), [v](double n) { return std::abs(v - n) < 1e-6; });
}

/// |change| from row to row, where two rows follow each other.
std::vector<double> changes_of(const LogTable& table, const LogColumn& column) {
  std::vector<double> changes;
  for (std::size_t i = 1; i < column.value.size(); ++i) {
    if (table.time[i].seconds - table.time[i - 1].seconds == row_s) {
      changes.push_back(std::abs(column.value[i] - column.value[i - 1]));
    }
  }
  return sorted_finite(changes);
}

double largest_believable_jump(const LogTable& table, const LogColumn& column) {
  const double usual = quantile_of_sorted(changes_of(table, column), 0.99);
  const double jump = std::max(column.facts().smallest_jump, 5 * usual);
  if (column.role != Role::power) return jump;
  const auto sorted = sorted_finite(column.value);  // a compressor may start and stop within 12 min
  return std::max(jump, 2 * (quantile_of_sorted(sorted, 0.95) - quantile_of_sorted(sorted, 0.05)));
}

double range_in(const LogColumn& column, std::size_t begin, std::size_t end) {
  double low = 1e300, high = -1e300;
  for (std::size_t i = begin; i < end; ++i) {
    const double v = column.value[i];
    if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  }
  return high > low ? high - low : 0;
}

/// Rows begin..end in which a column shows one value.
struct Run {
  std::size_t begin, end;
  double value;
};

std::vector<Run> runs_of(const LogTable& table, const LogColumn& column, std::int64_t at_least_s) {
  constexpr std::int64_t bridged_s = 3600;
  std::vector<Run> runs;
  std::size_t begin = 0, last = 0;
  bool open = false;
  const auto close = [&] {
    if (open && table.time[last].seconds - table.time[begin].seconds >= at_least_s) {
      runs.push_back({begin, last + 1, column.value[begin]});
    }
  };
  for (std::size_t i = 0; i < column.value.size(); ++i) {
    if (!std::isfinite(column.value[i])) continue;
    const bool goes_on =
        open && column.value[i] == column.value[begin] && table.time[i].seconds - table.time[last].seconds <= bridged_s;
    if (!goes_on) {
      close();
      begin = i;
      open = true;
    }
    last = i;
  }
  close();
  return runs;
}

/// How far a column moves in N rows when it does: 80 % of such stretches move less.
double usual_range(const LogColumn& column, std::size_t rows) {
  std::vector<double> ranges;
  for (std::size_t i = 0; i + rows <= column.value.size(); i += std::max<std::size_t>(rows / 2, 1)) {
    ranges.push_back(range_in(column, i, i + rows));
  }
  std::sort(ranges.begin(), ranges.end());
  return quantile_of_sorted(ranges, 0.8);
}

/// Whether what a column measures must have moved in a stretch, by what the others show.
bool others_moved(LogTable& table, const LogColumn& column, const Run& run) {
  if (column.role == Role::power) {
    std::size_t switched = 0;
    for (const LogColumn& c : table.columns) {
      if (!c.facts().status || c.role == Role::rain) continue;
      for (std::size_t i = run.begin + 1; i < run.end; ++i) switched += c.value[i] != c.value[i - 1] ? 1u : 0u;
    }
    return switched >= 4 && run.value != 0;
  }
  // Supply air is held at its setpoint, and follows a new one within some rows.
  if (column.role == Role::supply) {
    constexpr std::size_t lag_rows = 3;
    return range_in(table.only(Role::setpoint), run.begin, run.end - lag_rows) >= 0.5;
  }
  // Rooms are judged by rooms and fan coils by fan coils, where there are enough of them: fan coils swing more.
  std::vector<double> alike_k, ranges_k;
  for (const LogColumn& c : table.columns) {
    if (&c == &column || !c.facts().temperature || c.role == Role::setpoint) continue;
    if (column.facts().indoor && !c.facts().indoor) continue;
    ranges_k.push_back(range_in(c, run.begin, run.end));
    if (c.role == column.role) alike_k.push_back(ranges_k.back());
  }
  if (alike_k.size() >= 2) ranges_k = std::move(alike_k);
  std::vector<double> steps = changes_of(table, column);
  std::erase(steps, 0.0);
  const double resolution_k = steps.empty() ? 0 : quantile_of_sorted(steps, 0.1);
  const double moved_k = std::min(median_of(ranges_k), usual_range(column, run.end - run.begin));
  return moved_k >= std::max(0.3, 5 * resolution_k);
}

/// A controlled outlet may stand at its setpoint for hours, and a fan's power at its step, and both do so again and
/// again.
bool is_held(const LogTable& table, const LogColumn& column, const Run& run) {
  if (column.role != Role::mau && column.role != Role::power) return false;
  const auto hours = runs_of(table, column, 3600);
  if (column.role == Role::power) return hours.size() > 5;
  return std::count_if(hours.begin(), hours.end(), [&run](const Run& r) { return r.value == run.value; }) >= 3;
}

void empty_constant(LogTable& table, LogColumn& column, std::vector<Remark>& remarks) {
  if (column.role == Role::supply && range_in(table.only(Role::setpoint), 0, table.time.size()) < 0.5) return;
  TakenOut out;
  for (std::size_t i = 0; i < column.value.size(); ++i) {
    if (std::isfinite(column.value[i])) out.take(column.value[i], table.time[i]);
  }
  remark(Defect::constant, column, out, fmt::format("{} throughout; the column was left out", out.values()), remarks);
}

}  // namespace

void check_missing(LogTable& table, const CleanUpContext& context, std::vector<Remark>& remarks) {
  for (LogColumn& column : table.columns) {
    TakenOut out;
    for (std::size_t i = 0; i < column.value.size(); ++i) {
      if (std::isnan(column.value[i])) out.take(column.value[i], table.time[i]);
    }
    const bool whole = out.count == column.value.size();
    if (whole && (column.role == Role::supply || context.partial)) continue;  // need not be logged
    remark(Defect::missing_value, column, out,
           whole ? "no value at all" : fmt::format("{} value{} missing; left out", out.count, plural(out.count)),
           remarks);
  }
}

void check_sentinels(LogTable& table, const CleanUpContext&, std::vector<Remark>& remarks) {
  for (LogColumn& column : table.columns) {
    // No room is at 0.00 degC; a column of 0 and 1 is a status in the wrong place.
    const bool zero_too =
        column.facts().indoor && share_of(column.value, [](double v) { return v == 0 || v == 1; }) < 0.5;
    TakenOut out;
    for (std::size_t i = 0; i < column.value.size(); ++i) {
      double& v = column.value[i];
      if (!std::isnan(v) && (is_sentinel(v) || (zero_too && v == 0))) out.take(v, table.time[i]);
    }
    remark(Defect::sentinel, column, out,
           fmt::format("{} value{} of {}, with which devices say that they have none; left out", out.count,
                       plural(out.count), out.values()),
           remarks);
  }
}

void check_range(LogTable& table, const CleanUpContext&, std::vector<Remark>& remarks) {
  for (LogColumn& column : table.columns) {
    TakenOut out;
    const std::size_t before = count_finite(column.value);
    for (std::size_t i = 0; i < column.value.size(); ++i) {
      double& v = column.value[i];
      if (v < column.limits.min || v > column.limits.max) out.take(v, table.time[i]);
    }
    const bool most = 2 * out.count > before;
    if (most) std::fill(column.value.begin(), column.value.end(), no_value);
    remark(Defect::out_of_range, column, out,
           fmt::format("{} value{} of {}, outside {:g} .. {:g}; {}", out.count, plural(out.count), out.values(),
                       column.limits.min, column.limits.max,
                       most ? "more than half, so the column was left out" : "left out"),
           remarks);
  }
}

void check_spikes(LogTable& table, const CleanUpContext&, std::vector<Remark>& remarks) {
  for (LogColumn& column : table.columns) {
    if (column.facts().smallest_jump <= 0 || count_finite(column.value) < least_values) continue;
    const double jump = largest_believable_jump(table, column);
    TakenOut out;
    for (std::size_t i = 1; i + 1 < column.value.size(); ++i) {
      if (table.time[i + 1].seconds - table.time[i - 1].seconds != 2 * row_s) continue;
      const double up = column.value[i] - column.value[i - 1], down = column.value[i] - column.value[i + 1];
      const double less = std::min(std::abs(up), std::abs(down));
      if (up * down > 0 && less > jump && std::abs(up - down) < 0.5 * less) out.take(column.value[i], table.time[i]);
    }
    remark(Defect::spike, column, out,
           fmt::format("{} value{} of {} that jump by more than {:.1f} and back within 12 min; left out", out.count,
                       plural(out.count), out.values(), jump),
           remarks);
  }
}

void check_stuck(LogTable& table, const CleanUpContext&, std::vector<Remark>& remarks) {
  constexpr std::int64_t stuck_s = 6 * 3600;
  for (LogColumn& column : table.columns) {
    if (column.facts().status || column.role == Role::setpoint || count_finite(column.value) < least_values) continue;
    const auto sorted = sorted_finite(column.value);
    if (sorted.front() == sorted.back()) {
      empty_constant(table, column, remarks);
      continue;
    }
    TakenOut out;
    std::size_t times = 0;
    // Found first, taken out after: others are judged by what they showed.
    for (const Run& run : runs_of(table, column, stuck_s + row_s)) {
      if (!others_moved(table, column, run) || is_held(table, column, run)) continue;
      ++times;
      for (std::size_t i = run.begin; i < run.end; ++i) {
        if (std::isfinite(column.value[i])) out.take(column.value[i], table.time[i]);
      }
    }
    remark(Defect::stuck, column, out,
           fmt::format("stood still for more than 6 h while others moved, {} time{}, from {}; {} values left out",
                       times, plural(times), hal::civil_text(out.from), out.count),
           remarks);
  }
}

void check_enough_left(LogTable& table, const CleanUpContext& context, std::vector<Remark>& remarks) {
  std::size_t rooms = 0, shown = 0;
  const std::size_t rows = table.time.size();
  for (LogColumn& column : table.columns) {
    const std::size_t left = count_finite(column.value);
    if (left > 0 && 2 * left < rows) {
      TakenOut out;
      for (std::size_t i = 0; i < rows; ++i) {
        if (std::isfinite(column.value[i])) out.take(column.value[i], table.time[i]);
      }
      remark(Defect::too_little, column, out,
             fmt::format("{} of {} values are left; the column was left out", left, rows), remarks);
    }
    if (column.role == Role::room && 2 * left >= rows) ++rooms;
    if (!column.facts().status && 2 * left >= rows) ++shown;
    const bool needed = !context.partial && (column.role == Role::outdoor || column.role == Role::setpoint);
    if (needed && 2 * left < rows) {
      remarks.push_back({Defect::too_little, Action::refused, column.name, table.time.front(), table.time.back(), rows,
                         fmt::format("{} of {} values that can be used", left, rows), "more than half of them",
                         "give a log in which this column is right; see the remarks on it"});
    }
  }
  if (context.partial && shown == 0) {
    remarks.push_back({Defect::too_little, Action::refused, "", table.time.front(), table.time.back(), rows,
                       "no column that can be used", "one channel or more with values in half of the rows",
                       "give a log in which they are right; see the remarks on them"});
  }
  if (rooms == 0 && !context.partial) {
    remarks.push_back({Defect::too_little, Action::refused, "", table.time.front(), table.time.back(), rows,
                       "no room temperature that can be used", "one room or more",
                       "give a log with room temperatures; see the remarks on them"});
  }
}

}  // namespace airside::tools::gap
