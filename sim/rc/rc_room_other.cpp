#include "sim/rc/rc_room.hpp"
#include "sim/stateless_draw.hpp"

namespace airside::sim {

namespace {

enum StructureDraw : std::uint64_t { draw_structure = 710, draw_other_structure = 713 };

}  // namespace

RcRoom measured_room(const RcRoom& twin, std::uint64_t seed, bool feedback) {
  Perturbation by;
  by.site_temp_k = 0.5;
  return measured_room(twin, seed, feedback, by);
}

RcRoom measured_room(const RcRoom& twin, std::uint64_t seed, bool feedback, const Perturbation& by) {
  RcRoom room = perturbed_room(twin, seed, by);
  auto uniform = [seed, n = 0](double low, double high) mutable {
    return low + (high - low) * draw_uniform(seed, draw_structure, static_cast<std::uint64_t>(n++), 0);
  };
  // Other splits of heat between air and mass, leaks that follow the wind, sensors in the stream, boxes that modulate.
  room.solar_to_mass_share = uniform(0.40, 0.70);
  room.gain_radiant_share = uniform(0.2, 0.5);
  room.infiltration_wind_ach_s_m *= uniform(0.5, 1.6);
  room.infiltration_stack_ach_k *= uniform(0.5, 1.6);
  room.wall_absorptance = uniform(0.4, 0.65);
  room.room_sensor_lag_s = uniform(30, 240);
  for (double& share : room.room_sensor_jet_share) share += uniform(0, 0.02);
  for (double& area : room.infiltration_share) area *= uniform(0.7, 1.3);
  for (double& kj : room.mass_kj_k) kj *= uniform(0.8, 1.25);
  room.occupancy_ramp_h *= uniform(0.7, 1.3);
  room.occupancy_lunch_dip *= uniform(0.5, 1.5);
  room.chiller_cop *= uniform(0.92, 1.08);
  room.ahu_fan_kw *= uniform(0.92, 1.08);
  room.duct_gain_k *= uniform(0.6, 1.5);
  if (feedback) room.vav_modulation_per_k = uniform(0.02, 0.06);
  return room;
}

RcRoom with_other_structure(RcRoom room, std::uint64_t seed) {
  auto uniform = [seed, n = 0](double low, double high) mutable {
    return low + (high - low) * draw_uniform(seed, draw_other_structure, static_cast<std::uint64_t>(n++), 0);
  };
  for (std::size_t z = 0; z < room.floor_area_m2.size(); ++z) {
    room.deep_kj_k[z] = room.floor_area_m2[z] * uniform(60, 160);
    room.deep_ua_w_k[z] = room.floor_area_m2[z] * uniform(0.3, 0.9);
  }
  room.wall_sun_lag_s = uniform(1800, 7200);
  room.duct_lag_s = uniform(60, 300);
  room.fcu_coil_lag_s = uniform(120, 400);
  room.plenum_gain_share = uniform(0.05, 0.2);
  room.occupancy_absent_share = uniform(0.02, 0.10);
  room.chiller_part_load_loss = uniform(0.1, 0.35);
  return room;
}

}  // namespace airside::sim
