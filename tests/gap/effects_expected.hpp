#pragma once
// What every effect must do on either engine: a recording in which each has its occasion, and the channels that it
// must move, with the sign where physics has one.

#include <cmath>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "airside/signals.hpp"
#include "sim/effects/effect.hpp"
#include "sim/weather/recording.hpp"
#include "support/default_cycle.hpp"

namespace airside::sim {

/// Restless setpoints, every box shut for an hour a day, fan coils on for a part of each hour by day, an hour of rain.
/// `coldest_degc`: setpoint in the hour from coldest_h.
inline Recording eventful_recording(std::shared_ptr<const Weather> station, CivilTime from, int days,
                                    double coldest_degc, double coldest_h) {
  Recording recording;
  recording.from = from;
  for (int i = 0; i < days * rows_per_day; ++i) {
    const CivilTime t{from.seconds + i * std::int64_t{row_s}};
    const double hour = t.second_of_day() / 3600.0, minute = std::fmod(60 * hour, 60);
    const double golden = static_cast<double>(t.seconds / cycle_s) * 0.6180339887498949;
    RecordedRow row;
    row.setpoint_degc =
        hour >= coldest_h && hour < coldest_h + 1 ? coldest_degc : 19 + 5 * (golden - std::floor(golden));
    row.outdoor_temp_degc = station->at(t).outdoor_temp_degc;
    row.rain = hour >= 15 && hour < 16 ? 1 : 0;
    for (int place = 0; place < 5; ++place) {
      row.vav_on.push_back(hour >= 10 + place && hour < 11 + place ? 0 : 1);
      row.fcu_on.push_back(hour >= 8 && hour < 19 && std::fmod(minute + 12 * place, 60) < 36 ? 1 : 0);
    }
    recording.rows.push_back(std::move(row));
  }
  recording.station = std::move(station);
  return recording;
}

enum class Shown { room, fcu, mau, supply, fans, chiller, duty };

/// `sign`: of the mean response to a larger magnitude; 0: either.
struct ExpectedSign {
  std::string_view effect;
  int place;
  Shown shown;
  int sign;
};

/// Places are 0-based; façades: 1 east, 2 south, 3 west; zones: 0 interior, 6 perimeter.
inline constexpr ExpectedSign expected_signs[] = {
    {"chilled_water", 0, Shown::supply, 1},
    {"chilled_water_drift", 0, Shown::fcu, 1},
    {"chiller_cop", 0, Shown::chiller, -1},
    {"clock_shift", 0, Shown::fcu, 0},
    {"clock_shift", 0, Shown::room, 0},
    {"coil_capacity", 0, Shown::supply, -1},
    {"coil_capacity", 0, Shown::room, -1},
    {"duct_heat_gain", 0, Shown::room, 1},
    {"duct_heat_gain", 0, Shown::chiller, 1},
    {"duct_leak", 0, Shown::room, 1},
    {"envelope_u", 0, Shown::fcu, 0},
    {"fan_heat", 0, Shown::chiller, 1},
    {"fan_power", 0, Shown::fans, 1},
    {"fan_power", 0, Shown::chiller, 1},
    {"fcu_degraded", 1, Shown::fcu, -1},
    {"fcu_degraded", 1, Shown::duty, -1},
    {"fcu_rests_unrecorded", 1, Shown::fcu, -1},
    {"fcu_rests_unrecorded", 1, Shown::duty, -1},
    {"fcu_runs_unrecorded", 1, Shown::fcu, -1},
    {"fcu_sensor_bias", 1, Shown::fcu, 1},
    {"gain_after_hours", 0, Shown::room, 1},
    {"gain_base", 0, Shown::room, 1},
    {"gain_base", 0, Shown::duty, 1},
    {"gain_lunch", 0, Shown::room, 1},
    {"gain_occupied", 0, Shown::room, 1},
    {"gain_weekend", 0, Shown::room, 1},
    {"gain_zone", 0, Shown::room, 1},
    {"gain_zone", 6, Shown::fcu, 1},
    {"humidity_differs", 0, Shown::chiller, 1},
    {"infiltration", 0, Shown::fcu, 0},
    {"infiltration_stack", 0, Shown::fcu, 0},
    {"infiltration_wind", 0, Shown::fcu, 0},
    {"latent_load", 0, Shown::chiller, 1},
    {"mau_capacity", 0, Shown::mau, -1},
    {"mau_setpoint", 0, Shown::mau, 1},
    {"mau_setpoint", 0, Shown::chiller, -1},
    {"mixing_across", 0, Shown::fcu, 0},
    {"mixing_interior", 0, Shown::room, 0},
    {"mixing_perimeter", 0, Shown::fcu, 0},
    {"neighbour_heat", 0, Shown::room, 1},
    {"occupancy_shift", 0, Shown::room, 0},
    {"outdoor_air_flow", 0, Shown::chiller, 1},
    {"outdoor_sensor_bias", 0, Shown::fcu, -1},
    {"pump_power", 0, Shown::chiller, 1},
    {"rain_cooling", 0, Shown::fcu, -1},
    {"room_sensor_bias", 2, Shown::room, 1},
    {"room_sensor_drift", 2, Shown::room, 1},
    {"room_sensor_jet", 2, Shown::room, -1},
    {"room_sensor_lag", 2, Shown::room, 0},
    {"setpoint_lag", 0, Shown::room, 0},
    {"setpoint_lag", 0, Shown::supply, 0},
    {"solar_gain", 1, Shown::fcu, 1},
    {"solar_gain", 2, Shown::fcu, 1},
    {"solar_gain", 3, Shown::fcu, 1},
    {"sun_differs", 0, Shown::fcu, 1},
    {"supply_sensor_offset", 0, Shown::room, -1},
    {"supply_sensor_offset", 0, Shown::chiller, 1},
    {"swapped_sensors", 3, Shown::room, 0},
    {"thermal_mass", 0, Shown::room, 0},
    {"vav_flow", 2, Shown::room, -1},
    {"vav_flow", 2, Shown::fans, 1},
    {"vav_stuck", 2, Shown::room, -1},
};

/// What of a response shows in a group of channels: the column with the largest root mean square.
struct ShownResponse {
  int column = 0;
  double rms = 0, mean = 0, largest = 0;
};

inline ShownResponse shown_in(const ChannelTable& response, int first, int count) {
  ShownResponse most;
  most.column = first;
  for (int c = first; c < first + count; ++c) {
    const double rms = std::sqrt(response.col(c).squaredNorm() / static_cast<double>(response.rows()));
    if (rms > most.rms) most = {c, rms, response.col(c).mean(), response.col(c).cwiseAbs().maxCoeff()};
  }
  return most;
}

inline ShownResponse shown_in(const ChannelTable& response, const Channels& at, Shown shown) {
  switch (shown) {
    case Shown::room: return shown_in(response, 0, at.rooms);
    case Shown::fcu: return shown_in(response, at.fcu_temp(), at.fcus);
    case Shown::mau: return shown_in(response, at.mau_temp(), 1);
    case Shown::supply: return shown_in(response, at.supply_temp(), 1);
    case Shown::fans: return shown_in(response, at.power(), 1);
    case Shown::chiller: return shown_in(response, at.power() + 1, 1);
    case Shown::duty: return shown_in(response, at.fcu_duty(), at.fcus);
  }
  return {};
}

}  // namespace airside::sim
