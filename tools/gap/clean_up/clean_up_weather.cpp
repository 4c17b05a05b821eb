// Whether the weather beside a log is that of its days: the log's outdoor temperature against the station's.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "tools/gap/clean_up/clean_up_table.hpp"

namespace airside::tools::gap {

namespace {

// Sensor at a house against the station beside it (Holzkirchen, two houses, 4 to 14 days): 0.3 to 1.02 K of
// `irregular_k`, daily means within 0.75 K, correlation 0.92 or more. Other years' weather: docs/gap-workflow.md.
constexpr double most_irregular_k = 1.1, most_daily_k = 0.3, least_correlation = 0.9;
constexpr double refused_daily_k = 1, refused_correlation = 0.3;
constexpr int least_hours = 48, least_days = 4, least_days_refused = 6, hours_of_a_day = 20;

/// Log less station, one value an hour.
struct HourlyDifference {
  std::int64_t hour;
  double difference_k, log_degc;
};

/// Standard deviation of log less station, each value by itself; NaN where there is none.
double spread_at(const LogTable& table, const std::vector<double>& outdoor, int lag_min) {
  double n = 0, sum = 0, squares = 0;
  for (std::size_t i = 0; i < outdoor.size(); ++i) {
    const double k = outdoor[i] - table.station.at({table.time[i].seconds - 60LL * lag_min});
    if (std::isfinite(k)) n += 1, sum += k, squares += k * k;
  }
  return n > 0 ? std::sqrt(std::max(0.0, squares / n - sum * sum / n / n)) : no_value;
}

/// The lag by which the two differ least; none unless it takes a tenth off.
int best_lag_min(const LogTable& table, const std::vector<double>& outdoor) {
  constexpr int furthest_min = 192;
  const double without_k = spread_at(table, outdoor, 0);
  double best_k = 0.9 * without_k;
  int best_min = 0;
  for (int lag_min = -furthest_min; lag_min <= furthest_min; lag_min += row_s / 60) {
    const double k = spread_at(table, outdoor, lag_min);
    if (k < best_k) best_k = k, best_min = lag_min;
  }
  return best_min;
}

std::vector<HourlyDifference> hourly(const LogTable& table, const std::vector<double>& outdoor, int lag_min) {
  std::vector<HourlyDifference> hours;
  int count = 0;
  for (std::size_t i = 0; i < outdoor.size(); ++i) {
    const double k = outdoor[i] - table.station.at({table.time[i].seconds - 60LL * lag_min});
    if (!std::isfinite(k)) continue;
    const std::int64_t hour = table.time[i].seconds / seconds_per_hour;
    if (hours.empty() || hours.back().hour != hour) hours.push_back({hour, 0, 0}), count = 0;
    HourlyDifference& h = hours.back();
    ++count;
    h.difference_k += (k - h.difference_k) / count;
    h.log_degc += (outdoor[i] - h.log_degc) / count;
  }
  return hours;
}

double mean_of(const std::vector<HourlyDifference>& hours) {
  double sum = 0;
  for (const HourlyDifference& h : hours) sum += h.difference_k;
  return sum / static_cast<double>(hours.size());
}

double spread_of(const std::vector<HourlyDifference>& hours) {
  const double mean = mean_of(hours);
  double squares = 0;
  for (const HourlyDifference& h : hours) squares += (h.difference_k - mean) * (h.difference_k - mean);
  return std::sqrt(squares / static_cast<double>(hours.size()));
}

/// What neither level nor mean course of the day explains, as a standard deviation.
double irregular_of(const std::vector<HourlyDifference>& hours) {
  std::array<double, 24> sum{}, count{};
  const auto slot = [](const HourlyDifference& h) { return static_cast<std::size_t>((h.hour % 24 + 24) % 24); };
  for (const HourlyDifference& h : hours) sum[slot(h)] += h.difference_k, count[slot(h)] += 1;
  double squares = 0, free = 0;
  for (const HourlyDifference& h : hours) {
    const double k = h.difference_k - sum[slot(h)] / count[slot(h)];
    squares += k * k;
  }
  for (const double n : count) free += std::max(0.0, n - 1);
  return free > 0 ? std::sqrt(squares / free) : 0;
}

/// Differences of daily means about their mean, and how log and station agree from day to day.
void compare_days(const std::vector<HourlyDifference>& hours, OutdoorDifference& found) {
  struct Day {
    double n = 0, difference = 0, log = 0;
  };
  std::map<std::int64_t, Day> by_day;
  for (const HourlyDifference& h : hours) {
    Day& day = by_day[h.hour / 24];
    day.n += 1, day.difference += h.difference_k, day.log += h.log_degc;
  }
  double n = 0, d = 0, dd = 0, x = 0, y = 0, xx = 0, yy = 0, xy = 0;
  for (const auto& [number, day] : by_day) {
    if (day.n < hours_of_a_day) continue;
    const double k = day.difference / day.n, log = day.log / day.n, station = log - k;
    n += 1, d += k, dd += k * k, x += log, y += station, xx += log * log, yy += station * station, xy += log * station;
  }
  found.days = static_cast<int>(n);
  if (n < 2) return;
  const double vxx = xx - x * x / n, vyy = yy - y * y / n, vxy = xy - x * y / n;
  found.daily_k = std::sqrt(std::max(0.0, (dd - d * d / n) / (n - 1)));
  found.daily_correlation = vxx > 0 && vyy > 0 ? vxy / std::sqrt(vxx * vyy) : 0;
}

std::string differ_text(const OutdoorDifference& d, const std::string& file) {
  std::string text = fmt::format(
      "outdoor temperatures of the log and of {} differ by {:.1f} K rms about a mean of "
      "{:+.1f} K",
      file, d.rms_k, d.mean_k);
  if (d.lag_min != 0)
    text += fmt::format(", by {:.1f} K where the log's come {:.1f} h {}", d.shifted_rms_k, std::abs(d.lag_min) / 60.0,
                        d.lag_min > 0 ? "later" : "earlier");
  if (d.days >= least_days)
    text +=
        fmt::format("; their daily means by {:.1f} K, with a correlation of {:.2f}", d.daily_k, d.daily_correlation);
  return text;
}

}  // namespace

bool OutdoorDifference::other_weather() const {
  return irregular_k > most_irregular_k ||
         (days >= least_days && daily_k > most_daily_k && daily_correlation < least_correlation);
}

bool OutdoorDifference::no_relation() const {
  return days >= least_days_refused && daily_k > refused_daily_k && daily_correlation < refused_correlation;
}

void check_weather(LogTable& table, const CleanUpContext& context, std::vector<Remark>& remarks) {
  const LogColumn& column = table.only(Role::outdoor);
  const int place = context.counts.signals() - 2;  // outdoor temperature and rain are the last signals
  const bool doubtful = std::any_of(remarks.begin(), remarks.end(), [&column](const Remark& r) {
    return r.column == column.name && r.action == Action::refused;
  });
  if (table.station.empty() || doubtful || context.counts.stand_in(place)) return;
  const std::vector<HourlyDifference> as_it_is = hourly(table, column.value, 0);
  if (std::ssize(as_it_is) < least_hours) return;
  OutdoorDifference found;
  found.mean_k = mean_of(as_it_is);
  found.rms_k = found.shifted_rms_k = spread_of(as_it_is);
  found.lag_min = best_lag_min(table, column.value);
  const std::vector<HourlyDifference> shifted =
      found.lag_min == 0 ? as_it_is : hourly(table, column.value, found.lag_min);
  found.shifted_rms_k = spread_of(shifted);
  found.irregular_k = irregular_of(shifted);
  compare_days(shifted, found);
  table.outdoor_difference = found;
  if (!found.other_weather() && !found.no_relation()) return;
  const std::string file = context.station->description();
  Remark remark{Defect::other_weather,
                Action::warned,
                column.name,
                table.time.front(),
                table.time.back(),
                count_finite(column.value),
                differ_text(found, file),
                "",
                ""};
  if (found.no_relation()) {
    remark.action = Action::refused;
    remark.text += ", those of another year or another place";
    remark.expected = "the weather of the days of the log: sun, humidity and wind are taken from this file";
    remark.remedy = "give the weather of the days of the log (--weather), or correct the log's outdoor temperature";
  } else {
    remark.text += fmt::format(
        ": another year or another place? The replay takes this temperature from the log, but sun, humidity and wind "
        "from {}, which are in doubt. Give the weather of the days of the log (--weather)",
        file);
  }
  remarks.push_back(std::move(remark));
}

}  // namespace airside::tools::gap
