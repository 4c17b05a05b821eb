#pragma once
// What the validator needs to know of each signal, from the point map.

#include <cmath>

#include "airside/supervision/validation.hpp"
#include "hal/points/point_map.hpp"

namespace airside::hal {

/// Limits in the order of Layout<T> for a site of this shape; an empty max_rate or stale_s keeps what lib's
/// SignalLimits says. Errors: InputError where the map lacks a signal.
template <Topology T>
LimitsTable<T> signal_limits(const PointMap& map, const Shape& site = capacity_of<T>()) {
  LimitsTable<T> table{};
  keep_to_shape<T>(site, table);
  for (int i = 0; i < Layout<T>::signals; ++i) {
    if (!is_present<T>(site, i)) continue;
    const Point& p = map.at(point_name(signal_id<T>(i)));
    SignalLimits& l = table[static_cast<std::size_t>(i)];
    l.min = p.min;
    l.max = p.max;
    if (std::isfinite(p.max_rate_per_min)) l.max_rate_per_min = p.max_rate_per_min;
    if (std::isfinite(p.stale_s)) l.stale_s = p.stale_s;
  }
  return table;
}

}  // namespace airside::hal
