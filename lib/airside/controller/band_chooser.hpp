#pragma once
// Choosing where boxes modulate: the objective "band" sees every row, learns from every cycle, and proposes the
// setpoint of least cost. Neither network nor room head has a part in it.

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "airside/civil_time.hpp"
#include "airside/controller/demand_watch.hpp"
#include "airside/controller/pending_cycle.hpp"
#include "airside/demand/band_objective.hpp"
#include "airside/demand/demand_reading.hpp"
#include "airside/demand_settings.hpp"
#include "airside/forecast/candidate_record.hpp"
#include "airside/learning/learning_state.hpp"
#include "airside/reading.hpp"
#include "airside/settings.hpp"
#include "airside/supervision/control_mode.hpp"
#include "airside/supervision/schedule.hpp"
#include "airside/supervision/validation.hpp"
#include "airside/topology.hpp"

namespace airside {

/// Works on the saved cycle state of one controller, which must outlive it. Shape: T.
/// Cost: that of BandObjective.  Source: docs/method.md 17.
template <Topology T>
class BandChooser {
 public:
  BandChooser(const ControllerSettings& settings, CycleState<T>& cycle) : settings_(settings), cycle_(cycle) {}

  /// A row, decisions' rows included. `flows`: air does; `counts`: it does, and the row may be learned from.
  void observe(const Reading<T>& sensed, const ValidReading<T>& valid, bool flows, bool counts) {
    cycle_.band.observe(settings_.demand, DemandWatch<T>(settings_, cycle_, sensed, valid).reading(counts, flows));
  }

  /// A row of a history: what would have been chosen is computed as well, since the fan's next start begins on it.
  void remember(const Reading<T>& sensed, const ValidReading<T>& valid, bool counts) {
    const CivilTime t = valid.time();
    const bool flows = air_flows(settings_, t, sensed.flows);
    observe(sensed, valid, flows, counts);
    if (!band_cycle.starts(t)) return;
    (void)propose(sensed, valid, flows, expert_setpoint_degc(settings_, t));
  }

  /// The setpoint of least cost; while the fan rests that of its last start; the schedule's while too little has been
  /// learned.
  /// Units: degC. Errors: reason signal_lost where the dampers or zone setpoints are lost that carry the objective.
  /// `record`: keeps what each candidate was expected to cost, where there is one.
  Proposal propose(const Reading<T>& sensed, const ValidReading<T>& valid, bool flows, double schedule_degc,
                   CandidateRecord* record = nullptr) {
    const DemandWatch<T> watch(settings_, cycle_, sensed, valid);
    const DemandReading at = watch.reading(flows, flows);
    const DemandChoice choice = watch.choice(schedule_degc);
    if (record != nullptr && flows && cycle_.band.is_ready(settings_.demand) && BandObjective::carries(at)) {
      note(at, choice, *record);
    }
    const double chosen = cycle_.band.choose(settings_.demand, at, choice).setpoint_degc;
    if (flows && !BandObjective::carries(at)) return {.missing = Reason::signal_lost};
    const double proposed = std::isfinite(chosen) ? chosen : schedule_degc;
    if (record != nullptr) record->proposed_degc = proposed;
    return {.setpoint_degc = proposed};
  }

 private:
  /// The whole range, of which choose() may take a part: it warms up in steps.
  void note(const DemandReading& at, const DemandChoice& choice, CandidateRecord& record) const {
    const double span = choice.max_degc - choice.min_degc;
    const int n = static_cast<int>(std::lround(span / choice.step_k)) + 1;
    (void)record.take_grid(choice.min_degc, choice.step_k, n);
    for (int i = 0; i < record.count; ++i) {
      const double a = std::min(record.from_degc + i * record.step_k, choice.max_degc);
      record.cost_kw[static_cast<std::size_t>(i)] =
          static_cast<float>(cycle_.band.evaluate(settings_.demand, at, choice, a).cost_kw);
    }
    record.has_cost = true;
  }

  const ControllerSettings& settings_;
  CycleState<T>& cycle_;
};

}  // namespace airside
