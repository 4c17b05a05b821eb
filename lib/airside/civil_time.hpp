#pragma once
// Local civil time as one integer, and the instants of the control cycle.

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

constexpr int row_s = 360;                       ///< a logged row: 6 min (spec OPEN-1)
constexpr int rows_per_cycle = 3;                ///< one decision: 18 min
constexpr int cycle_s = row_s * rows_per_cycle;  ///< s
constexpr int rows_per_day = 86400 / row_s;      ///< 240
constexpr int cycles_per_day = 86400 / cycle_s;  ///< 80, aligned at midnight

/// Cycle of the day, 0..79.
constexpr int cycle_of_day(CivilTime t) { return t.second_of_day() / cycle_s; }
/// Whether t starts a control cycle.
constexpr bool starts_cycle(CivilTime t) { return t.second_of_day() % cycle_s == 0; }

}  // namespace airside
