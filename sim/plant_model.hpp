#pragma once
// A simulated room with its AHU, as any program sees it: it has a time, sensors and one setpoint.
// RcPlant and EnergyPlusPlant implement it; SimulatedPlant<T> (simulated_plant.hpp) makes it a lib Plant, and
// `airside serve` makes it a Modbus server.

#include <string>
#include <vector>

#include "airside/civil_time.hpp"

namespace airside::sim {

/// What the sensors show at one instant. Units: degC, kW, 0/1.
/// Sensor noise is drawn once a time step, so reading twice gives the same numbers.
struct Sensors {
  std::vector<double> room_temp_degc;  ///< one a VAV
  std::vector<double> fcu_temp_degc;   ///< one an FCU
  std::vector<double> vav_on;          ///< 0/1
  std::vector<double> fcu_on;          ///< 0/1
  /// One meter: all; two: fans, chiller and pump; more: AHU fan, other fans, then the chiller in equal circuits.
  std::vector<double> power_kw;
  double mau_temp_degc = 0;
  double outdoor_temp_degc = 0;
  double rain = 0;
  double supply_temp_degc = 0;
  double setpoint_degc = 0;
};

class PlantModel {
 public:
  virtual ~PlantModel() = default;

  /// The instant that sensors() describes.
  virtual CivilTime time() const = 0;
  /// Simulates up to t, a multiple of 3 min not before time().
  /// Errors: std::runtime_error with the engine's own message when the simulation dies.
  virtual void advance_to(CivilTime t) = 0;
  /// Holds this supply-air temperature setpoint from time() on. degC.
  virtual void set_setpoint(double setpoint_degc) = 0;
  virtual const Sensors& sensors() const = 0;
  /// The room itself, where this is one whose sensors have faults.
  virtual const PlantModel& truth() const { return *this; }
  /// For a report's header: model, variant, weather, seed.
  virtual std::string description() const = 0;
};

}  // namespace airside::sim
