#pragma once
// What the residual forecaster sees of an instant: what the room head does not look at.

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "airside/civil_time.hpp"
#include "airside/forecast/head_features.hpp"
#include "airside/held_rooms.hpp"
#include "airside/settings.hpp"
#include "airside/topology.hpp"

namespace airside {

/// The regressors of one instant. Units: K, cycles, shares of the boxes; means are over the rooms, so that one network
/// fits every topology. Numbers frozen: blobs hold weights for them.
struct ResidualFeatures {
  static constexpr int error = 0;                  ///< of the head's forecast of the cycle that ended
  static constexpr int error_before = 1;           ///< of the one before
  static constexpr int hour = 2;                   ///< (hour - 12) / 12, local
  static constexpr int hour_squared = 3;           ///< of that
  static constexpr int deviation = 4;              ///< room mean less target
  static constexpr int change_recent = 5;          ///< of the room mean over the last 6 min
  static constexpr int change = 6;                 ///< over the last cycle
  static constexpr int move = 7;                   ///< by which the head alone would change the setpoint
  static constexpr int move_before = 8;            ///< the setpoint change before
  static constexpr int to_supply = 9;              ///< the head's setpoint less the room mean
  static constexpr int closed = 10;                ///< share of boxes that are closed
  static constexpr int opened_recent = 11;         ///< share opened less share closed over the last 6 min
  static constexpr int longest_closed = 12;        ///< cycles since the first of the closed boxes closed
  static constexpr int mean_closed = 13;           ///< the same as a mean over all boxes
  static constexpr int closed_deviation = 14;      ///< mean((1 - on) (S - mean S))
  static constexpr int closed_change_recent = 15;  ///< mean((1 - on) dS) over the last 6 min
  static constexpr int closed_change = 16;         ///< over the last cycle
  static constexpr int reopening = 17;             ///< mean(d on (S - setpoint)) over the last 6 min
  static constexpr int count = 18;
  Eigen::Matrix<float, count, 1> x = Eigen::Matrix<float, count, 1>::Zero();
};

/// What the regressors need from cycles before. Plain bytes, saved with the cycle. Units: K.
template <int Rooms>
struct ResidualMemory {
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  static constexpr double most_cycles = 20;  ///< six hours: longer is no outage but a closed room

  std::array<double, static_cast<std::size_t>(Rooms)> closed_cycles{};  ///< since each box closed; 0: it is open
  double error_k = unknown;                                             ///< head's, of the cycle that ended
  double error_before_k = unknown;                                      ///< of the one before
  ResidualFeatures features;                                            ///< of the cycle that runs, where has_features
  double forecast_k = unknown;  ///< the whole forecast for the cycle that runs, whatever share is used

  std::int64_t has_features = 0;

  bool is_complete() const { return std::isfinite(error_k) && std::isfinite(error_before_k); }

  /// A cycle ended; NaN: nothing is known of it.
  void end_cycle(double head_error_k) {
    error_before_k = error_k;
    error_k = head_error_k;
  }

  template <class Boxes>
  void count_closed(const Boxes& on) {
    for (Eigen::Index i = 0; i < on.size(); ++i) {
      double& n = closed_cycles[static_cast<std::size_t>(i)];
      n = on(i) < 0.5 ? std::min(n + 1, most_cycles) : 0.0;
    }
  }
};

/// The regressors of an instant at which the head alone would write `head_degc`.
template <Topology T>
ResidualFeatures residual_features(const ControllerSettings& s, CivilTime t, const HeadInstants<T>& at,
                                   const ResidualMemory<Layout<T>::rooms>& memory, double head_degc) {
  using L = Layout<T>;
  using F = ResidualFeatures;
  const auto n = rooms_of<T>(s.shape);
  const auto rooms = at.now.head(n);
  const auto on = at.now.segment(L::vav_on, n);
  const auto off = 1.0 - on.array();
  const auto on_change = on - at.recent.segment(L::vav_on, n);
  const double mean = held_degc<T>(s.held, s.shape, at.now);
  const double hour = local_time(s, t).second_of_day() / 43200.0 - 1.0;
  Eigen::Matrix<double, F::count, 1> x;
  x(F::error) = memory.error_k;
  x(F::error_before) = memory.error_before_k;
  x(F::hour) = hour;
  x(F::hour_squared) = hour * hour;
  x(F::deviation) = mean - s.target_degc;
  x(F::change_recent) = held_change_k<T>(s.held, s.shape, at.recent, at.now);
  x(F::change) = held_change_k<T>(s.held, s.shape, at.before, at.now);
  x(F::move) = head_degc - at.setpoint_before_degc;
  x(F::move_before) = at.last_move_k;
  x(F::to_supply) = head_degc - mean;
  x(F::closed) = off.mean();
  x(F::opened_recent) = on_change.mean();
  x(F::longest_closed) = *std::max_element(memory.closed_cycles.begin(), memory.closed_cycles.end());
  double cycles = 0;
  for (const double c : memory.closed_cycles) cycles += c;
  x(F::mean_closed) = cycles / static_cast<double>(n);
  x(F::closed_deviation) = (off * (rooms.array() - mean)).mean();
  x(F::closed_change_recent) = (off * (rooms - at.recent.head(n)).array()).mean();
  x(F::closed_change) = (off * (rooms - at.before.head(n)).array()).mean();
  x(F::reopening) = (on_change.array() * (rooms.array() - head_degc)).mean();
  ResidualFeatures f;
  f.x = x.template cast<float>();
  return f;
}

}  // namespace airside
