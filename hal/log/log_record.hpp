#pragma once
// One row of the log from one row of the loop.

#include <algorithm>
#include <cstddef>
#include <limits>

#include "airside/controller/cycle.hpp"
#include "airside/controller/decision.hpp"
#include "airside/reading.hpp"
#include "airside/signals.hpp"
#include "airside/supervision/mode_table.hpp"
#include "airside/topology.hpp"
#include "hal/log/log_csv.hpp"

namespace airside::hal {

/// A row's signals in the order of Layout<T>; NaN in slots that a site of this shape has no place for.
template <Topology T>
typename Reading<T>::Vector signals_of(const LogRow& row, const Shape& site) {
  using Vector = typename Reading<T>::Vector;
  Vector value = Vector::Constant(std::numeric_limits<double>::quiet_NaN());
  for (int i = 0; i + 1 < site.inputs(); ++i) value(slot_of<T>(site, i)) = row.value[static_cast<std::size_t>(i)];
  return value;
}

/// A row as the reading that it was made of, as far as it says: ages and contacts are not logged.
template <Topology T>
Reading<T> reading_of(const LogRow& row, const Shape& site, std::span<const SideColumn> sides) {
  Reading<T> reading;
  reading.time = row.time;
  reading.value = signals_of<T>(row, site);
  reading.supply_temp_degc = row.supply_temp_degc;
  for (std::size_t i = 0; i < std::min(sides.size(), row.side.size()); ++i) {
    const Eigen::Index place = sides[i].place - 1;
    switch (sides[i].signal) {
      case SideSignal::damper: reading.damper(place) = row.side[i]; break;
      case SideSignal::zone_setpoint: reading.zone_setpoint_degc(place) = row.side[i]; break;
      case SideSignal::zone_heating_setpoint: reading.zone_heating_setpoint_degc(place) = row.side[i]; break;
      case SideSignal::occupied: reading.occupied = row.side[i]; break;
      case SideSignal::supply_flow: reading.supply_flow_m3s = row.side[i]; break;
      case SideSignal::ahu_on: reading.flows = row.side[i]; break;
    }
  }
  return reading;
}

/// Fills `row` (from make_log_row) with what was sensed at t on a site of this shape, and what the controller last
/// decided.
/// `setpoint_degc` holds from t on. Cost: no heap.
template <Topology T>
void fill_log_row(LogRow& row, const Shape& site, CivilTime t, const Expected<Reading<T>>& sensed,
                  const Decision& decision, double setpoint_degc) {
  constexpr double none = ControllerColumns::none;
  row.time = t;
  row.setpoint_degc = setpoint_degc;
  row.supply_temp_degc = sensed ? sensed->supply_temp_degc : none;
  for (int i = 0; i + 1 < site.inputs(); ++i) {
    row.value[static_cast<std::size_t>(i)] = sensed ? sensed->value(slot_of<T>(site, i)) : none;
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
  c.expected_held_degc = decided ? decision.expected_degc : none;
  c.expected_error_k = decided ? decision.expected_error_k : none;
  c.residual_forecast_k = decided ? decision.residual_k : none;
  c.residual_share = decided ? decision.residual_share : none;
}

/// Fills what the site shows beside the network's inputs, in the order of `sides`. Cost: no heap.
template <Topology T>
void fill_sides(LogRow& row, std::span<const SideColumn> sides, const Expected<Reading<T>>& sensed) {
  for (std::size_t i = 0; i < sides.size(); ++i) {
    double& value = row.side[i];
    value = ControllerColumns::none;
    if (!sensed) continue;
    const Eigen::Index place = sides[i].place - 1;
    switch (sides[i].signal) {
      case SideSignal::damper: value = sensed->damper(place); break;
      case SideSignal::zone_setpoint: value = sensed->zone_setpoint_degc(place); break;
      case SideSignal::zone_heating_setpoint: value = sensed->zone_heating_setpoint_degc(place); break;
      case SideSignal::occupied: value = sensed->occupied; break;
      case SideSignal::supply_flow: value = sensed->supply_flow_m3s; break;
      case SideSignal::ahu_on: value = sensed->flows; break;
    }
  }
}

}  // namespace airside::hal
