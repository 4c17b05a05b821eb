#pragma once
// What acts on a room besides its air handling: weather on its façades, people, boxes that are switched off, the
// make-up air unit's wandering. A pure function of (room, weather, seed, time), so the future can be looked at.

#include <array>
#include <cstdint>
#include <vector>

#include "sim/rc/rc_room.hpp"
#include "sim/weather/weather.hpp"

namespace airside::sim {

/// Everything exogenous during one 3-min step.
struct Disturbance {
  WeatherRecord weather;                      ///< at the room's true site
  std::array<double, facades> facade_w_m2{};  ///< irradiance, order of Facade, site factor included
  double humidity_kg_kg = 0;                  ///< outdoors
  std::vector<double> gain_w;                 ///< zone; people, light, equipment
  std::vector<double> vav_on;                 ///< VAV; 0/1
  std::vector<double> door_ach;               ///< zone; through open doors; empty: the room has none
  double mau_setpoint_degc = 18;
};

/// Share of people present by the profile alone: ramps up from start, dips at lunch, ramps down to end.  0..1.
/// `hour` is the hour of the day and may leave 0..24, it wraps.
double occupancy_profile(const RcRoom& room, double hour, bool weekend);

/// The seed of a room's people and noise: that of the run mixed with the room's own. Its own inverse: of what it gave,
/// it gives the run's seed back.
constexpr std::uint64_t seed_in_room(const RcRoom& room, std::uint64_t seed) {
  return seed ^ (room.seed * 0x9E3779B97F4A7C15u);
}

/// The true disturbance of the step that starts at t, `seed` as seed_in_room().  Cost: about 1 us.
void disturb(const RcRoom& room, const Weather& weather, std::uint64_t seed, CivilTime t, Disturbance& out);

/// What a forecaster with the mean daily profile expects at t, who saw `last` at `last_time`: people deviate from
/// the profile as they do now, sky and temperature stay, the sun moves, boxes stay as they are.
void expect(const RcRoom& room, const Location& location, const Disturbance& last, CivilTime last_time, CivilTime t,
            Disturbance& out);

/// Whether VAV `vav` is switched off by an event at t.
bool vav_off_event(const RcRoom& room, std::uint64_t seed, int vav, CivilTime t);

}  // namespace airside::sim
