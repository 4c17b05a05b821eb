#pragma once
// What decide() hands to absorb(): the decision, and what its stages found on the way.

#include "airside/controller/decision.hpp"
#include "airside/forecast/head_features.hpp"
#include "airside/forecast/residual_features.hpp"
#include "airside/learning/replay_ring.hpp"
#include "airside/reading.hpp"
#include "airside/supervision/control_mode.hpp"
#include "airside/topology.hpp"

namespace airside {

/// What an objective proposes, not yet limited. Units: degC.
struct Proposal {
  double setpoint_degc = Decision::none;
  Reason missing = Reason::none;  ///< why there is no setpoint; none: there is one
};

/// A decision that the AHU has not answered yet. Shape: T. Units: SI, but for the scaled row.
template <Topology T, class Scalar>
struct PendingCycle : Decision {
  explicit PendingCycle(const Decision& decision) : Decision(decision) {}

  typename Reading<T>::Vector now =
      Reading<T>::Vector::Zero();                       ///< the checked reading; the last one where there is none
  HeadFeatures features;                                ///< of this decision, where has_features
  ResidualFeatures residual_features;                   ///< of this decision, where has_residual_features
  typename ReplayRing<T, Scalar>::Row completed_row{};  ///< the transition that just ended, where is_completed
  bool has_features = false;
  bool has_residual_features = false;
  bool is_completed = false;
  bool is_usable = false;  ///< the reading may be learned from
  bool flows = true;       ///< air flows, so that supply air can follow its setpoint
};

}  // namespace airside
