#pragma once
// The room as a resistance-capacitance network: per zone an air, a mass and a wall node, explicit steps of at most
// a minute, an AHU with a lagging and limited coil, VAV boxes, fan coils with thermostats, a make-up air unit, and
// sensors with noise. A year takes about a second. A copy is a branch of the simulation.

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "sim/plant_model.hpp"
#include "sim/rc/disturbance.hpp"
#include "sim/rc/rc_room.hpp"
#include "sim/weather/recording.hpp"
#include "sim/weather/weather.hpp"

namespace airside::sim {

struct RcNetwork;

/// Heat since the start of the run, each positive into the room's nodes.  kJ.
/// stored = sum of the others, to rounding.
struct RcEnergy {
  double stored_kj = 0;
  double gains_kj = 0, solar_kj = 0, outdoors_kj = 0, neighbour_kj = 0, mau_kj = 0, vav_kj = 0, fcu_kj = 0;
  double entered_kj() const { return gains_kj + solar_kj + outdoors_kj + neighbour_kj + mau_kj + vav_kj + fcu_kj; }
};

class RcPlant final : public PlantModel {
 public:
  /// Starts at `start` with the room near 25 degC, supply at `setpoint_degc`.
  /// Errors: hal::InputError if the room is not valid, too stiff, or the weather does not cover the start.
  RcPlant(RcRoom room, std::shared_ptr<const Weather> weather, CivilTime start, std::uint64_t seed,
          double setpoint_degc = 22.5);

  static constexpr int step_s = 180;

  CivilTime time() const override { return now_; }
  /// Errors: std::invalid_argument if t is not a whole number of 3-min steps ahead; hal::InputError past the weather.
  void advance_to(CivilTime t) override;
  void set_setpoint(double setpoint_degc) override;
  const Sensors& sensors() const override { return sensors_; }
  std::string description() const override;

  const RcRoom& room() const { return *room_; }
  const Weather& weather() const { return *weather_; }
  /// True air temperature of every zone, VAV zones first; no noise, no rounding.  degC.
  const std::vector<double>& zone_temp_degc() const { return air_degc_; }
  /// Mean over the VAV zones of the true air temperature.  degC.
  double mean_room_temp_degc() const;
  /// Mean over the VAVs of what their sensors would show without noise and rounding: bias, drift, lag and jet
  /// included. What scores and floors are about.  degC.
  double mean_shown_temp_degc() const;
  /// Share of the last 3 min in which each FCU ran.
  const std::vector<double>& fcu_duty() const { return fcu_duty_; }
  /// What acts on the room in the step that starts now.
  const Disturbance& disturbance() const { return disturbance_; }
  double supply_temp_degc() const { return supply_degc_; }
  double setpoint_degc() const { return setpoint_degc_; }
  /// Cooling that the AHU coil gives, latent part included; averaged over the last step.  kW.
  double coil_load_kw() const { return coil_load_kw_; }
  const RcEnergy& energy() const { return energy_; }

  /// From now on weather, gains, FCU and VAV status and MAU stay as they are: what a controller without a forecast
  /// assumes. For use on a copy.
  void freeze_disturbances() {
    future_ = Future::frozen;
    frozen_at_ = now_;
  }
  /// From now on disturbances follow the expected daily profile without its random part; thermostats go on working.
  void expect_disturbances() {
    future_ = Future::expected;
    frozen_at_ = now_;
    held_ = disturbance_;
  }

  /// From now on heat that the room does not know of flows into the air of its zones, VAV zones first.  kW.
  /// A recording that is followed and has heat of its own takes its place.
  /// Errors: std::invalid_argument unless there is one a zone.
  void set_zone_heat(const std::vector<double>& kw);

  /// From now on boxes and, unless `thermostats`, fan coils do what was recorded.
  void follow(std::shared_ptr<const Recording> recording, bool thermostats) {
    recording_ = std::move(recording);
    own_thermostats_ = thermostats;
    obey_recording();
  }

  /// From now on boxes and fan coils do what somebody commands, whatever their schedules and thermostats want; NaN:
  /// left to these.  Shape: one a VAV, one an FCU.  Units: 0 closed or off, 1 open or on.
  void command(std::vector<double> vav_on, std::vector<double> fcu_on);

  /// From now on sensors show numbers that are not rounded: differences of two runs would drown in rounding.
  void show_exact_values() { exact_ = true; }

 private:
  enum class Future { actual, frozen, expected };

  void step();
  void cool_supply();
  void update_sun();
  void mix_zones();
  void inner_step();
  void update_disturbance();
  void obey_recording();
  void obey_commands();
  void update_thermostats();
  void update_airflow();
  void update_power();
  void read_sensors();
  double shown_temp_degc(std::size_t vav) const;
  double damper(std::size_t vav) const;
  bool ahu_rests() const;
  CivilTime true_time() const;

  std::shared_ptr<const RcRoom> room_;
  std::shared_ptr<const Weather> weather_;
  std::shared_ptr<const RcNetwork> network_;  // shared by copies
  std::shared_ptr<const Recording> recording_;
  bool own_thermostats_ = true, exact_ = false;
  std::uint64_t seed_;
  CivilTime start_, now_, frozen_at_;
  Future future_ = Future::actual;
  Disturbance disturbance_, held_;

  std::vector<double> air_degc_, mass_degc_, wall_degc_, deep_degc_, sensed_degc_, flux_w_;
  std::vector<double> wall_sun_k_;                     // what the sun adds to a wall's skin
  std::vector<double> sun_w_, sol_air_k_;              // through windows; what a skin without inertia has
  std::vector<double> vav_w_k_;                        // capacity flow of each box that reaches its zone
  std::vector<double> heat_w_;                         // zone; of set_zone_heat; empty: none
  std::vector<double> fcu_on_, fcu_duty_, fcu_cold_;   // cold: 0..1, how far its coil is
  std::vector<double> vav_commanded_, fcu_commanded_;  // of command(); empty: none
  double ahu_w_k_ = 0;                                 // capacity flow through the AHU coil
  double setpoint_degc_, supply_degc_, duct_degc_, mau_degc_ = 18;
  double water_k_ = 0;  // warmer chilled water
  double coil_load_kw_ = 0, mau_load_kw_ = 0, fcu_load_kw_ = 0;
  double fan_kw_ = 0, chiller_kw_ = 0;
  RcEnergy energy_;
  Sensors sensors_;
};

}  // namespace airside::sim
