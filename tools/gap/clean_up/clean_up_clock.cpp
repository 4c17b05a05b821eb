// The clock of the log: the jumps of daylight saving, and a shift of the whole log, both seen in the outdoor
// temperature against the station's.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "hal/text/civil_text.hpp"
#include "tools/gap/clean_up/clean_up_table.hpp"

namespace airside::tools::gap {

namespace {

using Rows = std::vector<hal::LogRow>;

constexpr std::int64_t clock_step_s = seconds_per_hour;
constexpr std::size_t rows_per_hour = clock_step_s / row_s;
constexpr int tolerance_min = 18;

/// A Sunday on which clocks change somewhere.
struct ClockSunday {
  int month, nth;  ///< nth: -1 is the last of the month
  bool forward;
};
constexpr std::array<ClockSunday, 7> clock_sundays{{
    {3, -1, true},  // Europe
    {10, -1, false},
    {3, 2, true},  // North America
    {11, 1, false},
    {10, 1, true},  // Australia
    {4, 1, false},  // Australia, New Zealand
    {9, -1, true},  // New Zealand
}};

bool is_clock_hour(CivilTime t, bool forward) {
  const hal::CivilDate date = hal::civil_date(t);
  if (t.weekday() != 6 || date.hour > 3) return false;
  const int nth = (date.day - 1) / 7 + 1;
  const bool last = hal::civil_date({t.seconds + 7 * seconds_per_day}).month != date.month;
  return std::any_of(clock_sundays.begin(), clock_sundays.end(), [&](const ClockSunday& s) {
    return s.forward == forward && s.month == date.month && (s.nth == nth || (s.nth == -1 && last));
  });
}

/// An hour that is missing (forward) or comes twice (back) before `row`, the first one of the clock after it.
struct Jump {
  std::size_t row = 0;
  bool forward = false;
  CivilTime hour;  ///< in which the hour begins that is missing or doubled
};

/// Rows in order of time; those of one time in order of the file. The hour that comes twice is brought into the order
/// in which it was lived through: first all of the old clock, then all of the new one.
std::vector<Jump> find_jumps(Rows& rows) {
  std::vector<Jump> jumps;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const std::int64_t spacing_s = rows[i].time.seconds - rows[i - 1].time.seconds;
    if (spacing_s == clock_step_s + row_s) jumps.push_back({i, true, {rows[i - 1].time.seconds + row_s}});
    if (spacing_s != 0) continue;
    std::size_t end = i + 1;  // pairs from i - 1 on
    while (end + 1 < rows.size() && rows[end].time == rows[end + 1].time &&
           rows[end].time.seconds - rows[end - 1].time.seconds == row_s) {
      end += 2;
    }
    const std::size_t begin = i - 1, pairs = (end - begin) / 2;
    if (pairs == rows_per_hour) {
      Rows second;
      for (std::size_t k = 0; k < pairs; ++k) {
        if (k > 0) rows[begin + k] = std::move(rows[begin + 2 * k]);
        second.push_back(std::move(rows[begin + 2 * k + 1]));
      }
      std::move(second.begin(), second.end(), rows.begin() + static_cast<std::ptrdiff_t>(begin + pairs));
      jumps.push_back({begin + pairs, false, rows[begin].time});
    }
    i = end - 1;
  }
  return jumps;
}

enum class Evidence { shifted, same, unclear };

/// Rows begin..end of one column.
struct Stretch {
  std::vector<CivilTime> time;
  std::vector<double> outdoor, activity;
};

Stretch stretch_of(const Rows& rows, std::size_t begin, std::size_t end, const hal::TopologyCounts& counts) {
  Stretch s;
  const auto vavs = static_cast<std::size_t>(counts.vavs), fcus = static_cast<std::size_t>(counts.fcus);
  const std::size_t first_fcu_on = 2 * vavs + fcus, outdoor = static_cast<std::size_t>(counts.signals()) - 2;
  for (std::size_t i = begin; i < end; ++i) {
    s.time.push_back(rows[i].time);
    s.outdoor.push_back(rows[i].value[outdoor]);
    double sum = 0;  // fan coils and powers tell when people come
    for (std::size_t c = first_fcu_on; c + 3 < rows[i].value.size(); ++c) sum += rows[i].value[c];
    s.activity.push_back(sum);
  }
  return s;
}

/// Median of every slot of the day, less the mean; empty where a slot has no value.
std::vector<double> day_course(const std::vector<CivilTime>& time, const std::vector<double>& values) {
  std::vector<std::vector<double>> slots(rows_per_day);
  for (std::size_t i = 0; i < time.size(); ++i) {
    slots[static_cast<std::size_t>(time[i].second_of_day() / row_s)].push_back(values[i]);
  }
  std::vector<double> course;
  double mean = 0;
  for (const auto& slot : slots) {
    course.push_back(median_of(slot));
    mean += course.back() / rows_per_day;
  }
  if (!std::isfinite(mean)) return {};
  for (double& v : course) v -= mean;
  return course;
}

/// By how much the second course of a day comes later than the first, where they are alike.  min.
std::optional<int> course_lag_min(const std::vector<double>& first, const std::vector<double>& second) {
  if (first.empty() || second.empty()) return std::nullopt;
  double xx = 0, yy = 0, best = 0;
  int lag = 0;
  for (const double v : first) xx += v * v;
  for (const double v : second) yy += v * v;
  constexpr int furthest = 30, n = rows_per_day;
  for (int k = -furthest; k <= furthest; ++k) {
    double xy = 0;
    for (int i = 0; i < n; ++i) {
      xy += first[static_cast<std::size_t>(i)] * second[static_cast<std::size_t>((i + k + n) % n)];
    }
    if (xy > best) best = xy, lag = k;
  }
  if (best * best < 0.8 * xx * yy || std::abs(lag) == furthest) return std::nullopt;
  return lag * row_s / 60;
}

Evidence judge(int lag_min, int expected_min) {
  if (std::abs(lag_min - expected_min) <= tolerance_min) return Evidence::shifted;
  return std::abs(lag_min) <= tolerance_min ? Evidence::same : Evidence::unclear;
}

/// Whether the clock differs by an hour before and after a jump.
Evidence clock_differs(const Rows& rows, const Jump& jump, const CleanUpContext& context) {
  constexpr std::size_t most = 14 * rows_per_day, least = 2 * rows_per_day;
  if (jump.row < least || rows.size() - jump.row < least) return Evidence::unclear;
  const Stretch before = stretch_of(rows, jump.row - std::min(most, jump.row), jump.row, context.counts);
  const Stretch after = stretch_of(rows, jump.row, std::min(rows.size(), jump.row + most), context.counts);
  const int expected_min = jump.forward ? 60 : -60;
  const StationCourse station(context.station.get(), before.time.front(), after.time.back());
  const Following old_clock = follow(before.time, before.outdoor, station);
  const Following new_clock = follow(after.time, after.outdoor, station);
  if (old_clock.known && new_clock.known) return judge(new_clock.lag_min - old_clock.lag_min, expected_min);
  // Without a station the sun's day must do, or people's where the sun's is unlike from week to week; both are weak.
  if (!is_clock_hour(jump.hour, jump.forward)) return Evidence::unclear;
  const auto sun = course_lag_min(day_course(before.time, before.outdoor), day_course(after.time, after.outdoor));
  const auto people = course_lag_min(day_course(before.time, before.activity), day_course(after.time, after.activity));
  const Evidence of_sun = sun ? judge(*sun, expected_min) : Evidence::unclear;
  const Evidence of_people = people ? judge(*people, expected_min) : Evidence::unclear;
  if (of_sun == Evidence::shifted || of_people == Evidence::shifted) return Evidence::shifted;
  return of_sun == Evidence::same && of_people == Evidence::same ? Evidence::same : Evidence::unclear;
}

}  // namespace

void check_daylight_saving(Rows& rows, const CleanUpContext& context, std::vector<Remark>& remarks) {
  std::vector<Jump> jumps = find_jumps(rows);
  // A gap of an hour is common, so most candidates are none: those go first.
  std::erase_if(jumps, [&](const Jump& jump) {
    const Evidence evidence = clock_differs(rows, jump, context);
    return evidence == Evidence::same || (evidence == Evidence::unclear && !is_clock_hour(jump.hour, jump.forward));
  });
  // Summer time lies after a jump forward and before a jump back.
  for (std::size_t j = 0; j < jumps.size(); ++j) {
    const Jump& jump = jumps[j];
    const bool alone = jump.forward || j == 0 || !jumps[j - 1].forward;
    if (!alone) continue;  // the stretch was put right with the jump forward before it
    std::size_t begin = 0, end = jump.row;
    if (jump.forward)
      begin = jump.row, end = j + 1 < jumps.size() ? jumps[j + 1].row : rows.size();
    else if (j > 0)
      begin = jumps[j - 1].row;
    const CivilTime from = rows[begin].time, to = rows[end - 1].time;
    for (std::size_t i = begin; i < end; ++i) rows[i].time.seconds -= clock_step_s;
    remarks.push_back({Defect::daylight_saving, Action::fixed, "", from, to, end - begin,
                       fmt::format("the hour from {} {}, and the clock differs by 1 h before and after: daylight "
                                   "saving; {} row{} put back to standard time",
                                   hal::civil_text(jump.hour), jump.forward ? "is missing" : "comes twice", end - begin,
                                   end - begin == 1 ? "" : "s"),
                       "", ""});
  }
  std::stable_sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.time < b.time; });
}

void check_clock(LogTable& table, const CleanUpContext&, std::vector<Remark>& remarks) {
  const std::vector<double>& outdoor = table.only(Role::outdoor).value;
  const Following whole = follow(table.time, outdoor, table.station);
  const int hours = static_cast<int>(std::lround(whole.lag_min / 60.0));
  if (!whole.known || hours == 0 || std::abs(whole.lag_min - 60 * hours) > tolerance_min) return;
  if (whole.unexplained > 0.5 * whole.unexplained_0) return;
  // The same in every part of the log, or it is weather.
  constexpr std::size_t part = 3 * rows_per_day;
  int parts = 0, agreeing = 0;
  for (std::size_t i = 0; i + part <= outdoor.size(); i += part) {
    const Following f =
        follow(std::span(table.time).subspan(i, part), std::span(outdoor).subspan(i, part), table.station);
    if (!f.known) continue;
    ++parts;
    if (std::abs(f.lag_min - 60 * hours) <= 30) ++agreeing;
  }
  if (parts == 0 || 4 * agreeing < 3 * parts) return;
  remarks.push_back(
      {Defect::clock_shift, Action::noted, "", table.time.front(), table.time.back(), table.time.size(),
       fmt::format("outdoor temperatures come {} h {} than the station's: the clock may run {} by {} h; "
                   "left as it is, to be tested as an effect",
                   std::abs(hours), hours > 0 ? "later" : "earlier", hours > 0 ? "ahead" : "behind", std::abs(hours)),
       "", ""});
}

}  // namespace airside::tools::gap
