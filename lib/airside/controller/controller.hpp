#pragma once
// The controller: decide() validates, scales, predicts, scores, blends and limits; absorb() remembers what was
// really applied and learns from it, a bounded number of steps, on shadow weights that must pass a gate. All of it
// is one object of fixed size.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "airside/civil_time.hpp"
#include "airside/command.hpp"
#include "airside/controller/controller_memory.hpp"
#include "airside/controller/cycle_judge.hpp"
#include "airside/controller/decision.hpp"
#include "airside/controller/demand_watch.hpp"
#include "airside/controller/pending_cycle.hpp"
#include "airside/controller/supervisor.hpp"
#include "airside/demand/band_objective.hpp"
#include "airside/demand/demand_reading.hpp"
#include "airside/demand_settings.hpp"
#include "airside/fault.hpp"
#include "airside/reading.hpp"
#include "airside/settings.hpp"
#include "airside/supervision/control_mode.hpp"
#include "airside/supervision/envelope.hpp"
#include "airside/supervision/mode_table.hpp"
#include "airside/supervision/validation.hpp"
#include "airside/topology.hpp"

namespace airside {

/// Controls one AHU: the cycle over the parts that supervise, judge, propose and learn. Shape: T. Scalar: float on the
/// box, double in tests.
/// Cost: see `airside footprint`; nothing is allocated, ever.  Source: docs/method.md 6.5; DESIGN.md.
template <Topology T, class Scalar = float>
class Controller : public ControllerMemory<T, Scalar> {
 public:
  using L = Layout<T>;
  using Vector = typename Reading<T>::Vector;
  using Pending = PendingCycle<T, Scalar>;

  Controller() { this->configure(product_settings(), default_limits<T>(), strict_kernels<Scalar>(), 1); }

  /// A row between two decisions: keeps the validator's memory, and watches.
  void observe(CivilTime t, const Expected<Reading<T>>& sensed) {
    resumed_ = false;
    cycle_.mode_arbiter.tick(t);
    if (!sensed) return;
    Supervisor<T> supervisor(settings_, cycle_);
    supervisor.see_setpoint(sensed->setpoint_degc, false);
    const bool flows = supervisor.watch_supply(t, *sensed);
    const Expected<ValidReading<T>> valid = cycle_.validator.check(*sensed, t, flows);
    if (!valid) return;
    watch(supervisor, t, *valid, flows);
    if (serves_band()) watch_demand(supervisor, *sensed, *valid, flows);
    if (!valid->learnable()) return;
    cycle_.row_value = valid->value();
    cycle_.row_time = t;
  }

  /// Chooses the next setpoint.  validate -> scale -> predict -> score -> blend -> limit.
  /// Errors: none; every fault is in the decision, and takes it to the control mode that the mode arbiter has for it.
  /// In control mode `release` the command must not be written.
  Pending decide(CivilTime t, const Expected<Reading<T>>& sensed) {
    Supervisor<T> supervisor(settings_, cycle_);
    Pending pending = open(t, sensed, supervisor);
    const ActiveMode found = sensed ? choose(*sensed, supervisor, pending) : no_reading(sensed.error(), pending);
    const ActiveMode on = supervisor.settle(found.mode, found.reason, t);
    pending.mode = on.mode;
    pending.reason = on.reason;
    if (pending.mode >= ControlMode::expert) {
      pending.command = SafetyEnvelope(settings_).limit(pending.expert_degc, cycle_.standing, pending.expert_degc);
    }
    decision_ = pending;
    return pending;
  }

  /// Remembers what the AHU took and learns from the cycle that just ended.
  /// Errors: a refused command is remembered as unknown, and nothing is learned from the cycle it would have begun.
  void absorb(const Pending& pending, const Expected<Applied>& applied) {
    // Where nothing was written, the register still holds what was read.
    const bool released = pending.mode == ControlMode::release || (!applied && applied.error() == Fault::released);
    const bool stays = !applied && released;
    const double setpoint = applied ? applied->setpoint_degc : stays ? cycle_.last_setpoint_degc : Decision::none;
    if (!applied && decision_.fault == Fault::none && !released) decision_.fault = applied.error();
    Supervisor<T> supervisor(settings_, cycle_);
    supervisor.account(pending, applied, pending.flows);
    cycle_.network_expected_degc = cycle_.head_expected_degc = Decision::none;
    if (pending.is_usable && applied && std::isfinite(setpoint)) {
      decision_.expected_mean_degc = proposer_.expect(settings_, learning_, cycle_, scratch_, pending, setpoint);
    }
    if (pending.is_completed && !repeats_the_last(pending)) replay_.push(pending.completed_row);
    if (pending.is_completed && pending.mode == ControlMode::learn) learn(supervisor);
    close(pending, applied, setpoint, stays);
  }

  /// The control mode at t: that of the last decision, or a graver one that was asked for since.
  ActiveMode control_mode(CivilTime t) const {
    const Reason since = cycle_.mode_arbiter.gravest(t);
    const ControlMode asked = request_of(since).mode;
    return asked > decision_.mode ? ActiveMode{asked, since} : ActiveMode{decision_.mode, decision_.reason};
  }

 private:
  using Base = ControllerMemory<T, Scalar>;
  using Base::cycle_, Base::decision_, Base::guideline36_, Base::learner_settings_, Base::learning_, Base::proposer_,
      Base::replay_, Base::resumed_, Base::scratch_, Base::settings_, Base::training_;

  /// A decision before the reading is looked into.
  Pending open(CivilTime t, const Expected<Reading<T>>& sensed, Supervisor<T>& supervisor) {
    cycle_.mode_arbiter.tick(t);
    cycle_.budget.earn(settings_.writes_per_day);
    const double expert = supervisor.expert_degc(t);
    if (sensed) supervisor.see_setpoint(sensed->setpoint_degc, resumed_);
    const bool made_again = resumed_ && t.seconds - cycle_.last_time.seconds == cycle_s;
    if (sensed && !made_again) supervisor.adopt_setpoint(t, *sensed, resumed_, decision_.mode);
    if (sensed) cycle_.contact = sensed->contact;
    resumed_ = false;
    Pending pending(Decision{.time = t, .command = SafetyEnvelope(settings_).limit(expert, cycle_.standing, expert)});
    pending.expert_degc = expert;
    pending.g36_degc = decision_.g36_degc;
    pending.confidence = cycle_.confidence;
    pending.now = cycle_.last_value;
    pending.features = cycle_.features;
    return pending;
  }

  static ActiveMode no_reading(Fault fault, Pending& pending) {
    pending.fault = fault;
    return {ControlMode::expert, Reason::no_reading};
  }

  /// From the reading to a command of our own. Returns the control mode that this asks for, and why.
  ActiveMode choose(const Reading<T>& sensed, Supervisor<T>& supervisor, Pending& pending) {
    const CivilTime t = pending.time;
    pending.flows = supervisor.watch_supply(t, sensed);
    const Expected<ValidReading<T>> valid = cycle_.validator.check(sensed, t, pending.flows);
    if (!valid) {
      pending.fault = valid.error();
      pending.fault_signal = cycle_.validator.lost_signal();
      return {ControlMode::expert, Reason::signal_lost};
    }
    watch(supervisor, t, *valid, pending.flows);
    pending.g36_degc = decision_.g36_degc;
    pending.now = valid->value();
    pending.is_usable = valid->learnable();
    if (!pending.is_usable) supervisor.name_held_signal(pending);
    pending.room_mean_degc = valid->room_mean_degc();
    if (serves_band()) return choose_for_band(sensed, *valid, supervisor, pending);
    CycleJudge<T, Scalar> judge(settings_, learner_settings_, learning_, cycle_, scratch_);
    // A cycle in which the fan stopped shows nothing of the setpoint.
    if (pending.flows && judge.has_ended(t, pending.is_usable)) {
      if (settings_.head != 0) proposer_.take_features(settings_, cycle_, learning_.scaler, pending);
      judge.judge(pending);
    }
    if (cycle_.has_weights == 0) return {ControlMode::expert, Reason::no_weights};
    // While the fan rests the setpoint stays as it was: it has no effect, and the forecasts know no still air.
    const bool stays = !pending.flows && std::isfinite(cycle_.last_setpoint_degc);
    const double proposal =
        stays ? cycle_.last_setpoint_degc : proposer_.propose(settings_, learning_, cycle_, scratch_, pending);
    if (!std::isfinite(proposal)) {
      pending.fault = Fault::forecast_invalid;
      return {ControlMode::expert, Reason::forecast_invalid};
    }
    const double in_range = std::clamp(proposal, settings_.action_min_degc, settings_.action_max_degc);
    command(in_range, supervisor, pending);
    return mode_of(pending);
  }

  void command(double setpoint_degc, Supervisor<T>& supervisor, Pending& pending) const {
    pending.command =
        SafetyEnvelope(settings_).limit(supervisor.worth_a_write(setpoint_degc), cycle_.standing, pending.expert_degc);
  }

  static ActiveMode mode_of(const Pending& pending) {
    if (pending.is_usable) return {ControlMode::learn, Reason::none};
    const bool disagrees = pending.fault == Fault::disagrees;
    return {ControlMode::run, disagrees ? Reason::room_disagrees : Reason::signal_held};
  }

  bool serves_band() const { return settings_.objective == Objective::band; }

  void watch_demand(const Supervisor<T>& supervisor, const Reading<T>& sensed, const ValidReading<T>& valid,
                    bool flows) {
    const bool counts = flows && valid.learnable() && !supervisor.doubted(sensed.time, flows);
    cycle_.band.observe(settings_.demand, DemandWatch<T>(settings_, cycle_, sensed, valid.value()).reading(counts));
  }

  /// The same as choose() for the objective "band": neither network nor room head has a part in it. While the fan rests
  /// or too little has been learned the schedule's setpoint is the choice; where dampers are lost, the mode says so.
  ActiveMode choose_for_band(const Reading<T>& sensed, const ValidReading<T>& valid, Supervisor<T>& supervisor,
                             Pending& pending) {
    watch_demand(supervisor, sensed, valid, pending.flows);
    const DemandWatch<T> watch(settings_, cycle_, sensed, valid.value());
    const DemandReading at = watch.reading(pending.flows);
    if (pending.flows && !BandObjective::carries(at)) return {ControlMode::expert, Reason::signal_lost};
    const double chosen = cycle_.band.choose(settings_.demand, at, watch.choice(pending.expert_degc)).setpoint_degc;
    command(std::isfinite(chosen) ? chosen : pending.expert_degc, supervisor, pending);
    return mode_of(pending);
  }

  /// What takes more than one reading to see.
  void watch(Supervisor<T>& supervisor, CivilTime t, const ValidReading<T>& valid, bool flows) {
    if (flows) supervisor.watch_rooms(t, valid);
    supervisor.watch_authority(t, valid, flows);
    static constexpr std::array<double, static_cast<std::size_t>(L::rooms)> all_shut{};
    const Vector& v = valid.value();
    const auto rooms = static_cast<std::size_t>(rooms_of<T>(settings_.shape));
    const double* vav_on = flows ? v.data() + L::vav_on : all_shut.data();  // its loops rest with the fan
    decision_.g36_degc = cycle_.guideline36.setpoint_degc(settings_, guideline36_, t, {v.data(), rooms},
                                                          {vav_on, rooms}, v(L::outdoor_temp));
  }

  /// A transition like the last one to the bit is no news: a device that repeats itself must not fill the memory.
  bool repeats_the_last(const Pending& pending) const {
    return replay_.size() > 0 && replay_.newest(0) == pending.completed_row;
  }

  void learn(Supervisor<T>& supervisor) {
    const Fault fault = training_.learn(settings_, learner_settings_, learning_, replay_, scratch_);
    if (fault != Fault::none && decision_.fault == Fault::none) decision_.fault = fault;
    supervisor.count_update(decision_.time, fault);
  }

  /// Makes the cycle that begins now the last one.
  void close(const Pending& pending, const Expected<Applied>& applied, double setpoint, bool stays) {
    const bool follows = pending.time.seconds - cycle_.last_time.seconds == cycle_s;
    cycle_.features = pending.features;
    cycle_.has_features = pending.has_features && applied ? 1 : 0;
    cycle_.before_setpoint_degc = cycle_.last_setpoint_degc;
    cycle_.last_value = pending.now;
    cycle_.last_time = pending.time;
    cycle_.last_setpoint_degc = setpoint;
    if (applied) cycle_.standing.is(setpoint);
    if (!applied && !stays) cycle_.standing.may_be(pending.command.setpoint_degc());
    cycle_.commanded_degc = applied ? pending.command.setpoint_degc() : Decision::none;
    cycle_.ours = applied && pending.mode <= ControlMode::run ? 1 : 0;
    const std::int32_t usable_before = follows ? cycle_.usable_cycles : 0;
    // A cycle that begins without flow shows nothing of the setpoint, also where the fan starts in it.
    const bool usable = pending.is_usable && pending.flows && applied;
    cycle_.usable_cycles = usable ? std::min<std::int32_t>(usable_before + 1, 3) : 0;
    ++learning_.cycles;
  }
};

}  // namespace airside
