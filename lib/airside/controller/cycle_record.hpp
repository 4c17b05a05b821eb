#pragma once
// Remembering: what the last cycle left to a decision, and what the AHU took of it.

#include <algorithm>
#include <cstdint>

#include "airside/civil_time.hpp"
#include "airside/command.hpp"
#include "airside/controller/decision.hpp"
#include "airside/controller/pending_cycle.hpp"
#include "airside/fault.hpp"
#include "airside/learning/learning_state.hpp"
#include "airside/settings.hpp"
#include "airside/supervision/control_mode.hpp"
#include "airside/topology.hpp"

namespace airside {

/// What became of a command. Units: degC.
struct CommandOutcome {
  double setpoint_degc = Decision::none;  ///< in the AHU's register from now on, NaN: unknown
  bool is_applied = false;                ///< written and read back
  bool is_released = false;               ///< not to be written

  double applied_degc() const { return is_applied ? setpoint_degc : Decision::none; }
};

/// Works on the saved cycle state of one controller, which must outlive it. Shape: T.
template <Topology T, class Scalar>
class CycleRecord {
 public:
  using Pending = PendingCycle<T, Scalar>;
  CycleRecord(const ControllerSettings& settings, CycleState<T>& cycle)
      : cycle_s_(control_cycle(settings).seconds()), cycle_(cycle) {}

  /// A decision before its reading is looked into: the schedule's command, and what the last cycle left.
  Pending begin(CivilTime t, double expert_degc, const Command& command) const {
    Pending pending(Decision{.time = t, .command = command});
    pending.expert_degc = expert_degc;
    pending.confidence = cycle_.confidence;
    pending.now = cycle_.last_value;
    pending.features = cycle_.features;
    return pending;
  }

  /// Where nothing was written, the register still holds what was read; where a write failed, nobody knows.
  CommandOutcome outcome_of(const Pending& pending, const Expected<Applied>& applied) const {
    const bool released = pending.mode == ControlMode::release || (!applied && applied.error() == Fault::released);
    if (applied) return {.setpoint_degc = applied->setpoint_degc, .is_applied = true, .is_released = released};
    return {.setpoint_degc = released ? cycle_.last_setpoint_degc : Decision::none, .is_released = released};
  }

  /// Makes the cycle that begins now the last one.
  void finish(const Pending& pending, const CommandOutcome& outcome) {
    const bool follows = pending.time.seconds - cycle_.last_time.seconds == cycle_s_;
    cycle_.features = pending.features;
    cycle_.residual.features = pending.residual_features;
    cycle_.residual.has_features = pending.has_residual_features && outcome.is_applied ? 1 : 0;
    cycle_.residual.forecast_k = outcome.is_applied ? pending.residual_k : Decision::none;
    cycle_.has_features = pending.has_features && outcome.is_applied ? 1 : 0;
    cycle_.before_setpoint_degc = cycle_.last_setpoint_degc;
    cycle_.last_value = pending.now;
    cycle_.last_time = pending.time;
    cycle_.last_setpoint_degc = outcome.setpoint_degc;
    if (outcome.is_applied) cycle_.stored.is(outcome.setpoint_degc);
    if (!outcome.is_applied && !outcome.is_released) cycle_.stored.may_be(pending.command.setpoint_degc());
    cycle_.commanded_degc = outcome.is_applied ? pending.command.setpoint_degc() : Decision::none;
    cycle_.ours = outcome.is_applied && pending.mode <= ControlMode::run ? 1 : 0;
    const std::int32_t usable_before = follows ? cycle_.usable_cycles : 0;
    // A cycle that begins without flow shows nothing of the setpoint, also where the fan starts in it.
    const bool usable = pending.is_usable && pending.flows && outcome.is_applied;
    cycle_.usable_cycles = usable ? std::min<std::int32_t>(usable_before + 1, 3) : 0;
  }

 private:
  std::int64_t cycle_s_;
  CycleState<T>& cycle_;
};

}  // namespace airside
