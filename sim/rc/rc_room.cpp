#include "sim/rc/rc_room.hpp"

#include <algorithm>

#include "hal/text/input_error.hpp"
#include "sim/stateless_draw.hpp"

namespace airside::sim {
namespace {

using List = std::vector<double>;

// Value for each VAV zone, then for each FCU zone.
List by_zone(int vavs, int fcus, double interior, double perimeter) {
  List list(static_cast<std::size_t>(vavs), interior);
  list.insert(list.end(), static_cast<std::size_t>(fcus), perimeter);
  return list;
}

List repeated(int count, double value) { return List(static_cast<std::size_t>(count), value); }

}  // namespace

RcRoom make_room(int vavs, int fcus, int powers) {
  if (vavs < 1 || vavs > 64 || fcus < 0 || fcus > 64 || powers < 0 || powers > 8) {
    throw hal::InputError(
        "room",
        std::to_string(vavs) + " VAVs, " + std::to_string(fcus) + " FCUs, " + std::to_string(powers) + " power meters",
        "1 to 64 VAVs, 0 to 64 FCUs, 0 to 8 power meters", "choose other counts");
  }
  RcRoom room;
  room.vavs = vavs;
  room.fcus = fcus;
  room.powers = powers;
  const bool open_interior = fcus == 0;  // then the VAV zones reach the façade
  room.floor_area_m2 = by_zone(vavs, fcus, 60, 30);
  room.volume_m3 = by_zone(vavs, fcus, 180, 90);
  room.air_capacity_factor = by_zone(vavs, fcus, 1.28, 7);
  room.mass_kj_k = by_zone(vavs, fcus, 1400, 1400);
  room.mass_ua_w_k = by_zone(vavs, fcus, 130, 90);
  room.wall_kj_k = by_zone(vavs, fcus, open_interior ? 600 : 1, 600);
  room.wall_ua_w_k = by_zone(vavs, fcus, open_interior ? 8 : 0, 8);
  room.wall_area_m2 = by_zone(vavs, fcus, open_interior ? 9 : 0, 9);
  room.window_north_m2 = by_zone(vavs, fcus, 0, 0);
  room.window_east_m2 = by_zone(vavs, fcus, 0, 0);
  room.window_south_m2 = by_zone(vavs, fcus, open_interior ? 2.5 : 0, 9);
  room.window_west_m2 = by_zone(vavs, fcus, 0, 0);
  room.infiltration_share = by_zone(vavs, fcus, open_interior ? 0.3 : 0.1, 1.0);
  room.neighbour_ua_w_k = by_zone(vavs, fcus, 10, 5);
  room.deep_kj_k = by_zone(vavs, fcus, 1, 1);
  room.deep_ua_w_k = by_zone(vavs, fcus, 0, 0);
  room.door_ach = by_zone(vavs, fcus, 0, 0);
  room.heater_w = by_zone(vavs, fcus, 0, 0);
  const std::size_t west_end = open_interior ? 0 : static_cast<std::size_t>(vavs);
  const std::size_t east_end = static_cast<std::size_t>(room.zones()) - 1;
  room.window_west_m2[west_end] = open_interior ? 1.5 : 5;
  room.window_east_m2[east_end] = open_interior ? 1.5 : 5;

  // Rooms differ: one actuator, several rooms, a spread of some tenths of a kelvin (as in the EnergyPlus twin).
  constexpr double dampers[] = {0.52, 0.58, 0.55, 0.60, 0.54};
  constexpr double gains[] = {0.95, 1.05, 1.0, 1.08, 0.95};
  room.gain_factor = by_zone(vavs, fcus, 1, 0.8);
  room.vav_flow_m3_s = repeated(vavs, 0.76);
  room.vav_damper = repeated(vavs, 0);
  room.room_sensor_zone = repeated(vavs, 0);
  for (std::size_t v = 0; v < static_cast<std::size_t>(vavs); ++v) {
    room.vav_damper[v] = dampers[v % 5];
    room.gain_factor[v] = gains[v % 5];
    room.room_sensor_zone[v] = static_cast<double>(v + 1);
  }
  room.vav_flow_calibration = repeated(vavs, 1);
  room.vav_stuck_damper = repeated(vavs, -1);
  room.fcu_flow_m3_s = repeated(fcus, 0.10);
  if (fcus > 0) room.fcu_flow_m3_s.front() = room.fcu_flow_m3_s.back() = 0.15;
  room.fcu_capacity_factor = repeated(fcus, 1);
  room.fcu_forced = repeated(fcus, 0);
  room.fcu_setpoint_offset_k = repeated(fcus, 0);
  room.room_sensor_bias_k = repeated(vavs, 0);
  room.room_sensor_drift_k_per_day = repeated(vavs, 0);
  room.room_sensor_jet_share = repeated(vavs, 0);
  room.fcu_sensor_bias_k = repeated(fcus, 0);

  // Plant sizes follow the count of boxes and coils; 1 for the default room.
  const double air = vavs / 5.0;
  const double all = room.zones() / 10.0;
  room.coil_capacity_kw *= air;
  room.ahu_fan_kw *= air;
  room.outdoor_air_m3_s *= all;
  room.mau_capacity_kw *= all;
  room.mau_fan_kw *= all;
  room.pump_kw *= all;
  room.chiller_min_load_kw *= all;
  if (vavs != 5 || fcus != 5 || powers != 2) {
    room.name = "rc-" + std::to_string(vavs) + "-" + std::to_string(fcus) + "-" + std::to_string(powers);
  }
  return room;
}

RcRoom perturbed_room(const RcRoom& base, std::uint64_t seed, const Perturbation& by) {
  RcRoom room = base;
  room.name = base.name + "-p" + std::to_string(seed);
  room.seed = draw_bits(seed, 90, 0, 0);
  std::uint64_t number = 0;
  const auto symmetric = [&] {
    const double draw = draw_uniform(seed, 91, number++, 0);
    return draw < 0.5 ? -0.5 - draw : draw;  // size 0.5 to 1, either sign
  };
  const auto scale = [&](double& value, double width) { value *= 1 + width * symmetric(); };
  const auto scale_each = [&](List& list, double width) {
    for (double& value : list) scale(value, width);
  };
  const auto shift_each = [&](List& list, double width) {
    for (double& value : list) value += width * symmetric();
  };

  scale(room.capacity_factor, by.relative);
  scale(room.envelope_factor, by.relative);
  scale_each(room.mass_ua_w_k, by.relative);
  scale(room.infiltration_ach, by.relative);
  for (double* facade :
       {&room.solar_factor_north, &room.solar_factor_east, &room.solar_factor_south, &room.solar_factor_west}) {
    scale(*facade, by.relative);
  }
  for (double* mixing : {&room.mixing_interior_m3_s, &room.mixing_perimeter_m3_s, &room.mixing_across_m3_s}) {
    scale(*mixing, by.relative);
  }
  scale(room.gain_base_w_m2, by.relative);
  scale(room.gain_occupied_w_m2, by.relative);
  scale_each(room.gain_factor, by.zone_relative);
  double all_flow = 1;
  scale(all_flow, by.flow_relative);
  for (double& calibration : room.vav_flow_calibration) calibration *= all_flow;
  scale_each(room.vav_flow_calibration, by.zone_relative);
  scale(room.supply_lag_s, by.relative);
  scale_each(room.fcu_capacity_factor, by.relative);
  room.supply_sensor_offset_k += by.supply_offset_k * symmetric();
  room.neighbour_temp_degc += by.neighbour_k * symmetric();
  room.site_temp_offset_k += by.site_temp_k * symmetric();
  scale(room.site_solar_factor, by.relative / 2);
  room.mau_setpoint_degc += 0.5 * symmetric();
  room.occupancy_shift_h += 0.5 * symmetric();
  shift_each(room.room_sensor_bias_k, by.sensor_bias_k);
  shift_each(room.fcu_sensor_bias_k, by.sensor_bias_k);
  shift_each(room.fcu_setpoint_offset_k, by.fcu_dial_k);
  return room;
}

namespace {
std::vector<RcRoom> rooms_from(const RcRoom& base, std::uint64_t first_seed, int count) {
  std::vector<RcRoom> rooms;
  rooms.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) rooms.push_back(perturbed_room(base, first_seed + static_cast<std::uint64_t>(i)));
  return rooms;
}
}  // namespace

std::vector<RcRoom> tuning_rooms(const RcRoom& base, int count) { return rooms_from(base, 500000, count); }
std::vector<RcRoom> study_rooms(const RcRoom& base, int count) { return rooms_from(base, 1000, count); }

}  // namespace airside::sim
