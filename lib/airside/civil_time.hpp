#pragma once
// Local civil time as one integer, and the instants of rows and of the control cycle.

#include <compare>  // IWYU pragma: keep: operator<=> needs it
#include <cstdint>

namespace airside {

/// Seconds since 1970-01-01 00:00 of the site's local standard time (no daylight saving).
struct CivilTime {
  std::int64_t seconds = 0;

  constexpr std::int64_t day() const { return floor_div(seconds, 86400); }
  constexpr int second_of_day() const { return static_cast<int>(seconds - day() * 86400); }
  constexpr int minute_of_day() const { return second_of_day() / 60; }
  /// 0 Monday .. 6 Sunday.
  constexpr int weekday() const { return static_cast<int>(((day() + 3) % 7 + 7) % 7); }
  constexpr auto operator<=>(const CivilTime&) const = default;

 private:
  static constexpr std::int64_t floor_div(std::int64_t a, std::int64_t b) { return a / b - (a % b < 0 ? 1 : 0); }
};

constexpr std::int64_t seconds_per_hour = 3600;
constexpr std::int64_t seconds_per_day = 86400;
constexpr int row_s = 360;                   ///< a logged row: 6 min (docs/method.md, open point 1)
constexpr int rows_per_day = 86400 / row_s;  ///< 240
/// A clock that was set back by at most that is waited for; one that moved further is followed. s
constexpr int clock_leap_s = 1080;

/// The control cycle of a site, one decision: 1 to 4 logged rows, aligned at midnight. Source: docs/method.md 2.
struct ControlCycle {
  int rows = 3;

  constexpr int seconds() const { return rows * row_s; }
  constexpr int minutes() const { return seconds() / 60; }
  constexpr int per_day() const { return rows_per_day / rows; }  ///< 80 of 18 min
  /// Cycle of the day, from 0.
  constexpr int of_day(CivilTime t) const { return t.second_of_day() / seconds(); }
  /// Whether t starts a cycle.
  constexpr bool starts(CivilTime t) const { return t.second_of_day() % seconds() == 0; }
  constexpr bool operator==(const ControlCycle&) const = default;
};
constexpr ControlCycle default_cycle{};  ///< 18 min
constexpr int most_rows_per_cycle = 4;

/// Whether a site may have a cycle of this length: 6, 12, 18 or 24 min.
constexpr bool is_cycle_min(int minutes) {
  return minutes > 0 && minutes * 60 % row_s == 0 && minutes * 60 / row_s <= most_rows_per_cycle;
}
constexpr ControlCycle cycle_of_minutes(int minutes) { return {minutes * 60 / row_s}; }

// Profiles of a day, whatever the cycle: 80 slots of 18 min.
constexpr int profile_slot_s = 1080;
constexpr int profile_slots = 86400 / profile_slot_s;
constexpr int profile_slot_of(CivilTime t) { return t.second_of_day() / profile_slot_s; }

/// When people's clocks are an hour ahead of standard time. Rows, cycles and logs always run on standard time, so a day
/// has 240 rows all year; only what follows people (schedule, daily profile) asks for local_time().
enum class DaylightSaving : std::int32_t {
  none = 0,
  european_union = 1,  ///< last Sunday of March 01:00 UTC to last Sunday of October 01:00 UTC
  united_states = 2,   ///< second Sunday of March 02:00 to first Sunday of November 02:00, by the clock on the wall
};

/// Day number of the `nth` (1 first, -1 last) Sunday of a month.
constexpr std::int64_t sunday_of(int year, int month, int nth) {
  // Days from civil, proleptic Gregorian; the year begins in March, so that February's length does not matter.
  const auto first_day = [](int y, int m) {
    y -= m <= 2 ? 1 : 0;
    const std::int64_t era = (y >= 0 ? y : y - 399) / 400;
    const std::int64_t of_era = y - era * 400;
    const std::int64_t of_year = (153 * (m + (m > 2 ? -3 : 9)) + 2) / 5;
    return era * 146097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719468;
  };
  const auto to_sunday = [](std::int64_t day) { return 6 - ((day + 3) % 7 + 7) % 7; };
  const std::int64_t begin = first_day(year, month);
  if (nth > 0) return begin + to_sunday(begin) + 7 * (nth - 1);
  const std::int64_t next = month == 12 ? first_day(year + 1, 1) : first_day(year, month + 1);
  return next - 7 + to_sunday(next - 7);
}

/// Year of a day since 1970-01-01.
constexpr int year_of(std::int64_t day) {
  const std::int64_t shifted = day + 719468;
  const std::int64_t era = (shifted >= 0 ? shifted : shifted - 146096) / 146097;
  const std::int64_t of_era = shifted - era * 146097;
  const std::int64_t year_of_era = (of_era - of_era / 1460 + of_era / 36524 - of_era / 146096) / 365;
  const std::int64_t day_of_year = of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
  return static_cast<int>(era * 400 + year_of_era + (day_of_year >= 306 ? 1 : 0));
}

/// What clocks on the wall show at standard time t. `utc_offset_h`: of standard time, hours east of UTC.
constexpr CivilTime local_time(DaylightSaving rule, double utc_offset_h, CivilTime t) {
  if (rule == DaylightSaving::none) return t;
  const int year = year_of(t.day());
  std::int64_t begin_s = 0, end_s = 0;
  if (rule == DaylightSaving::european_union) {
    const std::int64_t one_utc_s = 3600 + static_cast<std::int64_t>(utc_offset_h * 3600);
    begin_s = sunday_of(year, 3, -1) * 86400 + one_utc_s;
    end_s = sunday_of(year, 10, -1) * 86400 + one_utc_s;
  } else {
    begin_s = sunday_of(year, 3, 2) * 86400 + 2 * 3600;
    end_s = sunday_of(year, 11, 1) * 86400 + 3600;  // 02:00 on the wall
  }
  return t.seconds >= begin_s && t.seconds < end_s ? CivilTime{t.seconds + 3600} : t;
}

}  // namespace airside
