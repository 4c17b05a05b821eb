#pragma once
// The controller: decide() validates, scales, predicts, scores, blends and limits; absorb() remembers what was
// really applied and learns from it, a bounded number of steps, on shadow weights that must pass a gate. All of it
// is one object of fixed size.

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "airside/canary.hpp"
#include "airside/confidence.hpp"
#include "airside/decision.hpp"
#include "airside/envelope.hpp"
#include "airside/expert.hpp"
#include "airside/learner.hpp"
#include "airside/network.hpp"
#include "airside/network_forward.hpp"
#include "airside/plant.hpp"
#include "airside/replay_ring.hpp"
#include "airside/room_head.hpp"
#include "airside/row_window.hpp"
#include "airside/scaler.hpp"
#include "airside/scores.hpp"
#include "airside/settings.hpp"
#include "airside/splitmix64.hpp"
#include "airside/validation.hpp"

namespace airside {

/// Counts up whenever the meaning of a byte of LearningState or CycleState changes, sizes apart: saved state of another
/// number is not read.
constexpr std::uint32_t state_version = 2;

/// What learning has produced: saved as one generation. Plain bytes, no pointers.
template <Topology T, class Scalar>
struct LearningState {
  NetworkWeights<T, Scalar> weights;  ///< in use
  Learner<T, Scalar> learner;         ///< target net, moments, step counter
  RoomHead<T> head;
  Scaler<T> scaler;
  SplitMix64 sampler;
  std::uint64_t cycles = 0;    ///< decisions taken with these weights' ancestors
  std::uint64_t rejected = 0;  ///< updates that the gate refused
};

/// What one row hands to the next. Plain bytes, small: saved every row.
template <Topology T>
struct CycleState {
  Validator<T> validator{};
  typename Reading<T>::Vector last_value = Reading<T>::Vector::Zero();  ///< at the last decision
  typename Reading<T>::Vector row_value = Reading<T>::Vector::Zero();   ///< at the last row in between
  CivilTime last_time;
  CivilTime row_time;
  HeadFeatures features;  ///< of the last decision, its own setpoint change left 0
  double last_setpoint_degc = std::numeric_limits<double>::quiet_NaN();  ///< applied since last_time
  double before_setpoint_degc = std::numeric_limits<double>::quiet_NaN();
  double confidence = 0.5;
  double network_expected_degc = std::numeric_limits<double>::quiet_NaN();
  double head_expected_degc = std::numeric_limits<double>::quiet_NaN();
  double network_error_k2 = 0.01;  ///< running mean of squared one-cycle errors
  double head_error_k2 = 0.01;
  std::int32_t usable_cycles = 0;  ///< successive cycles whose readings may be learned from, up to 3
  std::int32_t has_weights = 0;    ///< 0: schedule only
  std::int32_t has_features = 0;   ///< 1: `features` are good
  std::int32_t reserved = 0;
};

/// Controls one AHU. Shape: T. Scalar: float on the box, double in tests.
/// Cost: see `airside footprint`; nothing is allocated, ever.  Source: spec 6.5, DESIGN.md decisions 1-4, 10.
template <Topology T, class Scalar = float>
class Controller {
 public:
  using L = Layout<T>;
  using Vector = typename Reading<T>::Vector;
  using Row = typename ReplayRing<T, Scalar>::Row;

  Controller() { configure(product_settings(), default_limits<T>(), strict_kernels<Scalar>(), 1); }

  /// Sets everything that is not learned and starts anew without weights: the schedule until some are given.
  void configure(const ControllerSettings& settings, const LimitsTable<T>& limits, const Kernels<Scalar>& kernels,
                 std::uint64_t seed) {
    settings_ = settings;
    limits_ = limits;
    scratch_.kernels = kernels;
    learning_.sampler = SplitMix64(seed);
    learning_.weights.values.fill(0);
    learning_.learner.reset(learning_.weights);
    learning_.scaler = Scaler<T>();
    learning_.cycles = learning_.rejected = 0;
    learning_.head.reset(settings, settings.head_gain_prior, settings.head_gain_prior_sd);
    cycle_ = CycleState<T>();
    cycle_.validator = Validator<T>(limits, settings.hold_s);
    cycle_.confidence = settings.confidence_initial;
    replay_.clear();
    learner_settings_.loss.weights = {settings.weight_strb, settings.weight_tdb, settings.weight_gc, settings.weight_rc,
                                      settings.weight_rec};
    learner_settings_.loss.gamma = settings.gamma;
    learner_settings_.loss.labels = relation_labels<T>(settings.label_vav);
    learner_settings_.adam = {settings.learning_rate, settings.adam_beta1, settings.adam_beta2, settings.adam_epsilon};
    learner_settings_.sync_every = settings.target_sync_steps;
    make_candidates();
  }

  /// Takes a scaler, and the weights that stand in learning(), as the start: target net a copy, moments zero (spec 8).
  void start(const Scaler<T>& scaler) {
    learning_.scaler = scaler;
    learning_.learner.reset(learning_.weights);
    cycle_.has_weights = 1;
    prepare();
  }

  /// Adds one transition of a history, SI units: `before`, setpoint held for a cycle, `after`.
  void remember(const Vector& before, double setpoint_degc, const Vector& after) {
    replay_.push(transition(before, setpoint_degc, after));
  }

  /// Lets the room head learn from a history's row. Overlapping rows carry less news each: noise_factor > 1.
  void remember_change(CivilTime t, const HeadFeatures& f, double moved_k, double noise_factor) {
    learning_.head.update(settings_, t, f, moved_k, noise_factor);
  }

  /// A row between two decisions: keeps the validator's memory.
  void observe(CivilTime t, const Expected<Reading<T>>& sensed) {
    resumed_ = false;
    if (!sensed) return;
    const Expected<ValidReading<T>> valid = check(t, *sensed);
    if (!valid || !valid->learnable()) return;
    cycle_.row_value = valid->value();
    cycle_.row_time = t;
  }

  /// Chooses the next setpoint.  validate -> scale -> predict -> score -> blend -> limit.
  /// Errors: none; every fault is in the decision, and degrades it to the schedule.
  const Decision& decide(CivilTime t, const Expected<Reading<T>>& sensed) {
    const SafetyEnvelope envelope(settings_);
    const double expert = expert_setpoint_degc(settings_, t);
    if (sensed && !(resumed_ && t.seconds - cycle_.last_time.seconds == cycle_s)) adopt_setpoint(sensed->setpoint_degc);
    resumed_ = false;
    decision_ = {.time = t, .command = envelope.limit(expert, cycle_.last_setpoint_degc, expert)};
    decision_.expert_degc = expert;
    decision_.confidence = cycle_.confidence;
    completed_ = false;
    usable_ = false;
    has_features_ = false;
    if (!sensed) {
      decision_.fault = sensed.error();
      return decision_;
    }
    const Expected<ValidReading<T>> valid = check(t, *sensed);
    if (!valid) {
      decision_.fault = valid.error();
      decision_.fault_signal = cycle_.validator.lost_signal();
      return decision_;
    }
    now_ = valid->value();
    usable_ = valid->learnable();
    if (!usable_) name_held_signal();
    decision_.room_mean_degc = valid->room_mean_degc();
    judge(t);
    if (cycle_.has_weights == 0) return decision_;
    decision_.mode = usable_ ? Mode::learn : Mode::run;
    propose(t, envelope, cycle_.last_setpoint_degc);
    return decision_;
  }

  /// Remembers what the AHU took and learns from the cycle that just ended.
  /// Errors: a refused command is remembered as unknown, and nothing is learned from the cycle it would have begun.
  void absorb(const Expected<Applied>& applied) {
    const double setpoint = applied ? applied->setpoint_degc : std::numeric_limits<double>::quiet_NaN();
    if (!applied && decision_.fault == Fault::none) decision_.fault = Fault::not_applied;
    cycle_.network_expected_degc = cycle_.head_expected_degc = Decision::none;
    if (usable_ && std::isfinite(setpoint)) expect(decision_.time, setpoint);
    if (completed_) replay_.push(newest_);
    if (completed_ && decision_.mode == Mode::learn) learn();
    const bool follows = decision_.time.seconds - cycle_.last_time.seconds == cycle_s;
    cycle_.features = features_;
    cycle_.has_features = has_features_ && applied ? 1 : 0;
    cycle_.before_setpoint_degc = cycle_.last_setpoint_degc;
    cycle_.last_value = now_;
    cycle_.last_time = decision_.time;
    cycle_.last_setpoint_degc = setpoint;
    const std::int32_t usable_before = follows ? cycle_.usable_cycles : 0;
    cycle_.usable_cycles = usable_ && applied ? std::min<std::int32_t>(usable_before + 1, 3) : 0;
    ++learning_.cycles;
  }

  const Decision& decision() const { return decision_; }
  const ControllerSettings& settings() const { return settings_; }
  const LimitsTable<T>& limits() const { return limits_; }
  LearningState<T, Scalar>& learning() { return learning_; }
  const LearningState<T, Scalar>& learning() const { return learning_; }
  CycleState<T>& cycle() { return cycle_; }
  const CycleState<T>& cycle() const { return cycle_; }
  ReplayRing<T, Scalar>& replay() { return replay_; }
  const ReplayRing<T, Scalar>& replay() const { return replay_; }
  NetworkScratch<T, Scalar>& scratch() { return scratch_; }
  const LearnerSettings<T>& learner_settings() const { return learner_settings_; }

  /// Rebuilds what is derived from the saved state; call after learning() or cycle() were overwritten.
  /// Errors: state_invalid if the saved numbers are not finite; the controller then has no weights.
  Fault restored() {
    cycle_.validator.use_limits(limits_, settings_.hold_s);
    if (!all_finite(learning_.weights) || !learning_.head.finite() || !learning_.scaler.finite() ||
        !std::isfinite(cycle_.confidence)) {
      cycle_.has_weights = 0;
      return Fault::state_invalid;
    }
    learning_.head.complete_day_types(settings_);  // the site file may ask for a second day type since
    prepare();
    resumed_ = true;
    return Fault::none;
  }

  /// A decision before there was any: the schedule's night setpoint, faultless.
  static Decision schedule_decision() {
    const ControllerSettings s = product_settings();
    return {.time = {}, .command = SafetyEnvelope(s).limit(s.expert_off_degc, s.expert_off_degc, s.expert_off_degc)};
  }
  /// Puts back the last decision, which rows between two decisions still show.
  void restore_decision(const Decision& decision) { decision_ = decision; }

  /// One optimiser step on the replay; for a host that fine-tunes.  Errors: returns the losses before the step.
  LossTerms train_step() {
    const LossTerms terms = step_on_replay(learning_.weights);
    return terms;
  }
  /// Makes the weights that train_step() changed the ones in use.
  void prepare() { pack(learning_.weights, scratch_.kernels, packed_); }

 private:
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

  Expected<ValidReading<T>> check(CivilTime t, const Reading<T>& reading) {
    Reading<T> at = reading;
    at.time = t;
    return cycle_.validator.check(at);
  }

  /// The AHU's own word counts: after a start, a refused write or another hand on it, its setpoint is what it shows.
  /// Nothing is learned from the cycle that this breaks.
  void adopt_setpoint(double standing_degc) {
    constexpr double foreign_k = 0.05;  // more than a register's rounding
    const double known = cycle_.last_setpoint_degc;
    if (!std::isfinite(standing_degc)) return;
    if (std::isfinite(known) && std::abs(standing_degc - known) <= foreign_k) return;
    cycle_.last_setpoint_degc = standing_degc;
    cycle_.usable_cycles = 0;
  }

  /// A signal that is held at its last good value is named, though control goes on.
  void name_held_signal() {
    const auto& faults = cycle_.validator.faults();
    for (std::size_t i = 0; i < faults.size() && decision_.fault == Fault::none; ++i) {
      if (faults[i] == Fault::none) continue;
      decision_.fault = faults[i];
      decision_.fault_signal = static_cast<int>(i);
    }
  }

  Row transition(const Vector& before, double setpoint_degc, const Vector& after) const {
    Row row;
    Eigen::Map<Eigen::Matrix<Scalar, L::transition, 1>> x(row.data());
    x.template head<L::signals>() = learning_.scaler.template signals<Scalar>(before);
    x(L::setpoint) = learning_.scaler.template setpoint<Scalar>(setpoint_degc);
    x.template tail<L::signals>() = learning_.scaler.template signals<Scalar>(after);
    return row;
  }

  /// Compares the cycle that just ended with what was expected of it: losses, confidence, the head's update.
  void judge(CivilTime t) {
    const bool follows = t.seconds - cycle_.last_time.seconds == cycle_s && usable_ && cycle_.usable_cycles >= 1;
    if (!follows) return;
    const double moved = decision_.room_mean_degc - room_mean(cycle_.last_value);
    if (settings_.head != 0) take_features(t);
    if (settings_.head != 0 && cycle_.has_features != 0) {
      HeadFeatures f = cycle_.features;
      f.x(HeadFeatures::setpoint_change) = cycle_.last_setpoint_degc - cycle_.before_setpoint_degc;
      learning_.head.grow(settings_, 1.0 / cycles_per_day);
      learning_.head.update(settings_, cycle_.last_time, f, moved);
    }
    if (cycle_.has_weights == 0) return;
    newest_ = transition(cycle_.last_value, cycle_.last_setpoint_degc, now_);
    completed_ = true;
    decision_.loss = learning_.learner.loss_of(learning_.weights, newest_, learner_settings_.loss, scratch_);
    const double network_error = decision_.room_mean_degc - cycle_.network_expected_degc;
    const double head_error = decision_.room_mean_degc - cycle_.head_expected_degc;
    track(cycle_.network_error_k2, network_error);
    track(cycle_.head_error_k2, head_error);
    double loss = settings_.confidence_strb_only != 0 ? decision_.loss.strb : decision_.loss.total;
    if (settings_.confidence_error_k > 0) {
      const double error = std::isfinite(head_error) ? head_error : network_error;
      if (!std::isfinite(error)) return;
      loss = (error / settings_.confidence_error_k) * (error / settings_.confidence_error_k);
    }
    cycle_.confidence = confidence_step(settings_, cycle_.confidence, loss);
    decision_.confidence = cycle_.confidence;
  }

  /// predict -> score -> blend -> limit.
  void propose(CivilTime t, const SafetyEnvelope& envelope, double last_degc) {
    scaled_ = learning_.scaler.template signals<Scalar>(now_);
    decision_.network_degc = network_choice(last_degc);
    decision_.head_degc = head_choice(t, last_degc);
    double chosen = decision_.network_degc;
    if (std::isfinite(decision_.head_degc)) {
      // Inverse-variance weights: the forecast that has erred less counts more; head_weight 1 leaves the head alone.
      const double w = settings_.head_weight;
      const double head = w * cycle_.network_error_k2;
      const double network = (1.0 - w) * cycle_.head_error_k2;
      decision_.head_share = std::isfinite(chosen) && head + network > 0 ? head / (head + network) : 1.0;
      chosen = std::isfinite(chosen)
                   ? decision_.head_share * decision_.head_degc + (1.0 - decision_.head_share) * chosen
                   : decision_.head_degc;
    }
    if (!std::isfinite(chosen)) {
      decision_.mode = Mode::expert;
      decision_.fault = Fault::forecast_invalid;
      return;
    }
    const double proposal = fuse(effective_confidence(settings_, cycle_.confidence), chosen, decision_.expert_degc);
    const double in_range = std::clamp(proposal, settings_.action_min_degc, settings_.action_max_degc);
    decision_.command = envelope.limit(in_range, last_degc, decision_.expert_degc);
  }

  double network_choice(double last_degc) {
    const int best = choose({candidates_.data(), static_cast<std::size_t>(candidate_count_)}, last_degc);
    if (best < 0) return unknown;
    const double coarse = candidates_[static_cast<std::size_t>(best)];
    if (settings_.refine_step_k <= 0) return coarse;
    const double step = settings_.refine_step_k;
    const int half = std::min(static_cast<int>(std::lround(settings_.action_step_k / step)), (max_candidates - 1) / 2);
    int n = 0;
    for (int i = -half; i <= half; ++i) {
      const double a = coarse + i * step;
      if (a < settings_.action_min_degc - 1e-9 || a > settings_.action_max_degc + 1e-9) continue;
      fine_[static_cast<std::size_t>(n++)] = a;
    }
    const int finer = choose({fine_.data(), static_cast<std::size_t>(n)}, last_degc);
    return finer < 0 ? unknown : fine_[static_cast<std::size_t>(finer)];
  }

  int choose(std::span<const double> candidates_degc, double last_degc) {
    forecast(candidates_degc);
    const double room = room_mean(now_);
    for (std::size_t i = 0; i < candidates_degc.size(); ++i) {
      const double move = std::isfinite(last_degc) ? candidates_degc[i] - last_degc : 0.0;
      scores_[i] = setpoint_score(settings_, room, long_mean(i), move);
    }
    return best_candidate(settings_, {scores_.data(), candidates_degc.size()}, candidates_degc, last_degc);
  }

  void forecast(std::span<const double> candidates_degc) {
    for (std::size_t i = 0; i < candidates_degc.size(); ++i) {
      scaled_setpoints_[i] = learning_.scaler.template setpoint<Scalar>(candidates_degc[i]);
    }
    forecast_candidates<T, Scalar>(packed_, std::span<const Scalar, L::signals>(scaled_.data(), L::signals),
                                   {scaled_setpoints_.data(), candidates_degc.size()}, scratch_, forecasts_);
  }

  double short_mean(std::size_t i) const {
    double sum = 0;
    for (const Scalar s : forecasts_[i].short_term) sum += static_cast<double>(s);
    return learning_.scaler.room_mean() + learning_.scaler.room_scale() * sum / L::rooms;
  }
  double long_mean(std::size_t i) const {
    double sum = 0;
    for (const Scalar d : forecasts_[i].deviation) sum += static_cast<double>(d);
    return short_mean(i) + learning_.scaler.room_scale() * sum / L::rooms;
  }

  double head_choice(CivilTime t, double last_degc) {
    if (!has_features_ || learning_.head.updates() == 0) return unknown;
    const double wish = learning_.head.setpoint_degc(settings_, t, features_, room_mean(now_), last_degc);
    if (!std::isfinite(wish)) return unknown;  // before the clamp, which would make a bound of an infinite one
    return std::clamp(wish, settings_.action_min_degc, settings_.action_max_degc);
  }

  /// What network and head expect of the cycle that begins now, at the setpoint that was really applied.
  void expect(CivilTime t, double setpoint_degc) {
    if (cycle_.has_weights == 0) return;
    scaled_ = learning_.scaler.template signals<Scalar>(now_);
    forecast({&setpoint_degc, 1});
    cycle_.network_expected_degc = short_mean(0);
    decision_.expected_mean_degc = cycle_.network_expected_degc;
    if (!has_features_) return;
    cycle_.head_expected_degc = room_mean(now_) + learning_.head.drift_k(settings_, t, features_) +
                                learning_.head.gain(settings_) * (setpoint_degc - cycle_.last_setpoint_degc);
    if (std::isfinite(cycle_.head_expected_degc)) decision_.expected_mean_degc = cycle_.head_expected_degc;
  }

  /// A bounded number of steps on shadow weights; they replace the ones in use only if they pass the gate.
  void learn() {
    if (settings_.updates_per_cycle == 0 || replay_.size() == 0) return;
    shadow_ = learning_.weights;
    for (int i = 0; i < settings_.updates_per_cycle; ++i) (void)step_on_replay(shadow_);
    // Weights that are no numbers are refused with or without the gate: nothing could learn its way back from them.
    if (settings_.gate != 0 ? !gate_passes() : !all_finite(shadow_)) {
      ++learning_.rejected;
      learning_.learner.reset(learning_.weights);
      if (decision_.fault == Fault::none) decision_.fault = Fault::learning_rejected;
      return;
    }
    learning_.weights = shadow_;
    prepare();
  }

  LossTerms step_on_replay(NetworkWeights<T, Scalar>& weights) {
    const std::size_t wanted = static_cast<std::size_t>(settings_.batch);
    const int drawn = replay_.sample(learning_.sampler, {index_.data(), wanted}, settings_.recent_in_batch);
    int n = 0;
    for (int i = 0; i < drawn; ++i) {
      const std::uint32_t slot = index_[static_cast<std::size_t>(i)];
      if (settings_.gate == 0 || !held_back(slot)) index_[static_cast<std::size_t>(n++)] = slot;
    }
    if (n == 0) return {};
    return learning_.learner.step(weights, replay_.view({index_.data(), static_cast<std::size_t>(n)}),
                                  learner_settings_, scratch_);
  }

  /// Every tenth slot of the ring is never trained on when the gate is on: it judges.
  static constexpr bool held_back(std::uint32_t slot) { return slot % 10 == 9; }

  /// Finite, not worse on the held-back slots than gate_loss_ratio allows, and no wilder on canary states.
  bool gate_passes() {
    if (!all_finite(shadow_)) return false;
    const std::uint32_t slots = static_cast<std::uint32_t>(replay_.size());
    const std::uint32_t held = slots / 10;
    if (held > 0) {
      const std::uint32_t n = std::min<std::uint32_t>(held, 64);
      for (std::uint32_t i = 0; i < n; ++i) index_[i] = 10 * (i * held / n) + 9;
      const auto batch = replay_.view({index_.data(), n});
      const double before = learning_.learner.evaluate(learning_.weights, batch, learner_settings_.loss, scratch_).strb;
      const double after = learning_.learner.evaluate(shadow_, batch, learner_settings_.loss, scratch_).strb;
      if (!(after <= settings_.gate_loss_ratio * before + 1e-3)) return false;
    }
    return canary_passes();
  }

  /// Sane on canary states, or at least no wilder than the weights in use: else weights that were strange from the
  /// start could never learn their way out.
  bool canary_passes() {
    const double excess_in_use = canary_excess_k<T>(settings_, learning_.scaler, packed_, scratch_);
    pack(shadow_, scratch_.kernels, packed_);
    const double excess = canary_excess_k<T>(settings_, learning_.scaler, packed_, scratch_);
    pack(learning_.weights, scratch_.kernels, packed_);
    return std::isfinite(excess) && excess <= excess_in_use;
  }

  /// The regressors of now. A row that was missed 6 min ago is thought to lie on the line from the last decision.
  void take_features(CivilTime t) {
    Vector recent = cycle_.row_value;
    if (t.seconds - cycle_.row_time.seconds != row_s) recent = now_ - (now_ - cycle_.last_value) / rows_per_cycle;
    const double move = cycle_.last_setpoint_degc - cycle_.before_setpoint_degc;
    features_ = RoomHead<T>::features({.before = cycle_.last_value,
                                       .recent = recent,
                                       .now = now_,
                                       .setpoint_before_degc = cycle_.last_setpoint_degc,
                                       .last_move_k = std::isfinite(move) ? move : 0.0},
                                      learning_.scaler.scale(L::power + T::powers - 1));
    has_features_ = true;
  }

  static double room_mean(const Vector& v) { return v.template head<L::rooms>().mean(); }

  static void track(double& mean_square, double error) {
    constexpr double memory = 0.05;  // about a working day of cycles
    if (std::isfinite(error)) mean_square += memory * (error * error - mean_square);
  }

  void make_candidates() {
    const double span = settings_.action_max_degc - settings_.action_min_degc;
    candidate_count_ = std::min(static_cast<int>(std::lround(span / settings_.action_step_k)) + 1, max_candidates);
    for (int i = 0; i < candidate_count_; ++i) {
      candidates_[static_cast<std::size_t>(i)] =
          std::min(settings_.action_min_degc + i * settings_.action_step_k, settings_.action_max_degc);
    }
  }

  ControllerSettings settings_;
  LimitsTable<T> limits_{};
  LearnerSettings<T> learner_settings_;

  LearningState<T, Scalar> learning_;
  CycleState<T> cycle_;
  ReplayRing<T, Scalar> replay_;

  NetworkWeights<T, Scalar> shadow_;
  PackedWeights<T, Scalar> packed_;
  NetworkScratch<T, Scalar> scratch_;

  Decision decision_ = schedule_decision();
  Vector now_ = Vector::Zero();
  Row newest_{};
  bool completed_ = false;  ///< newest_ is a transition that just ended
  HeadFeatures features_;
  bool has_features_ = false;  ///< features_ are those of the present decision
  bool usable_ = false;        ///< the present reading may be learned from
  bool resumed_ = false;       ///< no row since restored(): a setpoint that stands there may be of a decision cut off

  int candidate_count_ = 0;
  Eigen::Matrix<Scalar, L::signals, 1> scaled_;
  std::array<double, max_candidates> candidates_{}, fine_{}, scores_{};
  std::array<Scalar, max_candidates> scaled_setpoints_{};
  std::array<RoomForecast<T, Scalar>, max_candidates> forecasts_{};
  std::array<std::uint32_t, max_batch> index_{};
};

}  // namespace airside
