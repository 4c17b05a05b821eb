#pragma once
// The controller: decide() validates, scales, predicts, scores, blends and limits; absorb() remembers what was
// really applied and learns from it, a bounded number of steps, on shadow weights that must pass a gate. All of it
// is one object of fixed size.

#include <array>
#include <cmath>
#include <cstddef>
#include <span>

#include "airside/controller/decision.hpp"
#include "airside/forecast/candidate_search.hpp"
#include "airside/learning/learning_state.hpp"
#include "airside/learning/row_window.hpp"
#include "airside/learning/shadow_training.hpp"
#include "airside/plant.hpp"
#include "airside/supervision/confidence.hpp"
#include "airside/supervision/envelope.hpp"
#include "airside/supervision/schedule.hpp"

namespace airside {

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
    cycle_.validator = Validator<T>(limits, settings);
    cycle_.confidence = settings.confidence_initial;
    replay_.clear();
    learner_settings_.loss.weights = {settings.weight_strb, settings.weight_tdb, settings.weight_gc, settings.weight_rc,
                                      settings.weight_rec};
    learner_settings_.loss.gamma = settings.gamma;
    learner_settings_.loss.labels = relation_labels<T>(settings.label_vav);
    learner_settings_.adam = {settings.learning_rate, settings.adam_beta1, settings.adam_beta2, settings.adam_epsilon};
    learner_settings_.sync_every = settings.target_sync_steps;
    search_.configure(settings);
    g36_ = guideline36_on_site(settings);
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

  /// A row between two decisions: keeps the validator's memory, and watches.
  void observe(CivilTime t, const Expected<Reading<T>>& sensed) {
    resumed_ = false;
    cycle_.mode_arbiter.tick(t);
    if (!sensed) return;
    see_setpoint(sensed->setpoint_degc);
    const Expected<ValidReading<T>> valid = check(t, *sensed);
    watch(t, *sensed, valid);
    if (!valid || !valid->learnable()) return;
    cycle_.row_value = valid->value();
    cycle_.row_time = t;
  }

  /// Chooses the next setpoint.  validate -> scale -> predict -> score -> blend -> limit.
  /// Errors: none; every fault is in the decision, and takes it to the control mode that the mode arbiter has for it.
  /// On control mode `release` the command must not be written.
  const Decision& decide(CivilTime t, const Expected<Reading<T>>& sensed) {
    const SafetyEnvelope envelope(settings_);
    cycle_.mode_arbiter.tick(t);
    cycle_.budget.earn(settings_.writes_per_day);
    // Where nobody knows the hour, the working hours' setpoint: it costs energy, the night's would cost comfort.
    const double expert = cycle_.mode_arbiter.active(Reason::clock_not_set, t) ? settings_.expert_work_degc
                                                                               : expert_setpoint_degc(settings_, t);
    if (sensed) see_setpoint(sensed->setpoint_degc);
    if (sensed && !(resumed_ && t.seconds - cycle_.last_time.seconds == cycle_s)) adopt_setpoint(t, *sensed);
    if (sensed) cycle_.contact = sensed->contact;
    resumed_ = false;
    const double g36 = decision_.g36_degc;
    decision_ = {.time = t, .command = envelope.limit(expert, cycle_.standing, expert)};
    decision_.expert_degc = expert;
    decision_.g36_degc = g36;
    decision_.confidence = cycle_.confidence;
    completed_ = false;
    usable_ = false;
    has_features_ = false;
    if (!sensed) {
      decision_.fault = sensed.error();
      return enter_mode(ControlMode::expert, Reason::no_reading);
    }
    const Expected<ValidReading<T>> valid = check(t, *sensed);
    watch(t, *sensed, valid);
    if (!valid) {
      decision_.fault = valid.error();
      decision_.fault_signal = cycle_.validator.lost_signal();
      return enter_mode(ControlMode::expert, Reason::signal_lost);
    }
    now_ = valid->value();
    usable_ = valid->learnable();
    if (!usable_) name_held_signal();
    decision_.room_mean_degc = valid->room_mean_degc();
    judge(t);
    if (cycle_.has_weights == 0) return enter_mode(ControlMode::expert, Reason::no_weights);
    const double proposal = propose(t, cycle_.last_setpoint_degc);
    if (!std::isfinite(proposal)) {
      decision_.fault = Fault::forecast_invalid;
      return enter_mode(ControlMode::expert, Reason::forecast_invalid);
    }
    const Reason held = decision_.fault == Fault::disagrees ? Reason::room_disagrees : Reason::signal_held;
    enter_mode(usable_ ? ControlMode::learn : ControlMode::run, usable_ ? Reason::none : held);
    if (decision_.mode < ControlMode::expert) {
      const double in_range = std::clamp(proposal, settings_.action_min_degc, settings_.action_max_degc);
      decision_.command = envelope.limit(worth_a_write(in_range), cycle_.standing, expert);
    }
    return decision_;
  }

  /// Remembers what the AHU took and learns from the cycle that just ended.
  /// Errors: a refused command is remembered as unknown, and nothing is learned from the cycle it would have begun.
  void absorb(const Expected<Applied>& applied) {
    // Where nothing was written, what was read still stands.
    const bool released = decision_.mode == ControlMode::release || (!applied && applied.error() == Fault::released);
    const bool stands = !applied && released;
    const double setpoint = applied ? applied->setpoint_degc : stands ? cycle_.last_setpoint_degc : unknown;
    if (!applied && decision_.fault == Fault::none && !released) decision_.fault = applied.error();
    account(applied);
    cycle_.network_expected_degc = cycle_.head_expected_degc = Decision::none;
    if (usable_ && applied && std::isfinite(setpoint)) expect(decision_.time, setpoint);
    if (completed_ && !repeats_the_last(newest_)) replay_.push(newest_);
    if (completed_ && decision_.mode == ControlMode::learn) learn();
    const bool follows = decision_.time.seconds - cycle_.last_time.seconds == cycle_s;
    cycle_.features = features_;
    cycle_.has_features = has_features_ && applied ? 1 : 0;
    cycle_.before_setpoint_degc = cycle_.last_setpoint_degc;
    cycle_.last_value = now_;
    cycle_.last_time = decision_.time;
    cycle_.last_setpoint_degc = setpoint;
    if (applied) cycle_.standing.is(setpoint);
    if (!applied && !stands) cycle_.standing.may_be(decision_.command.setpoint_degc());
    cycle_.commanded_degc = applied ? decision_.command.setpoint_degc() : unknown;
    cycle_.ours = applied && decision_.mode <= ControlMode::run ? 1 : 0;
    const std::int32_t usable_before = follows ? cycle_.usable_cycles : 0;
    // A cycle that begins without flow shows nothing of the setpoint, also where the fan starts in it.
    cycle_.usable_cycles = usable_ && flows_ && applied ? std::min<std::int32_t>(usable_before + 1, 3) : 0;
    ++learning_.cycles;
  }

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

  const Decision& decision() const { return decision_; }
  /// Where the mode arbiter stands at t: as the last decision, or on a graver control mode that was asked for since.
  ActiveMode control_mode(CivilTime t) const {
    const Reason since = cycle_.mode_arbiter.gravest(t);
    const ControlMode asked = request_of(since).mode;
    return asked > decision_.mode ? ActiveMode{asked, since} : ActiveMode{decision_.mode, decision_.reason};
  }
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
    const Fault fault = rebuild();
    resumed_ = fault == Fault::none;
    cycle_.contact = 0;  // a process counts its own from 1, and the device may have restarted before it did
    return fault;
  }

  /// A decision before there was any: the schedule's night setpoint, faultless.
  static Decision schedule_decision() {
    const ControllerSettings s = product_settings();
    return {.time = {}, .command = SafetyEnvelope(s).limit(s.expert_off_degc, s.expert_off_degc, s.expert_off_degc)};
  }
  /// Puts back the last decision, which rows between two decisions still show.
  void restore_decision(const Decision& decision) { decision_ = decision; }

  /// How far other weights are from what a room can do: on canary states (canary.hpp), and as the largest error of the
  /// one-cycle forecast of the room mean on the newest remembered transitions.
  /// Units: K, both. Errors: infinite for a forecast that is no number. Cost: at most 36 forecasts and two packings.
  struct ForecastDeviation {
    double canary_k, replay_k;
  };
  ForecastDeviation forecast_deviation(const Scaler<T>& scaler, const NetworkWeights<T, Scalar>& weights) {
    pack(weights, scratch_.kernels, scratch_.packed);
    const ForecastModel<T, Scalar> other{scaler, scratch_.packed, scratch_};
    ForecastDeviation found{canary_excess_k<T>(settings_, scaler, scratch_.packed, scratch_), 0};
    const int n = std::min(replay_.size(), 32);
    for (int age = 0; age < n; ++age) {
      const Remembered past = remembered(replay_.newest(age));
      const double error = search_.expected_mean_degc(other, past.before, past.setpoint_degc) - room_mean(past.after);
      found.replay_k = std::isfinite(error) ? std::max(found.replay_k, std::abs(error)) : HUGE_VAL;
    }
    prepare();
    return found;
  }

  /// Takes other weights while in control: memories are put into their units, moments and trust begin anew.
  void exchange(const Scaler<T>& scaler, std::span<const Scalar> weights) {
    std::copy(weights.begin(), weights.end(), learning_.weights.flat().begin());
    rescale_memories(learning_.scaler, scaler);
    learning_.head.rescale_power(scaler.scale(power_of_head) / learning_.scaler.scale(power_of_head));
    cycle_.features.x(HeadFeatures::power_change) *=
        learning_.scaler.scale(power_of_head) / scaler.scale(power_of_head);
    cycle_.confidence = std::min(cycle_.confidence, settings_.confidence_initial);
    forget_comparison();
    start(scaler);
  }
  /// After learning() was overwritten by an older one whose scaler may differ from `present`.
  Fault roll_back(const Scaler<T>& present) {
    rescale_memories(present, learning_.scaler);
    forget_comparison();
    resumed_ = false;
    return rebuild();
  }

  /// The schedule again, until other weights come.
  void drop_weights() {
    cycle_.has_weights = 0;
    forget_comparison();
  }

  /// One optimiser step on the replay; for a host that fine-tunes.  Errors: returns the losses before the step.
  LossTerms train_step() {
    return training_.step(settings_, learner_settings_, learning_, replay_, scratch_, learning_.weights);
  }
  /// Makes the weights that train_step() changed the ones in use.
  void prepare() { pack(learning_.weights, scratch_.kernels, scratch_.packed); }

 private:
  static constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
  Fault rebuild() {
    cycle_.validator.use_limits(limits_, settings_);
    if (!all_finite(learning_.weights) || !learning_.head.finite() || !learning_.scaler.finite() ||
        !std::isfinite(cycle_.confidence)) {
      cycle_.has_weights = 0;
      return Fault::state_invalid;
    }
    learning_.head.complete_day_types(settings_);  // the site file may ask for a second day type since
    prepare();
    return Fault::none;
  }

  static constexpr int power_of_head = L::power + T::powers - 1;
  /// Other weights do not answer for what those before them did, and get a day of their own to show it.
  void forget_comparison() {
    cycle_.network_expected_degc = cycle_.head_expected_degc = unknown;
    cycle_.shadow.reset();
    cycle_.worse_cycles = 0;
    cycle_.no_confidence = PersistentCondition();
    for (const Reason r : {Reason::worse_than_schedule, Reason::worse_for_long, Reason::forecasts_doubted}) {
      cycle_.mode_arbiter.set(r, false, cycle_.last_time);
    }
  }

  static constexpr double foreign_k = 0.05;  ///< a setpoint differs by more than a register's rounding

  Expected<ValidReading<T>> check(CivilTime t, const Reading<T>& reading) {
    Reading<T> at = reading;
    at.time = t;
    return cycle_.validator.check(at);
  }

  /// The gravest of what this decision found and what the mode arbiter remembers.
  const Decision& enter_mode(ControlMode mode, Reason reason) {
    const Reason remembered = cycle_.mode_arbiter.gravest(decision_.time);
    const ControlMode asked = request_of(remembered).mode;
    const bool graver = asked > mode || (asked == mode && reason == Reason::none);
    decision_.mode = graver ? asked : mode;
    decision_.reason = graver ? remembered : reason;
    return decision_;
  }

  /// What stands in the register. A decision that is made again after a crash may find its own write there, a step from
  /// what stood before at most: then both count, so that it is made as it was.
  void see_setpoint(double standing_degc) {
    if (!std::isfinite(standing_degc)) return;
    StandingSetpoint either = cycle_.standing;
    either.may_be(standing_degc);
    if (!resumed_ || either.high_degc - either.low_degc > settings_.limit_change_k) either.is(standing_degc);
    cycle_.standing = either;
  }

  /// The AHU's own word counts: after a start, a refused write or another hand on it, its setpoint is what it shows.
  /// Nothing is learned from the cycle that this breaks. Another hand is left alone for a while; a device that was out
  /// of touch may have fallen back to a default, and one that was slow shows what it was told.
  void adopt_setpoint(CivilTime t, const Reading<T>& sensed) {
    const double standing = sensed.setpoint_degc, known = cycle_.last_setpoint_degc;
    if (!std::isfinite(standing) || (std::isfinite(known) && std::abs(standing - known) <= foreign_k)) return;
    const bool late = std::abs(standing - cycle_.commanded_degc) <= foreign_k;
    if (std::isfinite(known) && !late && !resumed_ && sensed.contact == cycle_.contact) {
      // Who sets again what was left to him fights nobody.
      const bool fights = decision_.mode != ControlMode::release && cycle_.override_monitor.third_in_a_day(t);
      const auto patience_s = static_cast<std::int64_t>(settings_.override_h * 3600);
      cycle_.mode_arbiter.hold(fights ? Reason::two_masters : Reason::overridden, t, patience_s);
    }
    cycle_.last_setpoint_degc = standing;
    cycle_.usable_cycles = 0;
  }

  /// What takes more than one reading to see.
  void watch(CivilTime t, const Reading<T>& sensed, const Expected<ValidReading<T>>& valid) {
    const double away_k = std::abs(sensed.supply_temp_degc - cycle_.last_setpoint_degc);  // NaN: nothing to compare
    flows_ = air_flows(settings_, t, sensed.flows);  // where nothing flows, supply air cannot follow
    const bool ignores = cycle_.supply_ignores.lasts(flows_ && away_k > settings_.supply_ignored_k, t,
                                                     static_cast<std::int64_t>(settings_.supply_ignored_s));
    cycle_.mode_arbiter.set(Reason::supply_ignores_setpoint, ignores, t);
    if (!valid) return;
    const Vector& v = valid->value();
    if (valid->learnable()) {
      cycle_.mode_arbiter.set(Reason::sensor_drifts, cycle_.drift.row(v.template head<L::rooms>(), settings_.drift_k),
                              t);
    }
    decision_.g36_degc = cycle_.guideline36.setpoint_degc(
        settings_, g36_, t, {v.data(), static_cast<std::size_t>(L::rooms)},
        {v.data() + L::vav_on, static_cast<std::size_t>(L::rooms)}, v(L::outdoor_temp));
  }

  /// The proposal, or the standing setpoint where the move to it is not worth a write.
  double worth_a_write(double proposal_degc) {
    const double standing = cycle_.last_setpoint_degc;
    if (settings_.writes_per_day <= 0 || !std::isfinite(standing)) return proposal_degc;
    return cycle_.budget.allows(proposal_degc - standing, settings_.writes_per_day) ? proposal_degc : standing;
  }

  /// What the AHU made of a command.
  void account(const Expected<Applied>& applied) {
    const CivilTime t = decision_.time;
    if (decision_.mode == ControlMode::release) return;
    if (!applied && applied.error() == Fault::write_refused) {
      constexpr std::int64_t hour_s = 3600;
      cycle_.mode_arbiter.set(Reason::write_refused, true, t);
      if (++cycle_.refused_writes >= 2) cycle_.mode_arbiter.hold(Reason::writes_refused, t, hour_s);
    }
    if (!applied) return;
    cycle_.refused_writes = 0;
    cycle_.mode_arbiter.set(Reason::write_refused, false, t);
    const double altered_k = std::abs(applied->setpoint_degc - decision_.command.setpoint_degc());
    const bool altered = altered_k > std::max(foreign_k, 0.5 * settings_.readback_step_k + 1e-9);
    // What the AHU made another value of was written too, and is again each time.
    const bool written = applied->setpoint_degc != cycle_.last_setpoint_degc || altered;
    if (settings_.writes_per_day > 0 && written) cycle_.budget.spend(settings_.writes_per_day);
    cycle_.mode_arbiter.set(Reason::setpoint_altered, altered, t);
    const bool rests = cycle_.excitation.cycle(applied->setpoint_degc, settings_.excitation_k);
    cycle_.mode_arbiter.set(Reason::no_excitation, rests && cycle_.has_weights != 0, t);
  }

  /// Whether the schedule would do better, in working hours.
  void compare_with_schedule(CivilTime t) {
    if (cycle_.ours == 0 || !in_working_hours(settings_, cycle_.last_time)) return;
    cycle_.shadow.cycle(settings_, decision_.room_mean_degc, cycle_.last_setpoint_degc,
                        expert_setpoint_degc(settings_, cycle_.last_time), learning_.head.gain(settings_));
    const bool worse = cycle_.shadow.worse(settings_.worse_k);
    cycle_.mode_arbiter.set(Reason::worse_than_schedule, worse, t);
    cycle_.worse_cycles = worse ? cycle_.worse_cycles + 1 : 0;
    if (cycle_.worse_cycles * cycle_s < settings_.worse_h * 3600) return;
    constexpr std::int64_t day_s = 86400;
    cycle_.mode_arbiter.hold(Reason::worse_for_long, t, day_s);
    cycle_.mode_arbiter.set(Reason::worse_than_schedule, false, t);
    cycle_.shadow.reset();
    cycle_.worse_cycles = 0;
  }

  /// A gain that has turned round is believed again when it is sane beyond doubt. A head that was led astray would
  /// take weeks to find back, so after a day it begins anew, and learns from the schedule's steps.
  void watch_gain(CivilTime t) {
    constexpr std::int64_t day_s = 86400;
    const bool suspect = cycle_.mode_arbiter.active(Reason::gain_reversed, t) && !learning_.head.gain_is_sane();
    const bool reversed = learning_.head.gain_is_reversed() || suspect;
    if (cycle_.gain_reversed.lasts(reversed, t, day_s)) {
      learning_.head.reset(settings_, settings_.head_gain_prior, settings_.head_gain_prior_sd);
      cycle_.gain_reversed = PersistentCondition();
    }
    cycle_.mode_arbiter.set(Reason::gain_reversed, reversed, t);
  }

  /// What nothing may be learned from though each reading is good: a room that drifts, air that does not follow its
  /// setpoint or does not flow (a gain learned then would be that of a closed valve), hours that nobody knows.
  bool doubted(CivilTime t) const {
    const ModeArbiter& on = cycle_.mode_arbiter;
    return !flows_ || on.active(Reason::sensor_drifts, t) || on.active(Reason::supply_ignores_setpoint, t) ||
           on.active(Reason::clock_not_set, t);
  }

  /// A transition like the last one to the bit is no news: a device that repeats itself must not fill the memory.
  bool repeats_the_last(const Row& row) const { return replay_.size() > 0 && replay_.newest(0) == row; }

  /// A signal that is held at its last good value is named, though control goes on.
  void name_held_signal() {
    const auto& faults = cycle_.validator.faults();
    for (std::size_t i = 0; i < faults.size() && decision_.fault == Fault::none; ++i) {
      if (faults[i] == Fault::none) continue;
      decision_.fault = faults[i];
      decision_.fault_signal = static_cast<int>(i);
    }
  }

  struct Remembered {
    Vector before;
    double setpoint_degc;
    Vector after;
  };
  /// A transition back in SI units.
  Remembered remembered(const Row& row) const { return unscaled(row, learning_.scaler); }
  static Remembered unscaled(const Row& row, const Scaler<T>& scaler) {
    const Eigen::Map<const Eigen::Matrix<Scalar, L::transition, 1>> x(row.data());
    const Vector mean = scaler.mean.template head<L::signals>(), scale = scaler.scale.template head<L::signals>();
    const auto si = [&](const auto& part) -> Vector { return part.template cast<double>().cwiseProduct(scale) + mean; };
    return {si(x.template head<L::signals>()),
            static_cast<double>(x(L::setpoint)) * scaler.scale(L::setpoint) + scaler.mean(L::setpoint),
            si(x.template tail<L::signals>())};
  }

  /// Puts the replay from one scaler's units into another's.
  void rescale_memories(const Scaler<T> from, const Scaler<T>& to) {
    const Scaler<T> kept = learning_.scaler;
    learning_.scaler = to;
    for (int i = 0; i < replay_.size(); ++i) {
      const Remembered past = unscaled(replay_.slot(i), from);
      replay_.slot(i) = transition(past.before, past.setpoint_degc, past.after);
    }
    learning_.scaler = kept;
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
      if (!doubted(t)) learning_.head.update(settings_, cycle_.last_time, f, moved);
      watch_gain(t);
    }
    if (cycle_.has_weights == 0) return;
    compare_with_schedule(t);
    newest_ = transition(cycle_.last_value, cycle_.last_setpoint_degc, now_);
    completed_ = !doubted(t);
    decision_.loss = learning_.learner.loss_of(learning_.weights, newest_, learner_settings_.loss, scratch_);
    const double network_error = decision_.network_error_k = decision_.room_mean_degc - cycle_.network_expected_degc;
    const double head_error = decision_.head_error_k = decision_.room_mean_degc - cycle_.head_expected_degc;
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
    constexpr double least = 0.05;
    constexpr std::int64_t day_s = 86400;
    const bool is_silent = effective_confidence(settings_, cycle_.confidence) < least;
    cycle_.mode_arbiter.set(Reason::forecasts_doubted, cycle_.no_confidence.lasts(is_silent, t, day_s), t);
  }

  /// predict -> score -> blend. Errors: NaN if neither network nor head gives a number.
  double propose(CivilTime t, double last_degc) {
    decision_.network_degc = search_.best_degc(settings_, model(), now_, last_degc);
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
    if (!std::isfinite(chosen)) return unknown;
    return fuse(effective_confidence(settings_, cycle_.confidence), chosen, decision_.expert_degc);
  }

  ForecastModel<T, Scalar> model() { return {learning_.scaler, scratch_.packed, scratch_}; }

  double head_choice(CivilTime t, double last_degc) {
    if (!has_features_ || learning_.head.updates() == 0) return unknown;
    const double wish = learning_.head.setpoint_degc(settings_, t, features_, room_mean(now_), last_degc);
    if (!std::isfinite(wish)) return unknown;  // before the clamp, which would make a bound of an infinite one
    return std::clamp(wish, settings_.action_min_degc, settings_.action_max_degc);
  }

  /// What network and head expect of the cycle that begins now, at the setpoint that was really applied.
  void expect(CivilTime t, double setpoint_degc) {
    if (cycle_.has_weights == 0) return;
    cycle_.network_expected_degc = search_.expected_mean_degc(model(), now_, setpoint_degc);
    decision_.expected_mean_degc = cycle_.network_expected_degc;
    if (!has_features_) return;
    cycle_.head_expected_degc = room_mean(now_) + learning_.head.drift_k(settings_, t, features_) +
                                learning_.head.gain(settings_) * (setpoint_degc - cycle_.last_setpoint_degc);
    if (std::isfinite(cycle_.head_expected_degc)) decision_.expected_mean_degc = cycle_.head_expected_degc;
  }

  void learn() {
    const Fault fault = training_.learn(settings_, learner_settings_, learning_, replay_, scratch_);
    cycle_.refused_updates = fault == Fault::none ? 0 : cycle_.refused_updates + 1;
    if (fault != Fault::none && decision_.fault == Fault::none) decision_.fault = fault;
    if (cycle_.refused_updates < settings_.refused_updates) return;
    constexpr std::int64_t day_s = 86400;
    cycle_.mode_arbiter.hold(Reason::learning_refused, decision_.time, day_s);
    cycle_.refused_updates = 0;
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
                                      learning_.scaler.scale(power_of_head));
    has_features_ = true;
  }

  static double room_mean(const Vector& v) { return v.template head<L::rooms>().mean(); }

  static void track(double& mean_square, double error) {
    constexpr double memory = 0.05;  // about a working day of cycles
    if (std::isfinite(error)) mean_square += memory * (error * error - mean_square);
  }

  ControllerSettings settings_;
  LimitsTable<T> limits_{};
  LearnerSettings<T> learner_settings_;

  LearningState<T, Scalar> learning_;
  CycleState<T> cycle_;
  ReplayRing<T, Scalar> replay_;

  ShadowTraining<T, Scalar> training_;
  NetworkScratch<T, Scalar> scratch_;  ///< between two calls the weights in use are packed in it

  Decision decision_ = schedule_decision();
  Vector now_ = Vector::Zero();
  Row newest_{};
  bool completed_ = false;  ///< newest_ is a transition that just ended
  HeadFeatures features_;
  bool has_features_ = false;  ///< features_ are those of the present decision
  bool usable_ = false;        ///< the present reading may be learned from
  bool flows_ = true;          ///< air flows at the present reading
  bool resumed_ = false;       ///< no row since restored(): a setpoint that stands there may be of a decision cut off

  CandidateSearch<T, Scalar> search_;
  Guideline36Settings g36_;
};

}  // namespace airside
