#pragma once
// One row of the log from one row of the loop.

#include "airside/controller/cycle.hpp"
#include "airside/controller/decision.hpp"
#include "airside/signals.hpp"
#include "airside/supervision/mode_table.hpp"
#include "hal/log/log_csv.hpp"

namespace airside::hal {

/// Fills `row` (from make_log_row) with what was sensed at t and what the controller last decided.
/// `setpoint_degc` holds from t on. Cost: no heap.
template <Topology T>
void fill_log_row(LogRow& row, CivilTime t, const Expected<Reading<T>>& sensed, const Decision& decision,
                  double setpoint_degc) {
  constexpr double none = ControllerColumns::none;
  row.time = t;
  row.setpoint_degc = setpoint_degc;
  row.supply_temp_degc = sensed ? sensed->supply_temp_degc : none;
  for (int i = 0; i < Layout<T>::signals; ++i) {
    row.value[static_cast<std::size_t>(i)] = sensed ? sensed->value(i) : none;
  }
  ControllerColumns& c = row.controller;
  c.mode = text_of(decision.mode);
  c.reason = text_of(decision.reason);
  c.fault = text_of(sensed ? decision.fault : sensed.error());
  c.a_expert_degc = decision.expert_degc;
  c.a_g36_degc = decision.g36_degc;
  c.confidence = decision.confidence;
  const bool decided = decision.time == t;
  c.a_network_degc = decided ? decision.network_degc : none;
  c.a_head_degc = decided ? decision.head_degc : none;
  c.loss_strb = decided ? decision.loss.strb : none;
  c.loss_tdb = decided ? decision.loss.tdb : none;
  c.loss_gc = decided ? decision.loss.gc : none;
  c.loss_rc = decided ? decision.loss.rc : none;
  c.loss_rec = decided ? decision.loss.rec : none;
}

}  // namespace airside::hal
