#pragma once
// The control cycle of a site that says nothing of it, in which most tests count.

#include "airside/civil_time.hpp"

namespace airside {

constexpr int rows_per_cycle = default_cycle.rows;
constexpr int cycle_s = default_cycle.seconds();
constexpr int cycles_per_day = default_cycle.per_day();
constexpr int cycle_of_day(CivilTime t) { return default_cycle.of_day(t); }
constexpr bool starts_cycle(CivilTime t) { return default_cycle.starts(t); }

}  // namespace airside
