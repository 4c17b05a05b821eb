#pragma once
// A room whose boxes modulate: zones of air, mass and wall nodes, a PI loop a box between minimum flow and open
// damper, reheat, a fan on its curve, mixed air with or without economizer, a coil that dries, a chiller. A year takes
// some seconds. The seed of a run decides people and sensor noise, as in RcPlant.

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sim/plant_model.hpp"
#include "sim/rc/disturbance.hpp"
#include "sim/rc/modulating_room.hpp"
#include "sim/weather/weather.hpp"

namespace airside::sim {

/// What boxes and fan show beside Sensors.
struct BoxSensors {
  std::vector<double> damper;              ///< 0..1, a box
  std::vector<double> zone_setpoint_degc;  ///< above which a box cools
  double occupied = 0;                     ///< 0/1
  double supply_flow_m3_s = 0;
  double fan_runs = 0;  ///< 0/1
};

/// Electric energy since the start, kWh.
struct ModulatingEnergy {
  double fan_kwh = 0, cooling_kwh = 0, reheat_kwh = 0;
  double total_kwh() const { return fan_kwh + cooling_kwh + reheat_kwh; }
};

/// What the people in the zones get, since the start, in occupied hours; true temperatures.
struct ZoneComfort {
  double above_degch = 0;  ///< zone degree-hours above the zone's cooling setpoint + 0.5 K, sum over zones
  double below_degch = 0;  ///< below its heating setpoint - 0.5 K
  double saturated_h = 0;  ///< zone-hours with a damper above 0.95
};

class ModulatingPlant final : public PlantModel {
 public:
  static constexpr int step_s = 180;

  /// Starts at `start`, zones near 24 degC.
  ModulatingPlant(ModulatingRoom room, std::shared_ptr<const Weather> weather, CivilTime start, std::uint64_t seed,
                  double setpoint_degc = 14.0);

  CivilTime time() const override { return now_; }
  /// Errors: std::invalid_argument if t is not a whole number of 3-min steps ahead.
  void advance_to(CivilTime t) override;
  void set_setpoint(double setpoint_degc) override { setpoint_degc_ = setpoint_degc; }
  const Sensors& sensors() const override { return sensors_; }
  std::string description() const override;

  /// From now on the fan stands still although its schedule says that it runs; false: it obeys again.
  void stop_fan(bool stopped) { fan_is_stopped_ = stopped; }
  /// From now on box z has this opening whatever its loop wants; NaN frees it.  0..1.
  void hold_damper(std::size_t z, double opening) { held_[z] = opening; }

  const BoxSensors& boxes() const { return boxes_; }
  const ModulatingRoom& room() const { return room_; }
  const ModulatingEnergy& energy() const { return energy_; }
  const ZoneComfort& comfort() const { return comfort_; }
  const std::vector<double>& zone_temp_degc() const { return air_degc_; }
  double supply_temp_degc() const { return supply_degc_; }

 private:
  struct Loop {
    double cooling = 0, heating = 0;                    // 0..1
    double cooling_integral = 0, heating_integral = 0;  // their integral parts
  };

  bool hour_within(double from_h, double to_h) const;
  bool fan_runs() const { return !fan_is_stopped_ && hour_within(room_.air.fan_start_h, room_.air.fan_stop_h); }
  void inner_step(double dt_s);
  void move_dampers(double dt_s);
  void handle_air(double dt_s);
  void warm_zones(double dt_s);
  void count(double dt_s);
  void read_sensors();
  double zone_cooling_degc(std::size_t z) const;
  double zone_heating_degc(std::size_t z) const;

  ModulatingRoom room_;
  std::shared_ptr<const Weather> weather_;
  std::uint64_t seed_;
  CivilTime now_;
  double setpoint_degc_;
  double supply_degc_;
  std::vector<double> air_degc_, mass_degc_, wall_degc_, damper_, flow_m3_s_, discharge_degc_, reheat_now_kw_;
  std::vector<double> held_;  // opening of a box that is stuck; NaN: free
  bool fan_is_stopped_ = false;
  std::vector<Loop> loops_;
  Disturbance disturbance_;
  double humidity_kg_kg_ = 0.009;  // of the rooms
  double flow_total_m3_s_ = 0;
  double fan_kw_ = 0, cooling_kw_ = 0, heating_kw_ = 0;           // electric, now
  double fan_sum_kw_ = 0, cooling_sum_kw_ = 0, heat_sum_kw_ = 0;  // mean of the 3 min
  ModulatingEnergy energy_;
  ZoneComfort comfort_;
  Sensors sensors_;
  BoxSensors boxes_;
};

}  // namespace airside::sim
