#pragma once
// Which candidate setpoint is best, given what the network expects of each. Five rooms become one number first
// (their mean): per-room scores freeze the controller as soon as one room is at target (docs/method.md, open point 14).

#include <cmath>
#include <cstddef>
#include <span>

#include "airside/settings.hpp"

namespace airside {

/// score = |S - T| - a_s |S_long - T| - b_s |S_long - S| - move (a - a_last)^2.  Units: degC.
/// Source: docs/method.md 6.1.
inline double setpoint_score(const ControllerSettings& s, double room_degc, double room_long_degc, double move_k) {
  return std::abs(room_degc - s.target_degc) - s.score_alpha * std::abs(room_long_degc - s.target_degc) -
         s.score_beta * std::abs(room_long_degc - room_degc) - s.move_penalty * move_k * move_k;
}

/// Index of the best candidate: the highest score; among scores within `tie_degc` of it the one nearest to the last
/// applied setpoint, then the lower one.
/// Shape: scores and candidates of equal length. Errors: -1 if no score is finite.
/// Source: docs/method.md, open point 16.
inline int best_candidate(const ControllerSettings& s, std::span<const double> scores,
                          std::span<const double> candidates_degc, double last_degc) {
  double highest = -HUGE_VAL;
  for (const double score : scores) highest = std::isfinite(score) && score > highest ? score : highest;
  int best = -1;
  const double last = std::isfinite(last_degc) ? last_degc : 0.5 * (s.action_min_degc + s.action_max_degc);
  for (std::size_t i = 0; i < scores.size(); ++i) {
    if (!(scores[i] >= highest - s.tie_degc) || !std::isfinite(scores[i])) continue;
    if (best < 0) {
      best = static_cast<int>(i);
      continue;
    }
    const double d = std::abs(candidates_degc[i] - last);
    const double d_best = std::abs(candidates_degc[static_cast<std::size_t>(best)] - last);
    const bool lower = candidates_degc[i] < candidates_degc[static_cast<std::size_t>(best)];
    if (d < d_best - 1e-9 || (std::abs(d - d_best) <= 1e-9 && lower)) best = static_cast<int>(i);
  }
  return best;
}

}  // namespace airside
