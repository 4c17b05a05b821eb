#pragma once
// Other weights while in control: how far they are from what a room can do, the exchange itself, and the rollback.

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>

#include "airside/forecast/candidate_search.hpp"
#include "airside/forecast/head_features.hpp"
#include "airside/held_rooms.hpp"
#include "airside/learning/canary.hpp"
#include "airside/learning/learning_state.hpp"
#include "airside/learning/replay_ring.hpp"
#include "airside/learning/transition_row.hpp"
#include "airside/network/network.hpp"
#include "airside/network/scaler.hpp"
#include "airside/network/scratch.hpp"
#include "airside/settings.hpp"
#include "airside/supervision/control_mode.hpp"
#include "airside/topology.hpp"

namespace airside {

/// On canary states (canary.hpp), and as the largest error of the one-cycle forecast of the held value on the newest
/// remembered transitions. Units: K, both; infinite for a forecast that is no number.
struct ForecastDeviation {
  double canary_k, replay_k;
};

/// Works on the state of one controller, which must outlive it. Whoever changes weights packs them afterwards.
/// Shape: T.
template <Topology T, class Scalar>
class WeightExchange {
 public:
  using L = Layout<T>;
  using Learning = LearningState<T, Scalar>;
  using Replay = ReplayRing<T, Scalar>;
  WeightExchange(Learning& learning, CycleState<T>& cycle, Replay& replay)
      : learning_(learning), cycle_(cycle), replay_(replay) {}

  /// Leaves `scratch` with the other weights packed. Cost: at most 36 forecasts and a packing.
  ForecastDeviation deviation(const ControllerSettings& settings, CandidateSearch<T, Scalar>& search,
                              NetworkScratch<T, Scalar>& scratch, const Scaler<T>& scaler,
                              const NetworkWeights<T, Scalar>& weights) const {
    pack(weights, scratch.kernels, scratch.packed);
    const ForecastModel<T, Scalar> other{scaler, scratch.packed, scratch};
    ForecastDeviation found{canary_excess_k<T>(settings, scaler, scratch.packed, scratch), 0};
    const int n = std::min(replay_.size(), 32);
    for (int age = 0; age < n; ++age) {
      const Transition<T> past = from_row<T, Scalar>(learning_.scaler, replay_.newest(age));
      const double after_degc = held_after_degc<T>(settings.held, settings.shape, past.before, past.after);
      const double error = search.expected_degc(settings, other, past.before, past.setpoint_degc) - after_degc;
      found.replay_k = std::isfinite(error) ? std::max(found.replay_k, std::abs(error)) : HUGE_VAL;
    }
    return found;
  }

  /// Takes weights and their scaler: the replay is put into their units, target net a copy, moments zero, confidence
  /// at most its initial value.
  void exchange(const ControllerSettings& settings, const Scaler<T>& scaler, std::span<const Scalar> weights) {
    std::copy(weights.begin(), weights.end(), learning_.weights.flat().begin());
    rescale_memories(learning_.scaler, scaler);
    const double before_kw = learning_.scaler.head_power_scale(settings.shape);
    const double after_kw = scaler.head_power_scale(settings.shape);
    learning_.head.rescale_power(after_kw / before_kw);
    cycle_.features.x(HeadFeatures::power_change) *= before_kw / after_kw;
    cycle_.confidence = std::min(cycle_.confidence, settings.confidence_initial);
    forget_comparison();
    learning_.scaler = scaler;
    learning_.learner.reset(learning_.weights);
    cycle_.has_weights = 1;
  }

  /// Goes back to an earlier learning state, whose scaler may differ from the one in use.
  void roll_back(const Learning& before) {
    const Scaler<T> present = learning_.scaler;
    learning_ = before;
    cycle_.has_weights = 1;
    cycle_.has_features = 0;  // they are in the units of the scaler that goes
    rescale_memories(present, learning_.scaler);
    forget_comparison();
  }

  /// The schedule again, until other weights come.
  void drop() {
    cycle_.has_weights = 0;
    forget_comparison();
  }

 private:
  /// Puts the replay from one scaler's units into another's.
  void rescale_memories(const Scaler<T>& from, const Scaler<T>& to) {
    for (int i = 0; i < replay_.size(); ++i) {
      const Transition<T> past = from_row<T, Scalar>(from, replay_.slot(i));
      replay_.slot(i) = to_row<T, Scalar>(to, past.before, past.setpoint_degc, past.after);
    }
  }

  /// Other weights are not judged by what those before them did.
  void forget_comparison() {
    cycle_.network_expected_degc = cycle_.head_expected_degc = std::numeric_limits<double>::quiet_NaN();
    cycle_.shadow.reset();
    cycle_.worse_cycles = 0;
    cycle_.no_confidence = PersistentCondition();
    for (const Reason r : {Reason::worse_than_schedule, Reason::worse_for_long, Reason::forecasts_doubted}) {
      cycle_.mode_arbiter.set(r, false, cycle_.last_time);
    }
  }

  Learning& learning_;
  CycleState<T>& cycle_;
  Replay& replay_;
};

}  // namespace airside
