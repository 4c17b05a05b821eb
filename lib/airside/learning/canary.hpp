#pragma once
// States that no log needs to contain, on which every network fit to control must forecast sanely.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

#include "airside/forecast/head_features.hpp"
#include "airside/forecast/room_head.hpp"
#include "airside/network/forward.hpp"
#include "airside/network/scaler.hpp"
#include "airside/network/scratch.hpp"
#include "airside/settings.hpp"
#include "airside/topology.hpp"

namespace airside {

/// How far a network's forecasts on canary states lie outside what a room can do; 0 for a sane one.
/// Rooms 1 K above and below target, every VAV on, setpoint at both ends of its range: excess = sum of
/// (|S' - S| - 15)+ over the four forecasts and of (S'(coldest) - S'(warmest) - 0.5)+ over the two rooms.
/// Units: K. Errors: infinite if a forecast is no number. Cost: four forecasts.
/// Source: docs/box-and-safety.md, row 49;
/// docs/method.md 16.3.
template <Topology T, class Scalar>
double canary_excess_k(const ControllerSettings& settings, const Scaler<T>& scaler,
                       const PackedWeights<T, Scalar>& weights, NetworkScratch<T, Scalar>& scratch) {
  using L = Layout<T>;
  constexpr double widest_move_k = 15, deepest_reversal_k = 0.5;
  const auto rooms = rooms_of<T>(shape_in<T>(settings.shape));
  double excess = 0;
  for (const double offset : {-1.0, 1.0}) {
    const double room = settings.target_degc + offset;
    Eigen::Matrix<double, L::signals, 1> state = scaler.mean.template head<L::signals>();
    state.head(rooms).setConstant(room);
    state.segment(L::vav_on, rooms).setOnes();
    const Eigen::Matrix<Scalar, L::signals, 1> scaled = scaler.template signals<Scalar>(state);
    const std::array<Scalar, 2> ends{scaler.template setpoint<Scalar>(settings.action_min_degc),
                                     scaler.template setpoint<Scalar>(settings.action_max_degc)};
    std::array<RoomForecast<T, Scalar>, 2> forecasts;
    forecast_candidates<T, Scalar>(weights, std::span<const Scalar, L::signals>(scaled.data(), L::signals), ends,
                                   scratch, forecasts);
    std::array<double, 2> mean{};
    for (std::size_t i = 0; i < ends.size(); ++i) {
      double sum = 0;
      for (const Scalar s : forecasts[i].short_term) sum += static_cast<double>(s);
      mean[i] = scaler.room_mean() + scaler.room_scale() * sum / rooms;
      if (!std::isfinite(mean[i])) return std::numeric_limits<double>::infinity();
      excess += std::max(0.0, std::abs(mean[i] - room) - widest_move_k);
    }
    excess += std::max(0.0, mean[0] - mean[1] - deepest_reversal_k);
  }
  return excess;
}

/// How far a room head lies outside what a room can do; 0 for a sane one.
/// One unit of each regressor, and each slot's disturbance, must move the room by 5 K a cycle at most; the gain must
/// not be reversed beyond doubt; nothing may be less known than by 10 K: excess = sum of (|theta| - 5)+, of
/// -(theta_gain + 2 sd)- and of (sd - 10)+.
/// Units: K. Errors: not 0 for what is no number. Cost: O(states).
/// Source: docs/box-and-safety.md, row 49; docs/method.md 16.3.
template <Topology T>
double canary_excess_k(const typename RoomHead<T>::State& theta, typename RoomHead<T>::ConstCovariance covariance) {
  constexpr double widest_move_k = 5, least_known_k = 10;
  constexpr int gain = HeadFeatures::setpoint_change;
  const auto sd = covariance.diagonal().array().sqrt();
  if (!theta.allFinite() || !sd.isFinite().all()) return std::numeric_limits<double>::infinity();
  return (theta.array().abs() - widest_move_k).max(0.0).sum() + (sd - least_known_k).max(0.0).sum() +
         std::max(0.0, -(theta(gain) + 2 * std::sqrt(covariance(gain, gain))));
}

}  // namespace airside
