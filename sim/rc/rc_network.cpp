#include "sim/rc/rc_network.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <string>

#include "hal/text/input_error.hpp"
#include "sim/rc/rc_plant.hpp"

namespace airside::sim {

void RcNetwork::add_links(const RcRoom& room) {
  const auto link = [&](int a, int b, double flow_m3_s) {
    if (flow_m3_s > 0)
      links.push_back({static_cast<std::size_t>(a), static_cast<std::size_t>(b), flow_m3_s * air_j_m3k});
  };
  for (int v = 0; v + 1 < room.vavs; ++v) link(v, v + 1, room.mixing_interior_m3_s);
  for (int f = 0; f + 1 < room.fcus; ++f) link(room.vavs + f, room.vavs + f + 1, room.mixing_perimeter_m3_s);
  // The longer row decides how many openings there are between the two rows.
  for (int i = 0; i < std::max(room.vavs, room.fcus) && room.fcus > 0; ++i) {
    const int rows = std::max(room.vavs, room.fcus);
    link(i * room.vavs / rows, room.vavs + i * room.fcus / rows, room.mixing_across_m3_s);
  }
}

RcNetwork::RcNetwork(const RcRoom& room) {
  const auto n = static_cast<std::size_t>(room.zones());
  zones.resize(n);
  for (std::size_t z = 0; z < n; ++z) {
    Zone& zone = zones[z];
    const double air = room.volume_m3[z] * air_j_m3k;
    zone.air_j_k = air * room.air_capacity_factor[z] * room.capacity_factor;
    zone.mass_j_k = 1000 * room.mass_kj_k[z] * room.capacity_factor;
    zone.wall_j_k = 1000 * room.wall_kj_k[z] * room.capacity_factor;
    zone.mass_w_k = room.mass_ua_w_k[z];
    zone.wall_w_k = 2 * room.wall_ua_w_k[z] * room.envelope_factor;
    const std::array<double, facades> glass = {room.window_north_m2[z], room.window_east_m2[z], room.window_south_m2[z],
                                               room.window_west_m2[z]};
    const double glass_sum = std::accumulate(glass.begin(), glass.end(), 0.0);
    zone.window_w_k = room.window_u_w_m2k * room.envelope_factor * glass_sum;
    for (std::size_t f = 0; f < facades; ++f) {
      zone.window_m2_shgc[f] = glass[f] * room.shgc;
      zone.wall_m2_share[f] = glass_sum > 0 ? glass[f] / glass_sum : 0.25;
    }
    zone.wall_sun_k_m2_w = room.wall_area_m2[z] > 0 ? room.wall_absorptance / room.wall_film_w_m2k : 0;
    zone.neighbour_w_k = room.neighbour_ua_w_k[z];
    zone.mau_w_k = room.outdoor_air_m3_s * room.mau_room_share * air_j_m3k / static_cast<double>(n);
    zone.infiltration_w_k_ach = air / 3600 * room.infiltration_share[z];
    zone.door_w_k_ach = air / 3600;
    zone.deep_j_k = 1000 * room.deep_kj_k[z] * room.capacity_factor;
    zone.deep_w_k = room.deep_ua_w_k[z];
  }
  add_links(room);

  // Explicit steps are stable and free of overshoot while dt * sum(G) / C < 1; stay below a half.
  double fastest_per_s = 0;
  for (std::size_t z = 0; z < n; ++z) {
    const Zone& zone = zones[z];
    const double gusty_ach =
        room.infiltration_ach + room.infiltration_wind_ach_s_m * 30 + room.infiltration_stack_ach_k * 40;
    double w_k = zone.mass_w_k + zone.wall_w_k + zone.window_w_k + zone.neighbour_w_k + zone.mau_w_k +
                 zone.infiltration_w_k_ach * gusty_ach + zone.door_w_k_ach * room.door_ach[z];
    for (const Link& link : links) w_k += link.a == z || link.b == z ? link.w_k : 0;
    if (z < static_cast<std::size_t>(room.vavs))
      w_k += room.vav_flow_m3_s[z] * room.vav_flow_calibration[z] * air_j_m3k;
    else {
      const std::size_t f = z - static_cast<std::size_t>(room.vavs);
      w_k += room.fcu_flow_m3_s[f] * room.fcu_capacity_factor[f] * air_j_m3k;
    }
    fastest_per_s = std::max({fastest_per_s, w_k / zone.air_j_k, (zone.mass_w_k + zone.deep_w_k) / zone.mass_j_k,
                              2 * zone.wall_w_k / zone.wall_j_k, zone.deep_w_k / zone.deep_j_k});
  }
  inner_steps = std::max(3, static_cast<int>(std::ceil(RcPlant::step_s * fastest_per_s / 0.5)));
  if (inner_steps > RcPlant::step_s) {
    throw hal::InputError("room " + room.name,
                          "a zone that follows its surroundings within " + std::to_string(1 / fastest_per_s) + " s",
                          "2 s or more", "raise its heat capacity or lower its flows");
  }
  dt_s = static_cast<double>(RcPlant::step_s) / inner_steps;
  for (Zone& zone : zones) {
    zone.air_k_w = dt_s / zone.air_j_k;
    zone.mass_k_w = dt_s / zone.mass_j_k;
    zone.wall_k_w = dt_s / zone.wall_j_k;
    zone.deep_k_w = dt_s / zone.deep_j_k;
  }
  supply_share = 1 - std::exp(-dt_s / room.supply_lag_s);
  const auto share_of = [this](double lag_s) { return lag_s > 0 ? 1 - std::exp(-dt_s / lag_s) : 1; };
  sensor_share = share_of(room.room_sensor_lag_s);
  duct_share = share_of(room.duct_lag_s);
  wall_sun_share = share_of(room.wall_sun_lag_s);
  fcu_coil_share = share_of(room.fcu_coil_lag_s);
}

}  // namespace airside::sim
