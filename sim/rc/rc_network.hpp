#pragma once
// What is constant over a run of an RC room: the network of its nodes, and how large its inner steps are.

#include <array>
#include <cstddef>
#include <vector>

#include "sim/rc/disturbance.hpp"
#include "sim/rc/rc_room.hpp"

namespace airside::sim {

/// Conductances in W/K, heat capacities in J/K.
struct RcNetwork {
  static constexpr double air_j_m3k = 1.2 * 1006;  ///< heat capacity of a cubic metre of air

  struct Link {
    std::size_t a, b;
    double w_k;
  };
  struct Zone {
    double air_j_k, mass_j_k, wall_j_k;
    double air_k_w, mass_k_w, wall_k_w, deep_k_w;  // an inner step's rise per W
    double mass_w_k, wall_w_k, window_w_k, neighbour_w_k, mau_w_k;
    double infiltration_w_k_ach;  // per air change an hour
    double door_w_k_ach;          // the same of an open door
    double deep_j_k, deep_w_k;
    std::array<double, facades> window_m2_shgc;  // times irradiance: W into the zone
    std::array<double, facades> wall_m2_share;   // façade that the opaque wall faces, sum 1 or 0
    double wall_sun_k_m2_w;                      // sol-air rise per irradiance
  };
  std::vector<Zone> zones;
  std::vector<Link> links;
  int inner_steps = 3;
  double supply_share = 1;  // of the way to its target that the supply temperature goes in an inner step
  double sensor_share = 1, duct_share = 1, wall_sun_share = 1, fcu_coil_share = 1;
  double dt_s = 60;

  /// Errors: hal::InputError where a zone is too fast for steps of a second.
  explicit RcNetwork(const RcRoom& room);

 private:
  void add_links(const RcRoom& room);
};

}  // namespace airside::sim
