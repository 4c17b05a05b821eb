#pragma once
// Judging: the cycle that just ended against what was expected of it.

#include <cmath>

#include "airside/civil_time.hpp"
#include "airside/controller/pending_cycle.hpp"
#include "airside/controller/supervisor.hpp"
#include "airside/forecast/head_features.hpp"
#include "airside/held_rooms.hpp"
#include "airside/learning/learning_state.hpp"
#include "airside/learning/transition_row.hpp"
#include "airside/network/learner.hpp"
#include "airside/network/scratch.hpp"
#include "airside/settings.hpp"
#include "airside/supervision/confidence.hpp"
#include "airside/supervision/control_mode.hpp"
#include "airside/topology.hpp"

namespace airside {

/// Forecast errors, losses, confidence, the head's update. Works on the state of one controller, which must outlive it.
/// Shape: T. Cost: one Kalman update and one evaluation of the losses.
template <Topology T, class Scalar>
class CycleJudge {
 public:
  using L = Layout<T>;
  CycleJudge(const ControllerSettings& settings, const LearnerSettings<T>& learner_settings,
             LearningState<T, Scalar>& learning, CycleState<T>& cycle, NetworkScratch<T, Scalar>& scratch)
      : settings_(settings),
        learner_settings_(learner_settings),
        learning_(learning),
        cycle_(cycle),
        scratch_(scratch),
        supervisor_(settings, cycle) {}

  /// Whether a whole cycle ends at t whose readings may be learned from.
  bool has_ended(CivilTime t, bool is_usable) const {
    return t.seconds - cycle_.last_time.seconds == control_cycle(settings_).seconds() && is_usable &&
           cycle_.usable_cycles >= 1;
  }

  /// Fills in what the cycle that ended shows: errors, losses, confidence, the completed row.
  void judge(PendingCycle<T, Scalar>& at) {
    const CivilTime t = at.time;
    const bool doubted = supervisor_.doubted(t, at.flows);
    if (settings_.head != 0 && cycle_.has_features != 0) teach_head(at, doubted);
    if (cycle_.has_weights == 0) return;
    supervisor_.compare_with_schedule(t, at.held_degc, learning_.head.gain(settings_));
    at.completed_row = to_row<T, Scalar>(learning_.scaler, cycle_.last_value, cycle_.last_setpoint_degc, at.now);
    at.is_completed = !doubted;
    at.loss = learning_.learner.loss_of(learning_.weights, at.completed_row, learner_settings_.loss, scratch_);
    const double come_to_degc = held_after_degc<T>(settings_.held, settings_.shape, cycle_.last_value, at.now);
    at.network_error_k = come_to_degc - cycle_.network_expected_degc;
    at.head_error_k = come_to_degc - cycle_.head_expected_degc;
    track(cycle_.network_error_k2, at.network_error_k);
    track(cycle_.head_error_k2, at.head_error_k);
    cycle_.residual.end_cycle(at.head_error_k);
    learning_.residual.gate.judge(at.head_error_k, cycle_.residual.forecast_k);
    judge_confidence(at);
  }

 private:
  void teach_head(const PendingCycle<T, Scalar>& at, bool doubted) {
    const double begun_degc = held_degc<T>(settings_.held, settings_.shape, cycle_.last_value);
    const double moved_k = held_after_degc<T>(settings_.held, settings_.shape, cycle_.last_value, at.now) - begun_degc;
    HeadFeatures f = cycle_.features;
    f.x(HeadFeatures::setpoint_change) = cycle_.last_setpoint_degc - cycle_.before_setpoint_degc;
    learning_.head.grow(settings_, 1.0 / control_cycle(settings_).per_day());
    if (!doubted) learning_.head.update(settings_, cycle_.last_time, f, moved_k);
    supervisor_.watch_gain(at.time, learning_.head);
  }

  /// From the error of the forecast that controls, or from the network's loss, as the settings have it.
  void judge_confidence(PendingCycle<T, Scalar>& at) {
    double loss = settings_.confidence_strb_only != 0 ? at.loss.strb : at.loss.total;
    if (settings_.confidence_error_k > 0) {
      const double error = std::isfinite(at.head_error_k) ? at.head_error_k : at.network_error_k;
      if (!std::isfinite(error)) return;
      loss = (error / settings_.confidence_error_k) * (error / settings_.confidence_error_k);
    }
    cycle_.confidence = confidence_step(settings_, cycle_.confidence, loss);
    at.confidence = cycle_.confidence;
    constexpr double least = 0.05;
    const bool is_silent = effective_confidence(settings_, cycle_.confidence) < least;
    cycle_.mode_arbiter.set(Reason::forecasts_doubted, cycle_.no_confidence.lasts(is_silent, at.time, seconds_per_day),
                            at.time);
  }

  static void track(double& mean_square, double error) {
    constexpr double memory = 0.05;  // 20 cycles: six hours with 18 min
    if (std::isfinite(error)) mean_square += memory * (error * error - mean_square);
  }

  const ControllerSettings& settings_;
  const LearnerSettings<T>& learner_settings_;
  LearningState<T, Scalar>& learning_;
  CycleState<T>& cycle_;
  NetworkScratch<T, Scalar>& scratch_;
  Supervisor<T> supervisor_;
};

}  // namespace airside
