#pragma once
// Civil time as people read and write it: ISO 8601, local, without a zone.

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>

#include "airside/civil_time.hpp"

namespace airside::hal {

constexpr std::size_t civil_text_size = 19;  ///< characters of `2021-07-01T00:06:00`
constexpr std::size_t date_text_size = 10;   ///< characters of `2021-07-01`

/// Year, month 1..12, day 1..31, hour, minute, second.
struct CivilDate {
  int year = 1970, month = 1, day = 1;
  int hour = 0, minute = 0, second = 0;
};

/// The instant of a date; the fields must be in range.
CivilTime civil_time(const CivilDate& date);

/// The date of an instant.
CivilDate civil_date(CivilTime time);

/// Writes `2021-07-01T00:06:00` at `out` without a final zero and returns the end.
/// Years outside 0..9999 are shown as the nearest of the two.
/// Cost: no heap.
char* write_civil_text(char* out, CivilTime time);

/// `07:30` of seconds since midnight.
std::string clock_text(int second_of_day);

/// Writes `2021-07-01` at `out` without a final zero and returns the end.
/// Cost: no heap.
char* write_date_text(char* out, CivilTime time);

/// `2021-07-01T00:06:00`.
std::string civil_text(CivilTime time);

/// Reads `YYYY-MM-DDTHH:MM[:SS]`; a space may stand for the T, `24:00` is the next midnight.
/// Errors: nothing is returned for any other text, a zone suffix and days that do not exist included.
std::optional<CivilTime> parse_civil_text(std::string_view text);

/// Reads a time of day `HH:MM[:SS]`, up to `24:00`. Units: s since midnight.
/// Errors: nothing is returned for any other text.
std::optional<int> parse_time_of_day(std::string_view text);

}  // namespace airside::hal
