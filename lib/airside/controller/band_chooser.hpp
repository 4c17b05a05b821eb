#pragma once
// Choosing where boxes modulate: the objective "band" sees every row, learns from every cycle, and proposes the
// setpoint of least cost. Neither network nor room head has a part in it.

#include <cmath>

#include "airside/controller/demand_watch.hpp"
#include "airside/controller/pending_cycle.hpp"
#include "airside/demand/band_objective.hpp"
#include "airside/demand/demand_reading.hpp"
#include "airside/demand_settings.hpp"
#include "airside/learning/learning_state.hpp"
#include "airside/reading.hpp"
#include "airside/settings.hpp"
#include "airside/supervision/control_mode.hpp"
#include "airside/supervision/validation.hpp"
#include "airside/topology.hpp"

namespace airside {

/// Works on the saved cycle state of one controller, which must outlive it. Shape: T.
/// Cost: that of BandObjective.  Source: docs/method.md 17.
template <Topology T>
class BandChooser {
 public:
  BandChooser(const ControllerSettings& settings, CycleState<T>& cycle) : settings_(settings), cycle_(cycle) {}

  /// A row, decisions' rows included. `counts`: false where no air flows, or nothing may be learned from the row.
  void observe(const Reading<T>& sensed, const ValidReading<T>& valid, bool counts) {
    cycle_.band.observe(settings_.demand, DemandWatch<T>(settings_, cycle_, sensed, valid.value()).reading(counts));
  }

  /// A row of a history: what would have been chosen is computed as well, since the fan's next start begins on it.
  void remember(const Reading<T>& sensed, const ValidReading<T>& valid, bool counts) {
    observe(sensed, valid, counts);
    if (!band_cycle.starts(sensed.time)) return;
    (void)propose(sensed, valid, air_flows(settings_, sensed.time, sensed.flows),
                  expert_setpoint_degc(settings_, sensed.time));
  }

  /// The setpoint of least cost; while the fan rests that of its last start; the schedule's while too little has been
  /// learned.
  /// Units: degC. Errors: reason signal_lost where the dampers or zone setpoints are lost that carry the objective.
  Proposal propose(const Reading<T>& sensed, const ValidReading<T>& valid, bool flows, double schedule_degc) {
    const DemandWatch<T> watch(settings_, cycle_, sensed, valid.value());
    const DemandReading at = watch.reading(flows);
    const double chosen = cycle_.band.choose(settings_.demand, at, watch.choice(schedule_degc)).setpoint_degc;
    if (flows && !BandObjective::carries(at)) return {.missing = Reason::signal_lost};
    return {.setpoint_degc = std::isfinite(chosen) ? chosen : schedule_degc};
  }

 private:
  const ControllerSettings& settings_;
  CycleState<T>& cycle_;
};

}  // namespace airside
