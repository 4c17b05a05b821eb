#pragma once
// What a plant says at one instant, before anybody has checked it.

#include <Eigen/Core>
#include <cstdint>
#include <limits>

#include "airside/civil_time.hpp"
#include "airside/topology.hpp"

namespace airside {

/// One sample of all sensed signals. Shape: value, age_s: Layout<T>::signals; a signal that the site lacks is NaN.
/// Units: signals.hpp.
template <Topology T>
struct Reading {
  using Vector = Eigen::Matrix<double, Layout<T>::signals, 1>;

  CivilTime time;  ///< when the plant was asked; a row counts by its own instant
  Vector value = Vector::Constant(std::numeric_limits<double>::quiet_NaN());
  Vector age_s = Vector::Zero();  ///< s since the device took the value
  /// What the AHU says its setpoint is, degC; NaN where it cannot be read back.
  double setpoint_degc = std::numeric_limits<double>::quiet_NaN();
  /// Measured supply-air temperature, degC; NaN where there is no sensor. Not a network input.
  double supply_temp_degc = std::numeric_limits<double>::quiet_NaN();
  using Rooms = Eigen::Matrix<double, Layout<T>::rooms, 1>;
  /// Position of each box's damper, 0..1, and what its zone's own control cools and heats to, degC; NaN where no point
  /// shows it.
  Rooms damper = Rooms::Constant(std::numeric_limits<double>::quiet_NaN());
  Rooms zone_setpoint_degc = Rooms::Constant(std::numeric_limits<double>::quiet_NaN());
  Rooms zone_heating_setpoint_degc = Rooms::Constant(std::numeric_limits<double>::quiet_NaN());
  double occupied = std::numeric_limits<double>::quiet_NaN();         ///< 1: people are there; 0: nobody; NaN: no point
  double supply_flow_m3s = std::numeric_limits<double>::quiet_NaN();  ///< of supply air
  /// 1: the AHU's fan runs; 0: it rests; NaN where no point shows it.
  double flows = std::numeric_limits<double>::quiet_NaN();
  /// Counts up, from 1 in each process, whenever the device was out of touch in between; it may have restarted, and
  /// stand at a default.
  std::uint64_t contact = 0;
};

}  // namespace airside
