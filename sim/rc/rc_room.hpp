#pragma once
// Every number that describes an RC room: the building, its people, its air handling, its sensors and what may be
// wrong with each. Zones are numbered VAV zones first (interior), then FCU zones (perimeter). The fields are also
// listed in a table (room_fields), which the files, the perturbations and the gap workflow go through.

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

namespace airside::sim {

/// Parameters of a room; the defaults are the digital twin "rc".  A vector has one entry a zone, VAV or FCU, as said.
struct RcRoom {
  std::string name = "rc";
  std::uint64_t seed = 0;  ///< mixed into a run's seed: two rooms never share their people's whims
  int vavs = 0, fcus = 0, powers = 0;
  int zones() const { return vavs + fcus; }

  // Envelope and mass
  std::vector<double> floor_area_m2;        ///< zone
  std::vector<double> volume_m3;            ///< zone
  std::vector<double> air_capacity_factor;  ///< zone; heat capacity of air and light things over that of the air
  std::vector<double> mass_kj_k;            ///< zone; furniture, slab surface
  std::vector<double> mass_ua_w_k;          ///< zone; air to mass
  std::vector<double> wall_kj_k;            ///< zone; opaque outside wall
  std::vector<double> wall_ua_w_k;          ///< zone; air to outside through the wall
  std::vector<double> wall_area_m2;         ///< zone; for sun and rain on the wall
  std::vector<double> window_north_m2, window_east_m2, window_south_m2, window_west_m2;  ///< zone
  std::vector<double> infiltration_share;                                                ///< zone; how exposed it is
  std::vector<double> neighbour_ua_w_k;  ///< zone; to the space next door, above, below
  std::vector<double> deep_kj_k;         ///< zone; slab or core wall behind the mass
  std::vector<double> deep_ua_w_k;       ///< zone; mass to that slab; 0: there is none
  double capacity_factor = 1;            ///< times every heat capacity
  double envelope_factor = 1;            ///< times wall and window conductance
  double window_u_w_m2k = 0.84;          ///< docs/method.md, open point 23
  double shgc = 0.35;
  double solar_factor_north = 1, solar_factor_east = 1, solar_factor_south = 1, solar_factor_west = 1;
  double solar_to_mass_share = 0.55;
  double wall_absorptance = 0.5;
  double wall_film_w_m2k = 20;
  double wall_sun_lag_s = 0;                ///< cladding: the wall's skin feels the sun so much later
  double rain_wall_drop_k = 3;              ///< the wet wall's outside temperature falls by this
  double infiltration_ach = 0.25;           ///< air changes an hour, constant part
  double infiltration_wind_ach_s_m = 0.03;  ///< a m/s of wind
  double infiltration_stack_ach_k = 0.01;   ///< a K between in- and outside
  double neighbour_temp_degc = 25.5;
  double mixing_interior_m3_s = 0.20;   ///< between neighbouring VAV zones, each way
  double mixing_perimeter_m3_s = 0.10;  ///< between neighbouring FCU zones
  double mixing_across_m3_s = 0.08;     ///< between a VAV zone and its FCU zone
  std::vector<double> door_ach;         ///< zone; air changes an hour while a door to the outside stands open
  double door_days_share = 0.45;        ///< of days on which it does, some hours of the working day

  // Gains
  std::vector<double> gain_factor;  ///< zone
  double gain_base_w_m2 = 10;
  double gain_occupied_w_m2 = 16;    ///< times the occupancy 0..1
  double gain_after_hours_w_m2 = 0;  ///< 19:00 to 22:00
  double gain_lunch_w_m2 = 0;        ///< 12:00 to 13:00
  double gain_weekend_w_m2 = 0;      ///< Saturday and Sunday, occupancy hours
  double gain_radiant_share = 0.35;  ///< goes to the mass
  double occupancy_start_h = 7.5, occupancy_end_h = 18.75;
  double occupancy_ramp_h = 1.25;
  double occupancy_lunch_dip = 0.25;
  double occupancy_weekend_factor = 1;  ///< 1: every day is a working day (docs/method.md, open point 19)
  double occupancy_shift_h = 0;         ///< whole profile later by this
  double occupancy_day_sd = 0.10;       ///< of the whole floor, day to day
  double occupancy_zone_sd = 0.15;      ///< of a zone, over some hours
  double occupancy_noise_sd = 0.18;     ///< of a zone, over minutes
  double arrival_sd_min = 10;
  double occupancy_absent_share = 0;  ///< chance that a zone's people stay away for a day
  double plenum_gain_share = 0;       ///< of VAV zones' gains: rises into the return air, not into the room
  std::vector<double> heater_w;       ///< zone; a heater that switches by itself, between two hours
  double heater_period_min = 70, heater_on_min = 25;
  double heater_start_h = 20.5, heater_stop_h = 5.25;

  // Air handling
  std::vector<double> vav_flow_m3_s;         ///< VAV; damper open
  std::vector<double> vav_damper;            ///< VAV; 0..1
  std::vector<double> vav_flow_calibration;  ///< VAV; true over nominal flow
  std::vector<double> vav_stuck_damper;      ///< VAV; -1 free, else the opening it is stuck at
  double vav_modulation_per_k = 0;           ///< opening added a K above 25.25; 0: fixed dampers
  double vav_off_leak = 0.0;                 ///< share of flow that still passes a closed box
  double vav_off_per_day = 0.12;             ///< events a VAV and day
  double vav_off_min_minutes = 30, vav_off_max_minutes = 90;
  double supply_lag_s = 200;          ///< first order, towards the setpoint
  double supply_sensor_offset_k = 0;  ///< reading minus truth: the room gets setpoint - offset
  double duct_gain_k = 0.3;
  double duct_lag_s = 0;  ///< sheet metal: the boxes get the AHU's outlet so much later
  double duct_leak_share = 0.02;
  double coil_capacity_kw = 12;                        ///< total cooling
  double coil_fouling = 0;                             ///< share of capacity lost
  double coil_latent_w_per_gkg_m3s = 1500;             ///< latent load: a g/kg of moisture removed and m3/s
  double chilled_water_degc = 7, coil_approach_k = 4;  ///< supply is never below their sum
  double chilled_water_offset_k = 0;                   ///< warmer by this always; fan coils feel it too
  double chilled_water_drift_k_k = 0;                  ///< warmer a K of outdoors above 26 degC; fan coils feel it too
  double ahu_stop_from_h = 0, ahu_stop_to_h = 0;       ///< the AHU rests between these hours; equal: never
  double outdoor_air_m3_s = 0.36;
  double mau_room_share = 0.35;  ///< of the outdoor air that goes straight to the zones
  double mau_setpoint_degc = 18;
  double mau_noise_sd_k = 0.35;  ///< slow drift of the outlet about its setpoint
  double mau_capacity_kw = 22;
  std::vector<double> fcu_flow_m3_s;          ///< FCU
  std::vector<double> fcu_capacity_factor;    ///< FCU; 1 healthy
  std::vector<double> fcu_forced;             ///< FCU; 0 as recorded, 1 runs whatever is recorded, -1 never runs
  std::vector<double> fcu_setpoint_offset_k;  ///< FCU; its user's dial
  double fcu_supply_degc = 14;
  double fcu_coil_lag_s = 0;  ///< a fan coil cools so much later than it runs
  double fcu_setpoint_degc = 26, fcu_band_k = 0.5;
  double fcu_start_h = 7, fcu_stop_h = 20;

  // Power
  double ahu_fan_kw = 1.6;      ///< at nominal damper openings; grows with flow^2
  double fan_heat_share = 0.9;  ///< of fan power that warms the air
  double mau_fan_kw = 0.25;
  double fcu_fan_kw = 0.06;  ///< each
  double pump_kw = 0.5;
  double chiller_cop = 3.4;  ///< at 30 degC outdoors
  double chiller_cop_per_k = -0.05;
  double chiller_min_load_kw = 3;
  double chiller_part_load_loss = 0;  ///< at no load it takes so much more power a kW than at full load, share
  double chiller_full_load_kw = 40;

  // Sensors, clock, site
  std::vector<double> room_sensor_bias_k;           ///< VAV
  std::vector<double> room_sensor_drift_k_per_day;  ///< VAV
  std::vector<double> room_sensor_jet_share;        ///< VAV; share of supply air that the sensor feels
  std::vector<double> room_sensor_zone;             ///< VAV; 1-based VAV whose room is shown (its own)
  std::vector<double> fcu_sensor_bias_k;            ///< FCU
  double room_sensor_lag_s = 60;
  double temp_noise_sd_k = 0.02;
  double power_noise_share = 0.01;
  double clock_shift_s = 0;  ///< the building management's clock runs ahead by this
  double outdoor_sensor_bias_k = 0;
  double site_temp_offset_k = 0;  ///< true site minus weather file
  double site_solar_factor = 1;
};

/// The digital twin with other counts: neighbours in two rows, façade south, ends also west and east.
/// Without FCU zones the VAV zones have the windows.
/// Errors: hal::InputError unless 1 <= vavs <= 64, 0 <= fcus <= 64, 0 <= powers <= 8.
RcRoom make_room(int vavs = 5, int fcus = 5, int powers = 2);

/// How a field is stored and how often it repeats.
using ScalarField = double RcRoom::*;
using ListField = std::vector<double> RcRoom::*;
enum class Repeats { once, zone, vav, fcu };

/// One parameter: name with unit, permitted range.
struct RoomField {
  std::string_view name;
  double lowest, highest;
  std::variant<ScalarField, ListField> member;
  Repeats repeats;
};

/// All parameters, in the order of the struct.
std::span<const RoomField> room_fields();
/// Field by name, nullptr if there is none.
const RoomField* find_room_field(std::string_view name);

/// Throws hal::InputError naming `place` and the field if a value is out of range, not finite or of wrong count.
void check_room(const RcRoom& room, const std::string& place);

/// How far perturbed_room goes: each change has a size drawn from half the figure up to the figure, and a random sign
/// (docs/method.md 8: 10 to 20 %). The defaults keep the mean zone error between 0.4 and 1.6 K (docs/method.md, open
/// point 24).
struct Perturbation {
  double relative = 0.20;       ///< capacities, gains, envelope, mixing, solar, fan coils
  double zone_relative = 0.12;  ///< flow and gain of one zone against the others
  double flow_relative = 0.20;  ///< of all VAVs together
  double sensor_bias_k = 0.15;
  double supply_offset_k = 0.5;
  double neighbour_k = 1.0;
  double site_temp_k = 1.0;
  double fcu_dial_k = 1.2;  ///< what the users of the fan coils chose
};

/// A room of the same kind that differs as two rooms of one building do; named "<base>-p<seed>".
RcRoom perturbed_room(const RcRoom& base, std::uint64_t seed, const Perturbation& by = {});

/// The room that stands for the real one beside its twin: perturbed, heat split otherwise between air and mass, leaks
/// that follow the wind, sensors in the stream; `feedback`: boxes that modulate.
RcRoom measured_room(const RcRoom& twin, std::uint64_t seed, bool feedback);
RcRoom measured_room(const RcRoom& twin, std::uint64_t seed, bool feedback, const Perturbation& by);

/// The room with physics that a twin cannot have by any parameters: a slab behind the mass of each zone, cladding,
/// sheet metal and fan coils with inertia, heat that rises into the return air, people who stay away for days, a
/// chiller that is worse at part load.
RcRoom with_other_structure(RcRoom room, std::uint64_t seed);

/// Rooms number 0.. of two sets that never share a room: one for tuning, one for studies.
std::vector<RcRoom> tuning_rooms(const RcRoom& base, int count = 8);
std::vector<RcRoom> study_rooms(const RcRoom& base, int count = 12);

}  // namespace airside::sim
