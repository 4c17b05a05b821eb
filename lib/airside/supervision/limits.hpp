#pragma once
// What each signal may be, and which signals a site has: what the validator holds a reading against.

#include <array>
#include <cstddef>

#include "airside/reading.hpp"
#include "airside/signals.hpp"
#include "airside/topology.hpp"

namespace airside {

/// What a signal may be. From the point map; units of the signal.
struct SignalLimits {
  double min = -1e9;
  double max = 1e9;
  double max_rate_per_min = 1e9;  ///< larger steps must be confirmed by three samples
  double stale_s = 1080;          ///< older values are not used
  double stuck_s = 21600;         ///< unchanged for so long while its peers moved: stuck
  double stand_in = 0;            ///< what counts where the site has no such signal
  bool sensed = true;             ///< false: the site has none, and the stand-in is not judged
};

template <Topology T>
using LimitsTable = std::array<SignalLimits, static_cast<std::size_t>(Layout<T>::signals)>;

/// Fills in limits that suit an office where the point map says nothing.
template <Topology T>
constexpr void fill_default_limits(LimitsTable<T>& table) {
  for (int i = 0; i < Layout<T>::signals; ++i) {
    SignalLimits& l = table[static_cast<std::size_t>(i)];
    switch (signal_id<T>(i).kind) {
      case SignalKind::room_temp:
      case SignalKind::fcu_temp: l.min = 5, l.max = 50, l.max_rate_per_min = 1.0; break;
      case SignalKind::mau_temp: l.min = -10, l.max = 50, l.max_rate_per_min = 3.0; break;
      case SignalKind::outdoor_temp: l.min = -40, l.max = 55, l.max_rate_per_min = 2.0; break;
      case SignalKind::power: l.min = -1, l.max = 1000; break;
      default: l.min = 0, l.max = 1; break;
    }
  }
}

template <Topology T>
constexpr LimitsTable<T> default_limits() {
  LimitsTable<T> table{};
  fill_default_limits<T>(table);
  return table;
}

/// Marks what a site of this shape has no place for: it is not sensed, and 0.
template <Topology T>
constexpr void keep_to_shape(const Shape& site, LimitsTable<T>& limits) {
  for (int i = 0; i < Layout<T>::signals; ++i) {
    SignalLimits& l = limits[static_cast<std::size_t>(i)];
    if (!is_present<T>(site, i)) l.sensed = false, l.stand_in = 0;
  }
}

/// Puts the stand-ins into the places of signals that the site lacks.
template <Topology T>
void fill_stand_ins(const LimitsTable<T>& limits, typename Reading<T>::Vector& value) {
  for (int i = 0; i < Layout<T>::signals; ++i) {
    const SignalLimits& l = limits[static_cast<std::size_t>(i)];
    if (!l.sensed) value(i) = l.stand_in;
  }
}

}  // namespace airside
