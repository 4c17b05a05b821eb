#pragma once
// What a controller owns: settings, the saved state, working memory; and the few ways to change them from outside.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <new>  // IWYU pragma: keep: placement
#include <span>

#include "airside/civil_time.hpp"
#include "airside/controller/band_chooser.hpp"
#include "airside/controller/decision.hpp"
#include "airside/controller/proposer.hpp"
#include "airside/controller/weight_exchange.hpp"
#include "airside/fault.hpp"
#include "airside/forecast/head_features.hpp"
#include "airside/forecast/residual_forecaster.hpp"
#include "airside/forecast/room_head.hpp"
#include "airside/learning/learning_state.hpp"
#include "airside/learning/replay_ring.hpp"
#include "airside/learning/shadow_training.hpp"
#include "airside/network/kernels/kernels.hpp"
#include "airside/network/learner.hpp"
#include "airside/network/losses.hpp"
#include "airside/network/network.hpp"
#include "airside/network/scaler.hpp"
#include "airside/presets.hpp"
#include "airside/reading.hpp"
#include "airside/settings.hpp"
#include "airside/splitmix64.hpp"
#include "airside/supervision/control_mode.hpp"
#include "airside/supervision/envelope.hpp"
#include "airside/supervision/mode_arbiter.hpp"
#include "airside/supervision/validation.hpp"
#include "airside/topology.hpp"

namespace airside {

/// For tests that put faults into a controller's memory; nothing else defines it.
template <Topology T, class Scalar>
struct ControllerAccess;

/// Every part can be read; each operation that changes one keeps the parts consistent. Shape: T.
template <Topology T, class Scalar>
class ControllerMemory {
 public:
  using Learning = LearningState<T, Scalar>;
  using Replay = ReplayRing<T, Scalar>;
  using Vector = typename Reading<T>::Vector;

  /// Sets everything that is not learned and starts anew without weights: the schedule until some are given.
  void configure(const ControllerSettings& settings, const LimitsTable<T>& limits, const Kernels<Scalar>& kernels,
                 std::uint64_t seed) {
    settings_ = settings;
    settings_.shape = shape_in<T>(settings.shape);
    limits_ = limits;
    keep_to_shape<T>(settings_.shape, limits_);
    scratch_.kernels = kernels;
    scratch_.site = settings_.shape;
    learning_.sampler = SplitMix64(seed);
    learning_.weights.values.fill(0);
    learning_.learner.reset(learning_.weights);
    learning_.scaler = Scaler<T>();
    learning_.cycles = learning_.rejected = 0;
    learning_.head.reset(settings, settings.head_gain_prior, settings.head_gain_prior_sd);
    learning_.residual = {};
    ::new (static_cast<void*>(&cycle_)) CycleState<T>();  // in place: a whole state is too much for the stack
    cycle_.validator.use_limits(limits_, settings_);
    cycle_.confidence = settings.confidence_initial;
    cycle_.band.reset(settings_.demand);
    replay_.clear();
    learner_settings_ = learner_settings_of<T>(settings);
    proposer_.configure(settings_);
  }

  /// Draws the weights to start from. Source: docs/method.md 5.
  void draw_weights(SplitMix64& draw) { initialise_uniform(learning_.weights, draw, settings_.shape); }
  /// Takes a scaler, and the weights drawn before, as the start: target net a copy, moments zero.
  void start(const Scaler<T>& scaler) {
    learning_.scaler = scaler;
    learning_.learner.reset(learning_.weights);
    cycle_.has_weights = 1;
    prepare();
  }
  /// Takes scaler and weights as the start.  Shape: NetworkWeights::count.
  void start(const Scaler<T>& scaler, std::span<const Scalar> weights) {
    std::ranges::copy(weights, learning_.weights.flat().begin());
    start(scaler);
  }
  /// Memory that holds nothing before the first start: for a blob's payload where there is no other.
  std::span<std::byte> lend_scratch() { return std::as_writable_bytes(std::span(&scratch_, 1)); }
  /// The same start from weights that may lie in the lent scratch, which is made anew.
  void begin_from(const Scaler<T>& scaler, std::span<const Scalar> weights, const Kernels<Scalar>& kernels) {
    std::copy(weights.begin(), weights.end(), learning_.weights.flat().begin());
    learning_.scaler = scaler;
    ::new (static_cast<void*>(&scratch_)) NetworkScratch<T, Scalar>();
    scratch_.kernels = kernels;
    scratch_.site = settings_.shape;
    start(Scaler<T>(learning_.scaler));
  }
  /// Gives the room head an estimate from elsewhere.  Shape: covariance states x states, column-major.
  void take_head(const typename RoomHead<T>::State& theta, std::span<const double> covariance, std::uint32_t updates) {
    learning_.head.theta() = theta;
    std::copy(covariance.begin(), covariance.end(), learning_.head.covariance().data());
    learning_.head.set_updates(updates);
    learning_.head.complete_day_types(settings_);
  }
  /// The residual network begins anew from weights, used until it errs.
  void take_residual(const ResidualNetwork& network) { learning_.residual = {network, {}}; }
  /// The room head begins anew from a gain, K/K.
  void reset_head(double gain, double gain_sd) { learning_.head.reset(settings_, gain, gain_sd); }

  /// Adds one transition of a history, SI units: `before`, setpoint held for a cycle, `after`.
  void remember(const Vector& before, double setpoint_degc, const Vector& after) {
    replay_.push(to_row<T, Scalar>(learning_.scaler, before, setpoint_degc, after));
  }
  /// Lets the objective "band" learn from a history's row; `counts` as in BandChooser.
  void remember_demand(const Reading<T>& sensed, const ValidReading<T>& valid, bool counts) {
    BandChooser<T>(settings_, cycle_).remember(sensed, valid, counts);
  }
  /// Lets the room head learn from a history's row. Overlapping rows carry less news each: noise_factor > 1.
  /// Returns by how much its forecast of the row was wrong before, K.
  double remember_change(CivilTime t, const HeadFeatures& f, double moved_k, double noise_factor) {
    return learning_.head.update(settings_, t, f, moved_k, noise_factor);
  }
  /// One optimiser step on the replay; for a host that fine-tunes.  Returns the losses before the step.
  LossTerms train_step() {
    return training_.step(settings_, learner_settings_, learning_, replay_, scratch_, learning_.weights);
  }
  /// Makes the weights that train_step() changed the ones in use.
  void prepare() { pack(learning_.weights, scratch_.kernels, scratch_.packed); }

  /// How far other weights are from what a room can do. Cost: at most 36 forecasts and two packings.
  ForecastDeviation forecast_deviation(const Scaler<T>& scaler, const NetworkWeights<T, Scalar>& weights) {
    const auto found = weight_exchange().deviation(settings_, proposer_.search(), scratch_, scaler, weights);
    prepare();
    return found;
  }
  /// Takes other weights while in control.
  void exchange(const Scaler<T>& scaler, std::span<const Scalar> weights) {
    weight_exchange().exchange(settings_, scaler, weights);
    prepare();
  }
  /// Goes back to an older learning state.  Errors: state_invalid as restore().
  Fault roll_back(const Learning& before) {
    weight_exchange().roll_back(before);
    resumed_ = false;
    return rebuild();
  }
  /// The schedule again, until other weights come.
  void drop_weights() { weight_exchange().drop(); }
  /// Sets the mean squares of the forecast errors: of weights that come back they are known from before. Units: K^2.
  void take_forecast_errors(double network_k2, double head_k2) {
    cycle_.network_error_k2 = network_k2;
    cycle_.head_error_k2 = head_k2;
  }

  /// The bytes that a store saves; and those that it reads into before restore(), or configure() if that failed.
  using SavedBytes = StateBytes<const std::byte>;
  using LoadedBytes = StateBytes<std::byte>;
  SavedBytes saved_bytes() const {
    return {std::as_bytes(std::span(&learning_, 1)), std::as_bytes(std::span(&replay_.slot(0), Replay::capacity))};
  }
  LoadedBytes loaded_bytes() {
    return {std::as_writable_bytes(std::span(&learning_, 1)),
            std::as_writable_bytes(std::span(&replay_.slot(0), Replay::capacity))};
  }
  /// Goes on from a saved state whose large parts lie in loaded_bytes() already.
  /// Errors: state_invalid if the saved numbers are not finite; the controller then has no weights.
  Fault restore(const CycleState<T>& cycle, std::uint64_t replay_count, const Decision& decision) {
    cycle_ = cycle;
    replay_.restore_count(replay_count);
    decision_ = decision;
    const Fault fault = rebuild();
    resumed_ = fault == Fault::none;
    cycle_.contact = 0;  // a process counts its own from 1, and the device may have restarted before it did
    return fault;
  }

  /// Follows the clock before the first row.
  void tick(CivilTime t) { cycle_.mode_arbiter.tick(t); }
  /// What only the surroundings know (storage, clock, restarts, an operator's wish), from t on until it is taken back.
  void report(Reason reason, bool is_so, CivilTime t) { cycle_.mode_arbiter.set(reason, is_so, t); }
  /// The same for a time; for ever where only a person ends it.
  void hold(Reason reason, CivilTime t, std::int64_t seconds) { cycle_.mode_arbiter.hold(reason, t, seconds); }
  /// An operator gives the AHU back: everything that waits for a person ends.
  void hand_back() {
    cycle_.mode_arbiter.hand_back();
    cycle_.override_monitor = OverrideMonitor();
    cycle_.refused_writes = 0;
  }
  /// Keeps the AHU released at least as long as `other` has it (ModeArbiter::join_releases).
  void join_releases(const ModeArbiter& other, CivilTime t) { cycle_.mode_arbiter.join_releases(other, t); }
  /// What may be in the setpoint register, where that is known better than by this state: the next step begins there.
  void take_stored(const StoredSetpoint& s) { cycle_.stored = std::isfinite(s.low_degc) ? s : cycle_.stored; }
  /// The reasons of a state whose weights were not taken.
  void take_reasons(const ModeArbiter& reasons) { cycle_.mode_arbiter = reasons; }

  const ControllerSettings& settings() const { return settings_; }
  const LimitsTable<T>& limits() const { return limits_; }
  const LearnerSettings<T>& learner_settings() const { return learner_settings_; }
  const Learning& learning() const { return learning_; }
  const CycleState<T>& cycle() const { return cycle_; }
  const Replay& replay() const { return replay_; }
  const Decision& decision() const { return decision_; }

  /// A decision before there was any: the schedule's night setpoint, faultless.
  static Decision schedule_decision() {
    const ControllerSettings s = product_settings();
    return {.time = {}, .command = SafetyEnvelope(s).limit(s.expert_off_degc, s.expert_off_degc, s.expert_off_degc)};
  }

 protected:
  friend struct ControllerAccess<T, Scalar>;
  ControllerMemory() = default;

  WeightExchange<T, Scalar> weight_exchange() { return {learning_, cycle_, replay_}; }

  /// What is derived from the saved state.
  Fault rebuild() {
    cycle_.validator.use_limits(limits_, settings_);
    if (!all_finite(learning_.weights) || !learning_.head.finite() || !learning_.scaler.finite() ||
        !learning_.residual.network.is_sound() || !std::isfinite(cycle_.confidence)) {
      cycle_.has_weights = 0;
      return Fault::state_invalid;
    }
    learning_.head.complete_day_types(settings_);  // the site file may ask for a second day type since
    prepare();
    return Fault::none;
  }

  ControllerSettings settings_;
  LimitsTable<T> limits_{};
  LearnerSettings<T> learner_settings_;

  Learning learning_;
  CycleState<T> cycle_;
  Replay replay_;

  ShadowTraining<T, Scalar> training_;
  NetworkScratch<T, Scalar> scratch_;  ///< between two calls the weights in use are packed in it
  Proposer<T, Scalar> proposer_;

  Decision decision_ = schedule_decision();
  bool resumed_ = false;  ///< no row since restore(): the register may hold the write of a decision that was cut off
};

}  // namespace airside
