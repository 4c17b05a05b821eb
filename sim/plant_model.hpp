#pragma once
// A simulated room with its AHU, as any program sees it: it has a time, sensors and one setpoint.
// RcPlant and EnergyPlusPlant implement it; SimulatedPlant<T> (simulated_plant.hpp) makes it a lib Plant, and
// `airside serve` makes it a Modbus server.

#include <limits>
#include <string>
#include <vector>

#include "airside/civil_time.hpp"

namespace airside::sim {

constexpr double not_shown = std::numeric_limits<double>::quiet_NaN();

/// What the sensors show at one instant. Units: degC, kW, 0/1, m3/s.
/// What a plant does not offer is NaN, or an empty list. Sensor noise is drawn once a time step, so reading twice gives
/// the same numbers.
struct Sensors {
  std::vector<double> room_temp_degc;  ///< one a VAV
  std::vector<double> fcu_temp_degc;   ///< one an FCU
  std::vector<double> vav_on;          ///< 0/1
  std::vector<double> fcu_on;          ///< 0/1
  /// One meter: all; two: fans, chiller and pump; more: AHU fan, other fans, then the chiller in equal circuits. Of a
  /// model whose meters the site names, those.
  std::vector<double> power_kw;
  std::vector<double> damper;                 ///< 0..1, one a VAV
  std::vector<double> zone_setpoint_degc;     ///< what the zone's own thermostat cools to, one a VAV
  std::vector<double> heating_setpoint_degc;  ///< what it heats to, one a VAV
  double mau_temp_degc = 0;
  double outdoor_temp_degc = 0;
  double rain = 0;
  double supply_temp_degc = 0;
  double setpoint_degc = 0;
  double occupied = not_shown;  ///< 0/1
  double supply_flow_m3s = not_shown;
  double ahu_on = not_shown;  ///< 0/1: its fan runs
};

class PlantModel {
 public:
  virtual ~PlantModel() = default;

  /// The instant that sensors() describes.
  virtual CivilTime time() const = 0;
  /// What t of advance_to() must be a multiple of.
  virtual int step_s() const { return 180; }
  /// Simulates up to t, a multiple of step_s() not before time().
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
