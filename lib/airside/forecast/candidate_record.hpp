#pragma once
// What one decision weighed: the candidates, what was forecast of each, and what was made of them. For people alone; no
// decision reads it, and it is not saved.

#include <array>
#include <cstddef>
#include <limits>

#include "airside/civil_time.hpp"

namespace airside {

/// Candidates of one decision, from_degc + i step_k, i < count; of more than `most` every second, third, ... one.
/// Shape: count <= most. Units: in the names; a score is in degC, the highest is best. NaN: there was none.
struct CandidateRecord {
  static constexpr int most = 64;
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  using Values = std::array<float, static_cast<std::size_t>(most)>;

  CivilTime time;  ///< of the decision; 0: there was none since the start
  int count = 0;
  double from_degc = none, step_k = none;
  Values network_degc{};  ///< held value that the network forecasts and scores, objective "mean"
  Values score{};         ///< by setpoint_score()
  Values cost_kw{};       ///< objective "band": power, and discomfort as power; the lowest is best
  bool has_network = false, has_cost = false;
  double head_from_degc = none;  ///< held value that the room head forecasts for the end of the cycle at from_degc
  double head_gain = none;       ///< by which that changes with the setpoint, K/K
  double head_aim_degc = none;   ///< held value that the head wants by the end of the cycle
  double schedule_share = none;  ///< weight of the schedule in proposed_degc
  double proposed_degc = none;   ///< blended, before the limits

  /// A decision at t, of which nothing is known yet.
  void begin(CivilTime t) {
    time = t;
    count = 0;
    has_network = has_cost = false;
    from_degc = step_k = head_from_degc = head_gain = head_aim_degc = schedule_share = proposed_degc = none;
  }
  /// Takes a grid of n candidates; returns the stride: candidate i is number i * stride of the grid.
  int take_grid(double first_degc, double grid_step_k, int n) {
    const int stride = (n + most - 1) / most;
    from_degc = first_degc;
    step_k = stride * grid_step_k;
    count = stride > 0 ? (n + stride - 1) / stride : 0;
    return stride;
  }
};

}  // namespace airside
