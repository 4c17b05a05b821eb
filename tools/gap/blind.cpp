#include "tools/gap/blind.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "sim/rc_plant.hpp"
#include "sim/stateless_draw.hpp"

namespace airside::tools::gap {

namespace {

enum RoomDraw : std::uint64_t { draw_structure = 710, draw_schedule, draw_missing };

double& entry(std::vector<double>& list, int place) { return list.at(static_cast<std::size_t>(place)); }

/// Sensors, clocks and commands have fields of their own in a room; the rest goes through the effect's file.
bool hide_directly(sim::RcRoom& room, const Hidden& h) {
  const double m = h.magnitude;
  if (h.effect == "fcu_runs_unrecorded")
    entry(room.fcu_forced, h.place) = m >= 0.5 ? 1 : 0;
  else if (h.effect == "fcu_rests_unrecorded")
    entry(room.fcu_forced, h.place) = m < 0.5 ? -1 : 0;
  else if (h.effect == "vav_stuck")
    entry(room.vav_stuck_damper, h.place) = m * entry(room.vav_damper, h.place);
  else if (h.effect == "room_sensor_bias")
    entry(room.room_sensor_bias_k, h.place) += m;
  else if (h.effect == "room_sensor_drift")
    entry(room.room_sensor_drift_k_per_day, h.place) += m;
  else if (h.effect == "room_sensor_jet")
    entry(room.room_sensor_jet_share, h.place) += m;
  else if (h.effect == "room_sensor_lag")
    return true;  // on the log
  else if (h.effect == "fcu_sensor_bias")
    entry(room.fcu_sensor_bias_k, h.place) += m;
  else if (h.effect == "swapped_sensors") {
    const auto [a, b] = sim::vav_pair(h.place, room.vavs);
    std::swap(entry(room.room_sensor_zone, a), entry(room.room_sensor_zone, b));
  } else if (h.effect == "clock_shift")
    room.clock_shift_s += 3600 * m;
  else if (h.effect == "sun_differs")
    room.site_solar_factor *= m;
  else if (h.effect == "outdoor_sensor_bias")
    room.outdoor_sensor_bias_k += m;
  // Outside the library: the workflow must say that it does not know.
  else if (h.effect == "fcu_dial")
    entry(room.fcu_setpoint_offset_k, h.place) += m;
  else if (h.effect == "damper_opening")
    for (double& d : room.vav_damper) d *= m;
  else
    return false;
  return true;
}

void lag_sensor(std::vector<hal::LogRow>& rows, int place, double lag_s) {
  const auto k = static_cast<std::size_t>(place);
  const double share = 1 - std::exp(-row_s / lag_s);
  double shown = rows.front().value[k];
  for (hal::LogRow& row : rows) {
    shown += share * (row.value[k] - shown);
    row.value[k] = std::round(100 * shown) / 100;
  }
}

}  // namespace

sim::RcRoom measured_room(const sim::RcRoom& twin, std::uint64_t seed, bool feedback) {
  sim::Perturbation by;
  by.site_temp_k = 0.5;
  sim::RcRoom room = sim::perturbed_room(twin, seed, by);
  auto uniform = [seed, n = 0](double low, double high) mutable {
    return low + (high - low) * sim::draw_uniform(seed, draw_structure, static_cast<std::uint64_t>(n++), 0);
  };
  // Structure that the workflow's room has not: other splits of heat between air and mass, leaks that follow the wind,
  // sensors in the stream, boxes that modulate.
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

sim::RcRoom hide(sim::RcRoom room, const std::vector<Hidden>& hidden, const std::vector<sim::Effect>& effects) {
  for (const Hidden& h : hidden) {
    if (hide_directly(room, h)) continue;
    const auto found = std::find_if(effects.begin(), effects.end(), [&h](const auto& e) { return e.name == h.effect; });
    if (found == effects.end() || found->rc.empty()) throw std::invalid_argument("cannot hide " + h.effect);
    const sim::EffectChange change{{&*found, h.place}, h.magnitude};
    room = sim::changed_room(std::move(room), std::span(&change, 1));
  }
  return room;
}

std::vector<hal::LogRow> measure(const sim::RcRoom& room, std::shared_ptr<const sim::Weather> weather,
                                 const MeasuredRun& run, const std::vector<Hidden>& hidden) {
  const hal::TopologyCounts counts{"", room.vavs, room.fcus, room.powers};
  const CivilTime begin{run.start.seconds - 3 * std::int64_t{86400}};
  const CivilTime end{run.start.seconds + run.days * std::int64_t{86400}};
  sim::RcPlant plant(room, std::move(weather), begin, run.seed);
  std::vector<hal::LogRow> rows;
  double setpoint = 23, integral = 23;
  while (plant.time() < end) {
    const CivilTime t = plant.time();
    const sim::Sensors& s = plant.sensors();
    if (starts_cycle(t)) {
      double mean = 0;
      for (const double temp : s.room_temp_degc) mean += temp / room.vavs;
      integral = std::clamp(integral + 5.0 * 0.3 * (25.25 - mean), 20.0, 26.0);
      const auto day_step = t.seconds / (6 * 3600);  // the schedule steps four times a day
      const double varied = 20.5 + 4.0 * sim::draw_uniform(run.seed, draw_schedule, 0, day_step);
      setpoint = std::round(100 * (run.feedback ? integral : varied)) / 100;
      plant.set_setpoint(setpoint);
    }
    if (!(t < run.start)) {
      hal::LogRow row = hal::make_log_row(counts);
      row.time = t;
      auto out = row.value.begin();
      const auto put = [&out](const std::vector<double>& list) { out = std::copy(list.begin(), list.end(), out); };
      put(s.room_temp_degc);
      put(s.fcu_temp_degc);
      put(s.vav_on);
      put(s.fcu_on);
      put(s.power_kw);
      *out++ = s.mau_temp_degc;
      *out++ = s.outdoor_temp_degc;
      *out++ = s.rain;
      row.setpoint_degc = setpoint;
      row.supply_temp_degc = s.supply_temp_degc;
      for (std::size_t i = 0; i < row.value.size() && run.missing_share > 0; ++i) {
        if (sim::draw_uniform(run.seed, draw_missing, i, t.seconds) < run.missing_share) {
          row.value[i] = std::numeric_limits<double>::quiet_NaN();
        }
      }
      rows.push_back(std::move(row));
    }
    plant.advance_to({t.seconds + row_s});
  }
  for (const Hidden& h : hidden) {
    if (h.effect == "room_sensor_lag") lag_sensor(rows, h.place, h.magnitude);
  }
  return rows;
}

}  // namespace airside::tools::gap
