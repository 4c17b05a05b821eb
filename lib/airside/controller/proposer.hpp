#pragma once
// Proposing: which setpoint network and room head would choose together, and what they expect of the one applied.

#include <algorithm>
#include <cmath>
#include <limits>

#include "airside/civil_time.hpp"
#include "airside/controller/pending_cycle.hpp"
#include "airside/forecast/candidate_record.hpp"
#include "airside/forecast/candidate_search.hpp"
#include "airside/forecast/head_features.hpp"
#include "airside/forecast/residual_features.hpp"
#include "airside/forecast/room_head.hpp"
#include "airside/held_rooms.hpp"
#include "airside/learning/learning_state.hpp"
#include "airside/network/scaler.hpp"
#include "airside/network/scratch.hpp"
#include "airside/reading.hpp"
#include "airside/settings.hpp"
#include "airside/supervision/confidence.hpp"
#include "airside/supervision/schedule.hpp"
#include "airside/topology.hpp"

namespace airside {

/// predict -> score -> blend.  Keeps the candidates' memory; the state that it reads is given to each call.
/// Shape: T. Cost: that of CandidateSearch and one row of the head.
template <Topology T, class Scalar>
class Proposer {
 public:
  using L = Layout<T>;
  using Vector = typename Reading<T>::Vector;
  using Pending = PendingCycle<T, Scalar>;

  void configure(const ControllerSettings& settings) { search_.configure(settings); }
  CandidateSearch<T, Scalar>& search() { return search_; }
  CandidateRecord& record() { return record_; }
  const CandidateRecord& record() const { return record_; }

  /// The regressors of now.
  static void take_features(const ControllerSettings& s, const CycleState<T>& cycle, const Scaler<T>& scaler,
                            Pending& at) {
    const Vector recent = recent_of(s, cycle, at);
    at.features = head_features<T>(instants(s, cycle, recent, at), s.shape, scaler.head_power_scale(s.shape));
    at.has_features = true;
  }

  /// Fills in both choices, and in record() what they were made of; returns the setpoint made of them and the
  /// schedule's, degC.
  /// Errors: NaN if neither network nor head gives a number.
  double propose(const ControllerSettings& s, const LearningState<T, Scalar>& learning, const CycleState<T>& cycle,
                 NetworkScratch<T, Scalar>& scratch, Pending& at) {
    const ForecastModel<T, Scalar> model{learning.scaler, scratch.packed, scratch};
    at.network_degc = search_.best_degc(s, model, at.now, cycle.last_setpoint_degc, &record_);
    at.head_degc = head_choice(s, learning.head, cycle.last_setpoint_degc, 0.0, at);
    if (std::isfinite(at.head_degc)) correct(s, learning, cycle, at);
    double chosen = at.network_degc;
    if (std::isfinite(at.head_degc)) {
      // Inverse-variance weights: the forecast that has erred less counts more; head_weight 1 leaves the head alone.
      const double w = s.head_weight;
      const double head = w * cycle.network_error_k2;
      const double network = (1.0 - w) * cycle.head_error_k2;
      at.head_share = std::isfinite(chosen) && head + network > 0 ? head / (head + network) : 1.0;
      chosen = std::isfinite(chosen) ? at.head_share * at.head_degc + (1.0 - at.head_share) * chosen : at.head_degc;
    }
    if (!std::isfinite(chosen)) return unknown;
    const double trust = effective_confidence(s, cycle.confidence);
    if (std::isfinite(at.head_degc)) note_head(s, learning.head, cycle.last_setpoint_degc, at);
    record_.schedule_share = 1.0 - trust;
    record_.proposed_degc = fuse(trust, chosen, at.expert_degc);
    return record_.proposed_degc;
  }

  /// What network and head expect of the cycle that begins now, at the setpoint that was really applied, NaN: none.
  /// Returns the expectation that counts, degC, or NaN.
  double expect(const ControllerSettings& s, const LearningState<T, Scalar>& learning, CycleState<T>& cycle,
                NetworkScratch<T, Scalar>& scratch, const Pending& at, double applied_degc) {
    cycle.network_expected_degc = cycle.head_expected_degc = unknown;
    if (cycle.has_weights == 0 || !at.is_usable || !std::isfinite(applied_degc)) return unknown;
    const ForecastModel<T, Scalar> model{learning.scaler, scratch.packed, scratch};
    cycle.network_expected_degc = search_.expected_degc(s, model, at.now, applied_degc);
    if (!at.has_features) return cycle.network_expected_degc;
    cycle.head_expected_degc = held(s, at.now) + learning.head.drift_k(s, at.time, at.features) +
                               learning.head.gain(s) * (applied_degc - cycle.last_setpoint_degc);
    if (!std::isfinite(cycle.head_expected_degc)) return cycle.network_expected_degc;
    return cycle.head_expected_degc + used_residual_k(at);
  }

  /// Root mean square of the errors of the forecasts that count, over about the last 20 cycles, K; NaN: there is no
  /// forecast. Equation: q <- q + 0.05 (e^2 - q) each cycle, e the error of the head's forecast, else of the network's.
  static double expected_error_k(const CycleState<T>& cycle) {
    if (std::isfinite(cycle.head_expected_degc)) return std::sqrt(cycle.head_error_k2);
    return std::isfinite(cycle.network_expected_degc) ? std::sqrt(cycle.network_error_k2) : unknown;
  }

 private:
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  /// A row that was missed 6 min ago is taken to lie on the line from the last decision.
  static Vector recent_of(const ControllerSettings& s, const CycleState<T>& cycle, const Pending& at) {
    if (at.time.seconds - cycle.row_time.seconds == row_s) return cycle.row_value;
    return at.now - (at.now - cycle.last_value) / control_cycle(s).rows;
  }

  static HeadInstants<T> instants(const ControllerSettings& s, const CycleState<T>& cycle, const Vector& recent,
                                  const Pending& at) {
    const double move = cycle.last_setpoint_degc - cycle.before_setpoint_degc;
    return {.before = cycle.last_value,
            .recent = recent,
            .now = at.now,
            .setpoint_before_degc = cycle.last_setpoint_degc,
            .last_move_k = std::isfinite(move) ? move : 0.0,
            .held = s.held};
  }

  /// The head's choice with its own error foreseen, in working hours: nothing else was learned from.
  static void correct(const ControllerSettings& s, const LearningState<T, Scalar>& learning, const CycleState<T>& cycle,
                      Pending& at) {
    if (!cycle.residual.is_complete() || !in_working_hours(s, at.time)) return;
    const Vector recent = recent_of(s, cycle, at);
    at.residual_features =
        residual_features<T>(s, at.time, instants(s, cycle, recent, at), cycle.residual, at.head_degc);
    at.has_residual_features = true;
    if (learning.residual.network.is_trained == 0) return;
    at.residual_k = learning.residual.network.forecast_k(at.residual_features);
    at.residual_share = learning.residual.gate.share();
    at.head_degc = head_choice(s, learning.head, cycle.last_setpoint_degc, used_residual_k(at), at);
  }

  static double used_residual_k(const Pending& at) {
    return std::isfinite(at.residual_k) ? at.residual_share * at.residual_k : 0.0;
  }

  static double head_choice(const ControllerSettings& s, const RoomHead<T>& head, double last_degc, double residual_k,
                            const Pending& at) {
    if (!at.has_features || head.updates() == 0) return unknown;
    const double ideal = head.setpoint_degc(s, at.time, at.features, held(s, at.now), last_degc, residual_k);
    if (!std::isfinite(ideal)) return unknown;  // before the clamp, which would make a bound of an infinite one
    return std::clamp(ideal, s.action_min_degc, s.action_max_degc);
  }

  /// The head's forecast is a line over the candidates.
  void note_head(const ControllerSettings& s, const RoomHead<T>& head, double last_degc, const Pending& at) {
    const double now = held(s, at.now);
    record_.head_gain = head.gain(s);
    record_.head_from_degc = now + head.drift_k(s, at.time, at.features) + used_residual_k(at) +
                             record_.head_gain * (record_.from_degc - last_degc);
    record_.head_aim_degc = now + s.head_correction * (s.target_degc - now);
  }

  static double held(const ControllerSettings& s, const Vector& v) { return held_degc<T>(s.held, s.shape, v); }

  CandidateSearch<T, Scalar> search_;
  CandidateRecord record_;  ///< of the last decision
};

}  // namespace airside
