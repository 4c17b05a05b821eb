#include <algorithm>
#include <array>
#include <cmath>

#include "hal/text/input_error.hpp"
#include "sim/rc/rc_room.hpp"

namespace airside::sim {
namespace {

constexpr RoomField once(std::string_view name, double lowest, double highest, ScalarField member) {
  return {name, lowest, highest, member, Repeats::once};
}
constexpr RoomField each(std::string_view name, double lowest, double highest, ListField member, Repeats repeats) {
  return {name, lowest, highest, member, repeats};
}

#define AIRSIDE_ONCE(field, lowest, highest) once(#field, lowest, highest, &RcRoom::field)
#define AIRSIDE_EACH(what, field, lowest, highest) each(#field, lowest, highest, &RcRoom::field, Repeats::what)

// The macros keep a field's name in files equal to its name in code.
constexpr std::array fields = {
    AIRSIDE_EACH(zone, floor_area_m2, 1, 10000),
    AIRSIDE_EACH(zone, volume_m3, 3, 100000),
    AIRSIDE_EACH(zone, air_capacity_factor, 1, 50),
    AIRSIDE_EACH(zone, mass_kj_k, 1, 1e+06),
    AIRSIDE_EACH(zone, mass_ua_w_k, 0, 10000),
    AIRSIDE_EACH(zone, wall_kj_k, 1, 1e+06),
    AIRSIDE_EACH(zone, wall_ua_w_k, 0, 10000),
    AIRSIDE_EACH(zone, wall_area_m2, 0, 10000),
    AIRSIDE_EACH(zone, window_north_m2, 0, 10000),
    AIRSIDE_EACH(zone, window_east_m2, 0, 10000),
    AIRSIDE_EACH(zone, window_south_m2, 0, 10000),
    AIRSIDE_EACH(zone, window_west_m2, 0, 10000),
    AIRSIDE_EACH(zone, infiltration_share, 0, 5),
    AIRSIDE_EACH(zone, neighbour_ua_w_k, 0, 10000),
    AIRSIDE_EACH(zone, deep_kj_k, 1, 1e+07),
    AIRSIDE_EACH(zone, deep_ua_w_k, 0, 10000),
    AIRSIDE_ONCE(capacity_factor, 0.1, 10),
    AIRSIDE_ONCE(envelope_factor, 0, 10),
    AIRSIDE_ONCE(window_u_w_m2k, 0.1, 7),
    AIRSIDE_ONCE(shgc, 0, 1),
    AIRSIDE_ONCE(solar_factor_north, 0, 5),
    AIRSIDE_ONCE(solar_factor_east, 0, 5),
    AIRSIDE_ONCE(solar_factor_south, 0, 5),
    AIRSIDE_ONCE(solar_factor_west, 0, 5),
    AIRSIDE_ONCE(solar_to_mass_share, 0, 1),
    AIRSIDE_ONCE(wall_absorptance, 0, 1),
    AIRSIDE_ONCE(wall_film_w_m2k, 1, 100),
    AIRSIDE_ONCE(wall_sun_lag_s, 0, 36000),
    AIRSIDE_ONCE(rain_wall_drop_k, 0, 15),
    AIRSIDE_ONCE(infiltration_ach, 0, 20),
    AIRSIDE_ONCE(infiltration_wind_ach_s_m, 0, 2),
    AIRSIDE_ONCE(infiltration_stack_ach_k, 0, 1),
    AIRSIDE_ONCE(neighbour_temp_degc, 0, 45),
    AIRSIDE_ONCE(mixing_interior_m3_s, 0, 5),
    AIRSIDE_ONCE(mixing_perimeter_m3_s, 0, 5),
    AIRSIDE_ONCE(mixing_across_m3_s, 0, 5),
    AIRSIDE_EACH(zone, door_ach, 0, 50),
    AIRSIDE_ONCE(door_days_share, 0, 1),
    AIRSIDE_EACH(zone, gain_factor, 0, 10),
    AIRSIDE_ONCE(gain_base_w_m2, -50, 200),
    AIRSIDE_ONCE(gain_occupied_w_m2, 0, 200),
    AIRSIDE_ONCE(gain_after_hours_w_m2, -50, 200),
    AIRSIDE_ONCE(gain_lunch_w_m2, -50, 200),
    AIRSIDE_ONCE(gain_weekend_w_m2, -50, 200),
    AIRSIDE_ONCE(gain_radiant_share, 0, 1),
    AIRSIDE_ONCE(occupancy_start_h, 0, 24),
    AIRSIDE_ONCE(occupancy_end_h, 0, 24),
    AIRSIDE_ONCE(occupancy_ramp_h, 0.05, 6),
    AIRSIDE_ONCE(occupancy_lunch_dip, 0, 1),
    AIRSIDE_ONCE(occupancy_weekend_factor, 0, 2),
    AIRSIDE_ONCE(occupancy_shift_h, -12, 12),
    AIRSIDE_ONCE(occupancy_day_sd, 0, 1),
    AIRSIDE_ONCE(occupancy_zone_sd, 0, 1),
    AIRSIDE_ONCE(occupancy_noise_sd, 0, 1),
    AIRSIDE_ONCE(arrival_sd_min, 0, 120),
    AIRSIDE_ONCE(occupancy_absent_share, 0, 1),
    AIRSIDE_ONCE(plenum_gain_share, 0, 0.9),
    AIRSIDE_EACH(zone, heater_w, 0, 20000),
    AIRSIDE_ONCE(heater_period_min, 3, 1440),
    AIRSIDE_ONCE(heater_on_min, 0, 1440),
    AIRSIDE_ONCE(heater_start_h, 0, 24),
    AIRSIDE_ONCE(heater_stop_h, 0, 24),
    AIRSIDE_EACH(vav, vav_flow_m3_s, 0.01, 20),
    AIRSIDE_EACH(vav, vav_damper, 0, 1),
    AIRSIDE_EACH(vav, vav_flow_calibration, 0.1, 3),
    AIRSIDE_EACH(vav, vav_stuck_damper, -1, 1),
    AIRSIDE_ONCE(vav_modulation_per_k, 0, 2),
    AIRSIDE_ONCE(vav_off_leak, 0, 1),
    AIRSIDE_ONCE(vav_off_per_day, 0, 8),
    AIRSIDE_ONCE(vav_off_min_minutes, 3, 720),
    AIRSIDE_ONCE(vav_off_max_minutes, 3, 720),
    AIRSIDE_ONCE(supply_lag_s, 1, 7200),
    AIRSIDE_ONCE(supply_sensor_offset_k, -5, 5),
    AIRSIDE_ONCE(duct_gain_k, -5, 10),
    AIRSIDE_ONCE(duct_lag_s, 0, 7200),
    AIRSIDE_ONCE(duct_leak_share, 0, 0.9),
    AIRSIDE_ONCE(coil_capacity_kw, 0.5, 5000),
    AIRSIDE_ONCE(coil_fouling, 0, 0.95),
    AIRSIDE_ONCE(coil_latent_w_per_gkg_m3s, 0, 5000),
    AIRSIDE_ONCE(chilled_water_degc, 2, 20),
    AIRSIDE_ONCE(coil_approach_k, 0, 15),
    AIRSIDE_ONCE(chilled_water_offset_k, -10, 15),
    AIRSIDE_ONCE(chilled_water_drift_k_k, -1, 2),
    AIRSIDE_ONCE(ahu_stop_from_h, 0, 24),
    AIRSIDE_ONCE(ahu_stop_to_h, 0, 24),
    AIRSIDE_ONCE(outdoor_air_m3_s, 0, 20),
    AIRSIDE_ONCE(mau_room_share, 0, 1),
    AIRSIDE_ONCE(mau_setpoint_degc, 8, 35),
    AIRSIDE_ONCE(mau_noise_sd_k, 0, 5),
    AIRSIDE_ONCE(mau_capacity_kw, 0, 5000),
    AIRSIDE_EACH(fcu, fcu_flow_m3_s, 0, 5),
    AIRSIDE_EACH(fcu, fcu_capacity_factor, 0, 2),
    AIRSIDE_EACH(fcu, fcu_forced, -1, 1),
    AIRSIDE_EACH(fcu, fcu_setpoint_offset_k, -5, 5),
    AIRSIDE_ONCE(fcu_supply_degc, 5, 25),
    AIRSIDE_ONCE(fcu_coil_lag_s, 0, 7200),
    AIRSIDE_ONCE(fcu_setpoint_degc, 15, 35),
    AIRSIDE_ONCE(fcu_band_k, 0.05, 5),
    AIRSIDE_ONCE(fcu_start_h, 0, 24),
    AIRSIDE_ONCE(fcu_stop_h, 0, 24),
    AIRSIDE_ONCE(ahu_fan_kw, 0, 500),
    AIRSIDE_ONCE(fan_heat_share, 0, 1),
    AIRSIDE_ONCE(mau_fan_kw, 0, 100),
    AIRSIDE_ONCE(fcu_fan_kw, 0, 10),
    AIRSIDE_ONCE(pump_kw, 0, 500),
    AIRSIDE_ONCE(chiller_cop, 0.5, 15),
    AIRSIDE_ONCE(chiller_cop_per_k, -0.5, 0.1),
    AIRSIDE_ONCE(chiller_min_load_kw, 0, 1000),
    AIRSIDE_ONCE(chiller_part_load_loss, 0, 3),
    AIRSIDE_ONCE(chiller_full_load_kw, 1, 10000),
    AIRSIDE_EACH(vav, room_sensor_bias_k, -10, 10),
    AIRSIDE_EACH(vav, room_sensor_drift_k_per_day, -1, 1),
    AIRSIDE_EACH(vav, room_sensor_jet_share, 0, 1),
    AIRSIDE_EACH(vav, room_sensor_zone, 1, 64),
    AIRSIDE_EACH(fcu, fcu_sensor_bias_k, -10, 10),
    AIRSIDE_ONCE(room_sensor_lag_s, 0, 7200),
    AIRSIDE_ONCE(temp_noise_sd_k, 0, 2),
    AIRSIDE_ONCE(power_noise_share, 0, 0.5),
    AIRSIDE_ONCE(clock_shift_s, -21600, 21600),
    AIRSIDE_ONCE(outdoor_sensor_bias_k, -10, 10),
    AIRSIDE_ONCE(site_temp_offset_k, -10, 10),
    AIRSIDE_ONCE(site_solar_factor, 0, 3),
};

#undef AIRSIDE_ONCE
#undef AIRSIDE_EACH

std::size_t expected_count(const RcRoom& room, Repeats repeats) {
  switch (repeats) {
    case Repeats::once: return 1;
    case Repeats::zone: return static_cast<std::size_t>(room.zones());
    case Repeats::vav: return static_cast<std::size_t>(room.vavs);
    case Repeats::fcu: return static_cast<std::size_t>(room.fcus);
  }
  return 1;
}

void check_range(const RoomField& field, double value, const std::string& place) {
  if (std::isfinite(value) && value >= field.lowest && value <= field.highest) return;
  const auto text = [](double x) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%g", x);
    return std::string(buffer);
  };
  throw hal::InputError(place + ": " + std::string(field.name), text(value),
                        "a number from " + text(field.lowest) + " to " + text(field.highest),
                        "correct the value (the name ends in its unit)");
}

void check_order(const std::string& place, const char* first, double low, const char* second, double high) {
  if (low < high) return;
  throw hal::InputError(place + ": " + second, std::to_string(high),
                        std::string("more than ") + first + " = " + std::to_string(low), "correct one of the two");
}

}  // namespace

std::span<const RoomField> room_fields() { return fields; }

const RoomField* find_room_field(std::string_view name) {
  const auto* found = std::find_if(fields.begin(), fields.end(), [&](const RoomField& f) { return f.name == name; });
  return found == fields.end() ? nullptr : found;
}

void check_room(const RcRoom& room, const std::string& place) {
  for (const RoomField& field : fields) {
    if (const auto* scalar = std::get_if<ScalarField>(&field.member)) {
      check_range(field, room.*(*scalar), place);
      continue;
    }
    const auto& list = room.*std::get<ListField>(field.member);
    const std::size_t expected = expected_count(room, field.repeats);
    if (list.size() != expected) {
      throw hal::InputError(place + ": " + std::string(field.name), std::to_string(list.size()) + " values",
                            std::to_string(expected) + " values", "give one number for all, or one for each");
    }
    for (double value : list) check_range(field, value, place);
  }
  for (double zone : room.room_sensor_zone) {
    if (zone == std::floor(zone) && zone <= room.vavs) continue;
    throw hal::InputError(place + ": room_sensor_zone", std::to_string(zone),
                          "a whole number from 1 to " + std::to_string(room.vavs), "number the VAVs from 1");
  }
  for (double forced : room.fcu_forced) {
    if (forced == std::floor(forced)) continue;
    throw hal::InputError(place + ": fcu_forced", std::to_string(forced), "-1, 0 or 1",
                          "use 0 for an FCU that does as recorded");
  }
  check_order(place, "occupancy_start_h", room.occupancy_start_h, "occupancy_end_h", room.occupancy_end_h);
  check_order(place, "vav_off_min_minutes", room.vav_off_min_minutes - 1e-9, "vav_off_max_minutes",
              room.vav_off_max_minutes);
}

}  // namespace airside::sim
