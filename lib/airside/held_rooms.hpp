#pragma once
// Which one number of the rooms is held at the target. Room head, network's score, residual forecaster, monitors and
// history all take it from here, so that they mean the same.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "airside/topology.hpp"

namespace airside {

enum class HoldRule : std::uint8_t {
  mean = 0,      ///< the plain mean of the rooms
  weighted = 1,  ///< the mean of the rooms by weights of the site
  middle = 2,    ///< halfway between the warmest and the coldest room whose box is open
};

/// As site files and reports have it.
constexpr const char* text_of(HoldRule rule) {
  return rule == HoldRule::weighted ? "weighted" : rule == HoldRule::middle ? "middle" : "mean";
}

/// The rule and its weights. Shape: one weight a room, in the order of the VAV boxes.
struct HeldRooms {
  HoldRule rule = HoldRule::mean;
  std::array<double, Shape::max_vavs> weights{};  ///< of `weighted`: none negative, one at least above 0
};

/// The value that is held, of rooms and boxes given apart.
///   mean: (1/n) sum S_r;  weighted: sum w_r S_r / sum w_r;  middle: (max S_r + min S_r) / 2 over the rooms that count
/// Shape: rooms_degc, counts one entry a room; `counts` below 0.5: a closed box, for whose room no supply air can do
/// anything. It matters to `middle` alone, which takes every room where none counts.
/// Units: degC. Cost: O(rooms).  Source: docs/method.md 16.7.
template <class Rooms, class Counts>
double held_of(const HeldRooms& held, const Rooms& rooms_degc, const Counts& counts) {
  if (held.rule == HoldRule::mean) return rooms_degc.mean();
  if (held.rule == HoldRule::weighted) {
    double sum = 0, weight = 0;
    for (Eigen::Index r = 0; r < rooms_degc.size(); ++r) {
      const double w = held.weights[static_cast<std::size_t>(r)];
      sum += w * rooms_degc(r);
      weight += w;
    }
    return sum / weight;
  }
  double low = std::numeric_limits<double>::infinity(), high = -low;
  for (const bool all : {false, true}) {
    for (Eigen::Index r = 0; r < rooms_degc.size(); ++r) {
      if (!all && counts(r) < 0.5) continue;
      low = std::min(low, static_cast<double>(rooms_degc(r)));
      high = std::max(high, static_cast<double>(rooms_degc(r)));
    }
    if (low <= high) break;
  }
  return 0.5 * (low + high);
}

/// The value that is held in a reading. Shape: signals of Layout<T>. Units: degC.
template <Topology T, class Signals>
double held_degc(const HeldRooms& held, const Shape& site, const Signals& v) {
  const auto n = rooms_of<T>(site);
  return held_of(held, v.head(n), v.segment(Layout<T>::vav_on, n));
}

/// By how much it changed between two readings. For `middle` of the rooms whose boxes are open in both: a box that
/// closes or opens changes which rooms count, which is no change of any temperature.
/// Shape: signals of Layout<T>. Units: K.
template <Topology T, class Signals>
double held_change_k(const HeldRooms& held, const Shape& site, const Signals& before, const Signals& now) {
  const auto n = rooms_of<T>(site);
  if (held.rule == HoldRule::mean) return (now.head(n) - before.head(n)).mean();
  const auto open = before.segment(Layout<T>::vav_on, n).cwiseMin(now.segment(Layout<T>::vav_on, n));
  return held_of(held, now.head(n), open) - held_of(held, before.head(n), open);
}

/// What was held in `before` as it is now: the value to compare with a forecast that was made then.
/// Shape: signals of Layout<T>. Units: degC.
template <Topology T, class Signals>
double held_after_degc(const HeldRooms& held, const Shape& site, const Signals& before, const Signals& now) {
  if (held.rule == HoldRule::mean) return held_degc<T>(held, site, now);
  return held_degc<T>(held, site, before) + held_change_k<T>(held, site, before, now);
}

/// Whether the weights of a rule can be used by a site of `rooms` rooms.
constexpr bool held_rooms_valid(const HeldRooms& held, int rooms) {
  if (held.rule != HoldRule::weighted) return true;
  double sum = 0;
  for (int r = 0; r < rooms; ++r) {
    const double w = held.weights[static_cast<std::size_t>(r)];
    if (!(w >= 0 && w <= 1e3)) return false;
    sum += w;
  }
  return sum > 0;
}

}  // namespace airside
