#pragma once
// What the validator needs to know of each signal, from the point map.

#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

#include "airside/supervision/validation.hpp"
#include "hal/points/point_map.hpp"

namespace airside::hal {

/// Limits of one signal; an empty max_rate or stale_s keeps what lib's SignalLimits says. Of several sensors of a zone,
/// the widest.
inline SignalLimits limits_of(const std::vector<const Point*>& sensors) {
  SignalLimits l;
  l.min = l.max = std::numeric_limits<double>::quiet_NaN();
  double max_rate = 0, stale_s = 0;
  for (const Point* p : sensors) {
    l.min = std::fmin(l.min, p->min);
    l.max = std::fmax(l.max, p->max);
    max_rate = std::fmax(max_rate, p->max_rate_per_min);
    stale_s = std::fmax(stale_s, p->stale_s);
  }
  if (std::isfinite(max_rate)) l.max_rate_per_min = max_rate;
  if (std::isfinite(stale_s)) l.stale_s = stale_s;
  return l;
}

/// Limits in the order of Layout<T> for a site of this shape.
/// Errors: InputError where the map lacks a signal for which there is no stand-in.
template <Topology T>
LimitsTable<T> signal_limits(const PointMap& map, const Shape& site = capacity_of<T>(),
                             const StandIns& stand_ins = {}) {
  LimitsTable<T> table{};
  keep_to_shape<T>(site, table);
  for (int i = 0; i < Layout<T>::signals; ++i) {
    if (!is_present<T>(site, i)) continue;
    const SignalId id = signal_id<T>(i);
    SignalLimits& l = table[static_cast<std::size_t>(i)];
    if (map.has(id)) {
      const std::vector<const Point*> several = map.sensors(id.kind == SignalKind::room_temp ? id.place : 0);
      l = limits_of(several.empty() ? std::vector<const Point*>{&map.at(point_name(id))} : several);
    } else if (const auto value = stand_ins.of(id)) {
      l.sensed = false;
      l.stand_in = *value;
    } else {
      (void)map.at(point_name(id));
    }
  }
  return table;
}

}  // namespace airside::hal
