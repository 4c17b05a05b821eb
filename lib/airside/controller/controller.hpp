#pragma once
// The controller: decide() validates, scales, predicts, scores, blends and limits; absorb() remembers what was
// really applied and learns from it, a bounded number of steps, on shadow weights that must pass a gate. All of it
// is one object of fixed size.

#include <algorithm>
#include <cmath>

#include "airside/civil_time.hpp"
#include "airside/command.hpp"
#include "airside/controller/band_chooser.hpp"
#include "airside/controller/controller_memory.hpp"
#include "airside/controller/cycle_judge.hpp"
#include "airside/controller/cycle_record.hpp"
#include "airside/controller/decision.hpp"
#include "airside/controller/pending_cycle.hpp"
#include "airside/controller/proposer.hpp"
#include "airside/controller/supervisor.hpp"
#include "airside/demand_settings.hpp"
#include "airside/fault.hpp"
#include "airside/forecast/candidate_record.hpp"
#include "airside/held_rooms.hpp"
#include "airside/presets.hpp"
#include "airside/reading.hpp"
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
  using Pending = PendingCycle<T, Scalar>;

  Controller() { this->configure(product_settings(), default_limits<T>(), strict_kernels<Scalar>(), 1); }

  /// A row between two decisions: keeps the validator's memory, and watches.
  void observe(CivilTime t, const Expected<Reading<T>>& sensed) {
    resumed_ = false;
    Supervisor<T> supervisor(settings_, cycle_);
    supervisor.begin_row(t, sensed);
    if (!sensed) return;
    const bool flows = supervisor.watch_supply(t, *sensed);
    const Expected<ValidReading<T>> valid = validate(t, *sensed, flows, supervisor);
    if (!valid || !valid->learnable()) return;
    cycle_.row_value = valid->value();
    cycle_.row_time = t;
  }

  /// Chooses the next setpoint.  validate -> scale -> predict -> score -> blend -> limit.
  /// Errors: none; every fault is in the decision, and takes it to the control mode that the mode arbiter has for it.
  /// In control mode `release` the command must not be written.
  Pending decide(CivilTime t, const Expected<Reading<T>>& sensed) {
    Supervisor<T> supervisor(settings_, cycle_);
    supervisor.begin_cycle(t, sensed, resumed_, decision_.mode);
    resumed_ = false;
    const double expert = supervisor.expert_degc(t);
    proposer_.record().begin(t);
    Pending pending = CycleRecord<T, Scalar>(settings_, cycle_).begin(t, expert, limit(expert, expert));
    const ActiveMode found = sensed ? choose(*sensed, supervisor, pending) : no_reading(sensed.error(), pending);
    const ActiveMode on = supervisor.settle(found.mode, found.reason, t);
    pending.mode = on.mode;
    pending.reason = on.reason;
    pending.g36_degc = decision_.g36_degc;
    if (pending.mode >= ControlMode::expert) pending.command = limit(expert, expert);
    decision_ = pending;
    return pending;
  }

  /// Remembers what the AHU took and learns from the cycle that just ended.
  /// Errors: a refused command is remembered as unknown, and nothing is learned from the cycle it would have begun.
  void absorb(const Pending& pending, const Expected<Applied>& applied) {
    CycleRecord<T, Scalar> record(settings_, cycle_);
    Supervisor<T> supervisor(settings_, cycle_);
    const CommandOutcome outcome = record.outcome_of(pending, applied);
    if (!applied && !outcome.is_released) note(applied.error());
    supervisor.account(pending, applied, pending.flows);
    decision_.expected_degc = proposer_.expect(settings_, learning_, cycle_, scratch_, pending, outcome.applied_degc());
    decision_.expected_error_k = Proposer<T, Scalar>::expected_error_k(cycle_);
    if (pending.is_completed) {
      replay_.push_news(pending.completed_row);
      if (pending.mode == ControlMode::learn) learn(supervisor);
    }
    record.finish(pending, outcome);
    ++learning_.cycles;
  }

  /// What the last decision weighed; nothing before the first one of this process.
  const CandidateRecord& candidates() const { return proposer_.record(); }

  /// The control mode at t: that of the last decision, or a graver one that was asked for since.
  ActiveMode control_mode(CivilTime t) const {
    const Reason since = cycle_.mode_arbiter.gravest(t);
    const ControlMode asked = request_of(since).mode;
    return asked > decision_.mode ? ActiveMode{asked, since} : ActiveMode{decision_.mode, decision_.reason};
  }

 private:
  using Base = ControllerMemory<T, Scalar>;
  using Base::cycle_, Base::decision_, Base::learner_settings_, Base::learning_, Base::proposer_, Base::replay_,
      Base::resumed_, Base::scratch_, Base::settings_, Base::training_;

  bool serves_band() const { return settings_.objective == Objective::band; }

  static ActiveMode no_reading(Fault fault, Pending& pending) {
    pending.fault = fault;
    return {ControlMode::expert, Reason::no_reading};
  }

  /// From the reading to a command of our own. Returns the control mode that this asks for, and why.
  ActiveMode choose(const Reading<T>& sensed, Supervisor<T>& supervisor, Pending& pending) {
    pending.flows = supervisor.watch_supply(pending.time, sensed);
    const Expected<ValidReading<T>> valid = validate(pending.time, sensed, pending.flows, supervisor);
    if (!valid) {
      pending.fault = valid.error();
      pending.fault_signal = cycle_.validator.lost_signal();
      return {ControlMode::expert, Reason::signal_lost};
    }
    pending.now = valid->value();
    pending.room_mean_degc = valid->room_mean_degc();
    pending.held_degc = held_degc<T>(settings_.held, settings_.shape, pending.now);
    pending.is_usable = valid->learnable();
    if (!pending.is_usable) supervisor.name_held_signal(pending);
    const Proposal proposal =
        serves_band() ? BandChooser<T>(settings_, cycle_)
                            .propose(sensed, *valid, pending.flows, pending.expert_degc, &proposer_.record())
                      : propose(pending);
    if (proposal.missing != Reason::none) return {ControlMode::expert, proposal.missing};
    pending.command = limit(supervisor.worth_a_write(proposal.setpoint_degc), pending.expert_degc);
    if (pending.is_usable) return {ControlMode::learn, Reason::none};
    const bool disagrees = pending.fault == Fault::disagrees;
    return {ControlMode::run, disagrees ? Reason::room_disagrees : Reason::signal_held};
  }

  /// validate: the checked reading, shown to all that watch over more than one.
  Expected<ValidReading<T>> validate(CivilTime t, const Reading<T>& sensed, bool flows, Supervisor<T>& supervisor) {
    const Expected<ValidReading<T>> valid = cycle_.validator.check(sensed, t, flows);
    if (!valid) return valid;
    decision_.g36_degc = supervisor.watch(t, *valid, flows);
    if (serves_band()) {
      const bool counts = valid->learnable() && !supervisor.doubted(t, flows);
      BandChooser<T>(settings_, cycle_).observe(sensed, *valid, flows, counts);
    }
    return valid;
  }

  /// scale -> predict -> score -> blend, for the objective "mean": what the cycle that ended shows comes first.
  Proposal propose(Pending& pending) {
    CycleJudge<T, Scalar> judge(settings_, learner_settings_, learning_, cycle_, scratch_);
    // A cycle in which the fan stopped shows nothing of the setpoint.
    if (pending.flows && judge.has_ended(pending.time, pending.is_usable)) {
      if (settings_.head != 0) proposer_.take_features(settings_, cycle_, learning_.scaler, pending);
      judge.judge(pending);
    } else {
      cycle_.residual.end_cycle(Decision::none);
    }
    cycle_.residual.count_closed(pending.now.segment(Layout<T>::vav_on, rooms_of<T>(settings_.shape)));
    if (cycle_.has_weights == 0) return {.missing = Reason::no_weights};
    // While the fan rests the setpoint stays as it was: it has no effect, and the forecasts know no still air.
    const bool stays = !pending.flows && std::isfinite(cycle_.last_setpoint_degc);
    const double proposal =
        stays ? cycle_.last_setpoint_degc : proposer_.propose(settings_, learning_, cycle_, scratch_, pending);
    if (!std::isfinite(proposal)) {
      pending.fault = Fault::forecast_invalid;
      return {.missing = Reason::forecast_invalid};
    }
    return {.setpoint_degc = std::clamp(proposal, settings_.action_min_degc, settings_.action_max_degc)};
  }

  /// limit: the nearest safe command.
  Command limit(double proposal_degc, double expert_degc) const {
    return SafetyEnvelope(settings_).limit(proposal_degc, cycle_.stored, expert_degc);
  }

  /// learn: a bounded number of steps on shadow weights.
  void learn(Supervisor<T>& supervisor) {
    const Fault fault = training_.learn(settings_, learner_settings_, learning_, replay_, scratch_);
    note(fault);
    supervisor.count_update(decision_.time, fault);
  }

  /// The first fault of a cycle is the one that is shown.
  void note(Fault fault) {
    if (decision_.fault == Fault::none) decision_.fault = fault;
  }
};

}  // namespace airside
