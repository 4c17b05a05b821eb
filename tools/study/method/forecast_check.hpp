#pragma once
// How well weights foresee a logged room, and whether they answer to each input with the sign that physics has.

#include <span>

#include "tools/run/control_run.hpp"

namespace airside::tools {

struct ForecastCheck {
  double mae_k = 0;            ///< mean |S' - S_1| over rooms and transitions, one control cycle ahead
  double violation_share = 0;  ///< of (transition, input) pairs with L_j dS'/dX_j < 0
  double gain_sign_share = 0;  ///< of transitions with d(mean S')/dA > 0
  int transitions = 0;         ///< that the error is of; slopes are of each tenth
};

/// The network of a blob, frozen, on the log's whole cycles.
/// Errors: hal::InputError for a blob that does not fit, or a log without a whole cycle.
ForecastCheck check_forecasts(const Site& site, const BlobBytes& blob, std::span<const hal::LogRow> rows);

}  // namespace airside::tools
