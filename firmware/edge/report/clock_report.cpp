#include "firmware/edge/report/clock_report.hpp"

#include <algorithm>

namespace airside::edge {
namespace {

constexpr CivilTime built_after{1'704'067'200};  // 2024-01-01: no clock of a working box is before

}  // namespace

void ClockReport::begin(CivilTime newest_row, bool is_simulated) {
  newest_row_ = newest_row;
  is_simulated_ = is_simulated;
}

bool ClockReport::is_set(CivilTime t) {
  const bool possible = is_simulated_ || t >= built_after;
  const bool behind = !is_simulated_ && t.seconds <= newest_row_.seconds - seconds_per_day;
  if (is_behind_.lasts(possible && behind, t, seconds_per_day)) newest_row_ = t;
  const bool is_set = possible && (!behind || newest_row_ == t);
  if (is_set) newest_row_ = std::max(newest_row_, t);
  return is_set;
}

}  // namespace airside::edge
