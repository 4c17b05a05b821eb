#include "sim/rc/disturbance.hpp"

#include <algorithm>
#include <cmath>

#include "sim/stateless_draw.hpp"

namespace airside::sim {
namespace {

enum DisturbanceStream : std::uint64_t {
  occupancy_of_day = 31,
  arrival_of_day,
  occupancy_of_zone,
  occupancy_flicker,
  event_happens,
  event_start,
  event_length,
  mau_wander,
  zone_absent,
  door_open,
  door_start,
  door_length,
};
constexpr int event_slots = 8;  // chances a day for a VAV to be switched off

double wrapped_hour(double hour) { return hour - 24 * std::floor(hour / 24); }

// 0 to 1 over `width` about `edge`.
double ramp(double hour, double edge, double width) { return std::clamp((hour - edge) / width, 0.0, 1.0); }

// Gain of zone z for a given presence, W.
double zone_gain_w(const RcRoom& room, std::size_t z, double presence, double hour, bool weekend) {
  double w_m2 = room.gain_base_w_m2 + room.gain_occupied_w_m2 * presence;
  if (hour >= 19 && hour < 22) w_m2 += room.gain_after_hours_w_m2;
  if (hour >= 12 && hour < 13) w_m2 += room.gain_lunch_w_m2;
  if (weekend && hour >= room.occupancy_start_h && hour < room.occupancy_end_h) w_m2 += room.gain_weekend_w_m2;
  return w_m2 * room.floor_area_m2[z] * room.gain_factor[z];
}

/// Whether `hour` lies between the two, over midnight if the first is the later; never if they are equal.
bool between_hours(double hour, double from, double to) {
  return from <= to ? hour >= from && hour < to : hour >= from || hour < to;
}

/// A heater's own clock neither knows nor keeps the day: its period is counted through.
bool heater_on(const RcRoom& room, CivilTime t, double hour) {
  if (!between_hours(hour, room.heater_start_h, room.heater_stop_h)) return false;
  const double minutes = static_cast<double>(t.seconds) / 60;
  return minutes - room.heater_period_min * std::floor(minutes / room.heater_period_min) < room.heater_on_min;
}

/// On some days a door stands open for 2 to 6 h of the day.
bool door_open_at(const RcRoom& room, std::uint64_t seed, std::size_t zone, CivilTime t, double hour) {
  if (draw_uniform(seed, door_open, zone, t.day()) >= room.door_days_share) return false;
  const double from = 8 + 5 * draw_uniform(seed, door_start, zone, t.day());
  return hour >= from && hour < from + 2 + 4 * draw_uniform(seed, door_length, zone, t.day());
}

double hour_of(CivilTime t) { return t.second_of_day() / 3600.0; }
bool weekend_at(CivilTime t) { return t.weekday() >= 5; }

void set_facades(const RcRoom& room, const SunDirection& sun, Disturbance& out) {
  out.facade_w_m2 = facade_irradiance_w_m2(out.weather, sun);
  const double factor[] = {room.solar_factor_north, room.solar_factor_east, room.solar_factor_south,
                           room.solar_factor_west};
  for (std::size_t f = 0; f < facades; ++f) out.facade_w_m2[f] *= factor[f] * room.site_solar_factor;
}

}  // namespace

double occupancy_profile(const RcRoom& room, double hour, bool weekend) {
  const double h = wrapped_hour(hour - room.occupancy_shift_h);
  const double arriving = ramp(h, room.occupancy_start_h, room.occupancy_ramp_h);
  const double leaving = ramp(h, room.occupancy_end_h - room.occupancy_ramp_h, room.occupancy_ramp_h);
  const double lunch = ramp(h, 11.75, 0.5) - ramp(h, 12.75, 0.5);
  const double present = std::max(0.0, arriving - leaving) * (1 - room.occupancy_lunch_dip * lunch);
  return present * (weekend ? room.occupancy_weekend_factor : 1.0);
}

bool vav_off_event(const RcRoom& room, std::uint64_t seed, int vav, CivilTime t) {
  if (room.vav_off_per_day <= 0) return false;
  const double chance = room.vav_off_per_day / event_slots;
  const double minute = t.second_of_day() / 60.0;
  for (std::int64_t back = 0; back < 2; ++back) {  // an event of yesterday evening may reach into today
    const std::int64_t day = t.day() - back;
    for (int slot = 0; slot < event_slots; ++slot) {
      const std::int64_t address = day * event_slots + slot;
      const auto place = static_cast<std::uint64_t>(vav);
      if (draw_uniform(seed, event_happens, place, address) >= chance) continue;
      const double start = 1440 * draw_uniform(seed, event_start, place, address);
      const double length = room.vav_off_min_minutes + (room.vav_off_max_minutes - room.vav_off_min_minutes) *
                                                           draw_uniform(seed, event_length, place, address);
      const double since = minute + 1440 * static_cast<double>(back) - start;
      if (since >= 0 && since < length) return true;
    }
  }
  return false;
}

void disturb(const RcRoom& room, const Weather& weather, std::uint64_t seed, CivilTime t, Disturbance& out) {
  const Sky sky = weather.sky_at(t);
  out.weather = sky.weather;
  out.weather.outdoor_temp_degc += room.site_temp_offset_k;
  out.humidity_kg_kg = sky.humidity_kg_kg;
  set_facades(room, sky.sun, out);

  const bool weekend = weekend_at(t);
  const double hour = hour_of(t);
  const auto now_s = static_cast<double>(t.seconds);
  const double late_h = room.arrival_sd_min / 60 * draw_normal(seed, arrival_of_day, 0, t.day());
  const double crowd = 1 + room.occupancy_day_sd * draw_normal(seed, occupancy_of_day, 0, t.day());
  const double profile = occupancy_profile(room, hour - late_h, weekend);
  const auto zones = static_cast<std::size_t>(room.zones());
  const bool whims = room.occupancy_zone_sd != 0 || room.occupancy_noise_sd != 0;
  out.gain_w.resize(zones);
  for (std::size_t z = 0; z < zones; ++z) {
    double presence = 0;
    if (profile > 0) {
      const double whim = whims ? room.occupancy_zone_sd * draw_course(seed, occupancy_of_zone, z, now_s, 10800) +
                                      room.occupancy_noise_sd * draw_course(seed, occupancy_flicker, z, now_s, 1500)
                                : 0.0;
      presence = std::max(0.0, profile * crowd * (1 + whim));
    }
    if (room.occupancy_absent_share > 0 && draw_uniform(seed, zone_absent, z, t.day()) < room.occupancy_absent_share) {
      presence *= 0.15;
    }
    out.gain_w[z] = zone_gain_w(room, z, presence, hour, weekend);
    if (room.heater_w[z] > 0 && heater_on(room, t, hour)) out.gain_w[z] += room.heater_w[z];
  }
  out.door_ach.clear();
  if (std::any_of(room.door_ach.begin(), room.door_ach.end(), [](double ach) { return ach > 0; })) {
    for (std::size_t z = 0; z < zones; ++z) {
      out.door_ach.push_back(room.door_ach[z] > 0 && door_open_at(room, seed, z, t, hour) ? room.door_ach[z] : 0);
    }
  }

  const auto vavs = static_cast<std::size_t>(room.vavs);
  out.vav_on.resize(vavs);
  for (std::size_t v = 0; v < vavs; ++v) {
    out.vav_on[v] = vav_off_event(room, seed, static_cast<int>(v), t) ? 0.0 : 1.0;
  }
  out.mau_setpoint_degc = room.mau_setpoint_degc;
  if (room.mau_noise_sd_k != 0)
    out.mau_setpoint_degc += room.mau_noise_sd_k * draw_course(seed, mau_wander, 0, now_s, 2700);
}

void expect(const RcRoom& room, const Location& location, const Disturbance& last, CivilTime last_time, CivilTime t,
            Disturbance& out) {
  out = last;
  const SunDirection then = sun_at(location, last_time);
  const SunDirection now = sun_at(location, t);
  if (now.up <= 0) {
    out.weather.direct_normal_w_m2 = out.weather.diffuse_horizontal_w_m2 = out.weather.global_horizontal_w_m2 = 0;
  } else if (then.up > 0.05) {
    out.weather.diffuse_horizontal_w_m2 *= now.up / then.up;
    out.weather.global_horizontal_w_m2 *= now.up / then.up;
  }
  set_facades(room, now, out);
  const double profile_then = occupancy_profile(room, hour_of(last_time), weekend_at(last_time));
  const double profile_now = occupancy_profile(room, hour_of(t), weekend_at(t));
  for (std::size_t z = 0; z < out.gain_w.size(); ++z) {
    out.gain_w[z] += zone_gain_w(room, z, profile_now, hour_of(t), weekend_at(t)) -
                     zone_gain_w(room, z, profile_then, hour_of(last_time), weekend_at(last_time));
  }
}

}  // namespace airside::sim
