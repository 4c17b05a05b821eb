#pragma once
// Supervision: what is stored in the setpoint register and who wrote it, what the AHU makes of commands, whether the
// schedule would do better, and which control mode follows from all that.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "airside/civil_time.hpp"
#include "airside/command.hpp"
#include "airside/controller/decision.hpp"
#include "airside/demand_settings.hpp"
#include "airside/fault.hpp"
#include "airside/forecast/room_head.hpp"
#include "airside/held_rooms.hpp"
#include "airside/learning/learning_state.hpp"
#include "airside/reading.hpp"
#include "airside/settings.hpp"
#include "airside/supervision/control_mode.hpp"
#include "airside/supervision/envelope.hpp"
#include "airside/supervision/guideline36.hpp"
#include "airside/supervision/mode_arbiter.hpp"
#include "airside/supervision/mode_table.hpp"
#include "airside/supervision/schedule.hpp"
#include "airside/supervision/validation.hpp"
#include "airside/topology.hpp"

namespace airside {

/// Works on the saved cycle state of one controller, which must outlive it. Shape: T.
/// Cost: O(signals) a row.  Source: docs/box-and-safety.md, "Thresholds".
template <Topology T>
class Supervisor {
 public:
  using L = Layout<T>;
  Supervisor(const ControllerSettings& settings, CycleState<T>& cycle) : settings_(settings), cycle_(cycle) {}

  /// The schedule's setpoint, degC. Where nobody knows the hour, the working hours' setpoint: it costs energy, the
  /// night's would cost comfort.
  double expert_degc(CivilTime t) const {
    return cycle_.mode_arbiter.active(Reason::clock_not_set, t) ? settings_.expert_work_degc
                                                                : expert_setpoint_degc(settings_, t);
  }

  /// The begin of a row between two decisions: the clock, and what is stored in the register.
  void begin_row(CivilTime t, const Expected<Reading<T>>& sensed) {
    cycle_.mode_arbiter.tick(t);
    if (sensed) see_setpoint(sensed->setpoint_degc, false);
  }

  /// The begin of a cycle: as that of a row, and who wrote what is stored. `resumed`: no row since a restart.
  void begin_cycle(CivilTime t, const Expected<Reading<T>>& sensed, bool resumed, ControlMode last_mode) {
    cycle_.mode_arbiter.tick(t);
    if (settings_.objective == Objective::band) drop_forecast_reasons(t);
    if (settings_.head == 0) cycle_.mode_arbiter.set(Reason::gain_reversed, false, t);  // nobody judges it any more
    cycle_.budget.earn(settings_.writes_per_day, control_cycle(settings_).per_day());
    if (!sensed) return;
    see_setpoint(sensed->setpoint_degc, resumed);
    const bool made_again = resumed && t.seconds - cycle_.last_time.seconds == control_cycle(settings_).seconds();
    if (!made_again) adopt_setpoint(t, *sensed, resumed, last_mode);
    cycle_.contact = sensed->contact;
  }

  /// Whether supply air follows its setpoint. Returns whether air flows: where it does not, it cannot follow, and its
  /// time starts anew with the fan.
  bool watch_supply(CivilTime t, const Reading<T>& sensed) {
    const bool flows = air_flows(settings_, t, sensed.flows);
    const double away_k = std::abs(sensed.supply_temp_degc - cycle_.last_setpoint_degc);  // NaN: nothing to compare
    const bool ignores =
        cycle_.supply_ignores.lasts(flows && away_k > settings_.supply_ignored_k, t,
                                    static_cast<std::int64_t>(settings_.supply_ignored_s), seconds_per_hour);
    cycle_.mode_arbiter.set(Reason::supply_ignores_setpoint, ignores, t);
    return flows;
  }

  /// A signal that is held at its last good value is named in the decision, though control goes on.
  void name_held_signal(Decision& decision) const {
    const auto& faults = cycle_.validator.faults();
    for (std::size_t i = 0; i < faults.size() && decision.fault == Fault::none; ++i) {
      if (faults[i] == Fault::none) continue;
      decision.fault = faults[i];
      decision.fault_signal = static_cast<int>(i);
    }
  }

  /// What takes more than one reading to see: sensors that drift, authority that is lost, and what Guideline 36 would
  /// command. Returns the latter, degC.
  double watch(CivilTime t, const ValidReading<T>& valid, bool flows) {
    if (flows) watch_rooms(t, valid);
    watch_authority(t, valid, flows);
    static constexpr std::array<double, static_cast<std::size_t>(L::rooms)> all_shut{};
    const auto& v = valid.value();
    const auto rooms = static_cast<std::size_t>(rooms_of<T>(settings_.shape));
    const double* vav_on = flows ? v.data() + L::vav_on : all_shut.data();  // its loops rest with the fan
    return cycle_.guideline36.setpoint_degc(settings_, guideline36_on_site(settings_), t, {v.data(), rooms},
                                            {vav_on, rooms}, v(L::outdoor_temp));
  }

  /// What nothing may be learned from though each reading is good: a room that drifts, air that does not follow its
  /// setpoint or does not flow (a gain learned then would be that of a closed valve), hours that nobody knows.
  bool doubted(CivilTime t, bool flows) const {
    const ModeArbiter& on = cycle_.mode_arbiter;
    return !flows || on.active(Reason::sensor_drifts, t) || on.active(Reason::supply_ignores_setpoint, t) ||
           on.active(Reason::clock_not_set, t);
  }

  /// The proposal, or the stored setpoint where the move to it is not worth a write.
  double worth_a_write(double proposal_degc) const {
    const double stored = cycle_.last_setpoint_degc;
    if (settings_.writes_per_day <= 0 || !std::isfinite(stored)) return proposal_degc;
    return cycle_.budget.allows(proposal_degc - stored, settings_.writes_per_day) ? proposal_degc : stored;
  }

  /// The gravest of what a decision found and what the mode arbiter remembers.
  ActiveMode settle(ControlMode mode, Reason reason, CivilTime t) const {
    const Reason remembered = cycle_.mode_arbiter.gravest(t);
    const ControlMode asked = request_of(remembered).mode;
    const bool graver = asked > mode || (asked == mode && reason == Reason::none);
    return graver ? ActiveMode{asked, remembered} : ActiveMode{mode, reason};
  }

  /// What the AHU made of a command. While no air flows a setpoint that rests is no sign of anything.
  void account(const Decision& decision, const Expected<Applied>& applied, bool flows) {
    const CivilTime t = decision.time;
    if (decision.mode == ControlMode::release) return;
    if (!applied && applied.error() == Fault::write_refused) {
      cycle_.mode_arbiter.set(Reason::write_refused, true, t);
      if (++cycle_.refused_writes >= 2) cycle_.mode_arbiter.hold(Reason::writes_refused, t, seconds_per_hour);
    }
    // A register that shows what no setpoint can be: control must not seem to go on.
    if (!applied && applied.error() == Fault::out_of_range) cycle_.mode_arbiter.set(Reason::setpoint_altered, true, t);
    const bool lost = !applied && applied.error() == Fault::not_applied && std::isfinite(decision.held_degc);
    if (lost && ++cycle_.lost_writes >= 2) cycle_.mode_arbiter.set(Reason::setpoint_altered, true, t);
    if (!applied) return;
    cycle_.lost_writes = cycle_.refused_writes = 0;
    cycle_.mode_arbiter.set(Reason::write_refused, false, t);
    const double altered_k = std::abs(applied->setpoint_degc - decision.command.setpoint_degc());
    const bool altered = altered_k > std::max(foreign_k, 0.5 * settings_.readback_step_k + 1e-9);
    // What the AHU made another value of was written too, and is again each time.
    const bool written = applied->setpoint_degc != cycle_.last_setpoint_degc || altered;
    if (settings_.writes_per_day > 0 && written) cycle_.budget.spend(settings_.writes_per_day);
    cycle_.mode_arbiter.set(Reason::setpoint_altered, altered, t);
    if (!flows) return;
    const bool rests =
        cycle_.excitation.cycle(applied->setpoint_degc, settings_.excitation_k, control_cycle(settings_).per_day());
    const bool learns = cycle_.has_weights != 0 && settings_.objective == Objective::mean;
    cycle_.mode_arbiter.set(Reason::no_excitation, rests && learns, t);
  }

  /// Whether the schedule would do better, in working hours.
  void compare_with_schedule(CivilTime t, double held_degc, double gain) {
    if (cycle_.ours == 0 || !in_working_hours(settings_, cycle_.last_time)) return;
    cycle_.shadow.cycle(settings_, held_degc, cycle_.last_setpoint_degc,
                        expert_setpoint_degc(settings_, cycle_.last_time), gain);
    const bool worse = cycle_.shadow.worse(settings_);
    cycle_.mode_arbiter.set(Reason::worse_than_schedule, worse, t);
    cycle_.worse_cycles = worse ? cycle_.worse_cycles + 1 : 0;
    if (cycle_.worse_cycles * control_cycle(settings_).seconds() < settings_.worse_h * 3600) return;
    cycle_.mode_arbiter.hold(Reason::worse_for_long, t, seconds_per_day);
    cycle_.mode_arbiter.set(Reason::worse_than_schedule, false, t);
    cycle_.shadow.reset();
    cycle_.worse_cycles = 0;
  }

  /// A gain that has turned round is believed again when it is sane beyond doubt. A head that has learned a wrong
  /// gain would take weeks to recover, so after a day it begins anew, and learns from the schedule's steps.
  void watch_gain(CivilTime t, RoomHead<T>& head) {
    const bool suspect = cycle_.mode_arbiter.active(Reason::gain_reversed, t) && !head.gain_is_sane();
    const bool reversed = head.gain_is_reversed() || suspect;
    if (cycle_.gain_reversed.lasts(reversed, t, seconds_per_day)) {
      head.reset(settings_, settings_.head_gain_prior, settings_.head_gain_prior_sd);
      cycle_.gain_reversed = PersistentCondition();
    }
    cycle_.mode_arbiter.set(Reason::gain_reversed, reversed, t);
  }

  /// Counts updates of the weights that were refused in a row; too many freeze them for a day.
  void count_update(CivilTime t, Fault fault) {
    cycle_.refused_updates = fault == Fault::none ? 0 : cycle_.refused_updates + 1;
    if (cycle_.refused_updates < settings_.refused_updates) return;
    cycle_.mode_arbiter.hold(Reason::learning_refused, t, seconds_per_day);
    cycle_.refused_updates = 0;
  }

 private:
  static constexpr double foreign_k = 0.05;  ///< a setpoint differs by more than a register's rounding

  /// What was found of network and room head while the site had the objective "mean" would hold for ever under "band",
  /// where neither is asked or judged.
  void drop_forecast_reasons(CivilTime t) {
    for (const Reason r : {Reason::no_excitation, Reason::worse_than_schedule, Reason::worse_for_long,
                           Reason::learning_refused, Reason::gain_reversed, Reason::forecasts_doubted}) {
      cycle_.mode_arbiter.set(r, false, t);
    }
  }

  /// What is stored in the register. A decision that is made again after a crash (`resumed`) may find its own write
  /// there, a step from the value before at most: then both count, so that it is made as it was.
  void see_setpoint(double stored_degc, bool resumed) {
    if (!std::isfinite(stored_degc)) return;
    StoredSetpoint either = cycle_.stored;
    either.may_be(stored_degc);
    if (!resumed || either.high_degc - either.low_degc > settings_.limit_change_k) either.is(stored_degc);
    cycle_.stored = either;
  }

  /// After a start, a refused write or an external override, the AHU's setpoint is what the register shows.
  /// Nothing is learned from the cycle that this breaks. An override is left alone for a while; a device that was out
  /// of touch may have fallen back to a default, and one that was slow shows the value written last.
  void adopt_setpoint(CivilTime t, const Reading<T>& sensed, bool resumed, ControlMode last_mode) {
    const double stored = sensed.setpoint_degc, known = cycle_.last_setpoint_degc;
    if (!std::isfinite(stored) || (std::isfinite(known) && std::abs(stored - known) <= foreign_k)) return;
    const bool late = std::abs(stored - cycle_.commanded_degc) <= foreign_k;
    if (std::isfinite(known) && !late && !resumed && sensed.contact == cycle_.contact) {
      // While control is released, a person may set it as often as he likes.
      const bool competes = last_mode != ControlMode::release && cycle_.override_monitor.third_in_a_day(t);
      const auto patience_s = static_cast<std::int64_t>(settings_.override_h * 3600);
      cycle_.mode_arbiter.hold(competes ? Reason::two_masters : Reason::overridden, t, patience_s);
    }
    cycle_.last_setpoint_degc = stored;
    cycle_.usable_cycles = 0;
  }

  /// Whether a room sensor drifts.
  void watch_rooms(CivilTime t, const ValidReading<T>& valid) {
    if (!valid.learnable()) return;
    const bool drifts = cycle_.drift.row(valid.value().head(rooms_of<T>(settings_.shape)), settings_.drift_k);
    cycle_.mode_arbiter.set(Reason::sensor_drifts, drifts, t);
  }

  /// Whether the setpoint has been at a limit of its range for long and the rooms do not come nearer to their target:
  /// in working hours, while air flows. Nobody is called at night for rooms that nobody is in.
  void watch_authority(CivilTime t, const ValidReading<T>& valid, bool flows) {
    // Where boxes modulate, a setpoint at its limit is a choice, and the target is not what it serves.
    const bool serves_mean = settings_.objective == Objective::mean;
    const bool counts = serves_mean && flows && in_working_hours(settings_, t);
    const bool lost = cycle_.authority.row(
        settings_, t, cycle_.last_setpoint_degc,
        counts ? held_degc<T>(settings_.held, settings_.shape, valid.value()) : settings_.target_degc);
    cycle_.mode_arbiter.set(Reason::authority_lost, lost, t);
  }

  const ControllerSettings& settings_;
  CycleState<T>& cycle_;
};

}  // namespace airside
