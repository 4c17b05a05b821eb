#include "sim/rc/modulating_plant.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>
#include <utility>

#include "sim/stateless_draw.hpp"

namespace airside::sim {
namespace {

constexpr double air_heat_j_m3k = 1.2 * 1006;
constexpr double evaporation_j_kg = 2.5e6;
constexpr int inner_steps = 6;           // of 30 s
constexpr double damper_travel_s = 120;  // from shut to open
enum ModulatingNoise : std::uint64_t { noise_zone = 181, noise_meter, noise_air, noise_flow };

}  // namespace

ModulatingPlant::ModulatingPlant(ModulatingRoom room, std::shared_ptr<const Weather> weather, CivilTime start,
                                 std::uint64_t seed, double setpoint_degc)
    : room_(std::move(room)),
      weather_(std::move(weather)),
      seed_(seed_in_room(room_.building, seed)),
      now_(start),
      setpoint_degc_(setpoint_degc),
      supply_degc_(setpoint_degc) {
  check_room(room_.building, "room " + room_.name);
  const std::size_t zones = room_.air.flow_max_m3_s.size();
  air_degc_.assign(zones, 24.0);
  mass_degc_.assign(zones, 24.0);
  wall_degc_.assign(zones, 23.0);
  damper_.assign(zones, 0.0);
  flow_m3_s_.assign(zones, 0.0);
  discharge_degc_.assign(zones, setpoint_degc);
  reheat_now_kw_.assign(zones, 0.0);
  loops_.assign(zones, {});
  held_.assign(zones, not_shown);
  disturb(room_.building, *weather_, seed_, now_, disturbance_);
  read_sensors();
}

std::string ModulatingPlant::description() const {
  return room_.name + ", seed " + std::to_string(seed_in_room(room_.building, seed_)) + ", weather " +
         weather_->description();
}

bool ModulatingPlant::hour_within(double from_h, double to_h) const {
  const double hour = now_.second_of_day() / 3600.0;
  return hour >= from_h && hour < to_h;
}

double ModulatingPlant::zone_cooling_degc(std::size_t z) const {
  const ModulatingAir& air = room_.air;
  return air.cooling_degc[z] + (hour_within(air.occupied_start_h, air.occupied_stop_h) ? 0 : air.setback_k);
}

double ModulatingPlant::zone_heating_degc(std::size_t z) const {
  const ModulatingAir& air = room_.air;
  return air.heating_degc[z] - (hour_within(air.occupied_start_h, air.occupied_stop_h) ? 0 : air.setback_k);
}

void ModulatingPlant::advance_to(CivilTime t) {
  if (t < now_ || (t.seconds - now_.seconds) % step_s != 0) {
    throw std::invalid_argument("ModulatingPlant: time must be a whole number of 3-min steps ahead");
  }
  while (now_ < t) {
    disturb(room_.building, *weather_, seed_, now_, disturbance_);
    fan_sum_kw_ = cooling_sum_kw_ = heat_sum_kw_ = 0;
    for (int i = 0; i < inner_steps; ++i) inner_step(static_cast<double>(step_s) / inner_steps);
    now_.seconds += step_s;
    read_sensors();
  }
}

void ModulatingPlant::inner_step(double dt_s) {
  move_dampers(dt_s);
  handle_air(dt_s);
  warm_zones(dt_s);
  count(dt_s);
}

/// Cooling loop -> flow from minimum to maximum; below the heating setpoint minimum flow is reheated.
void ModulatingPlant::move_dampers(double dt_s) {
  const ModulatingAir& air = room_.air;
  const bool runs = fan_runs();
  for (std::size_t z = 0; z < damper_.size(); ++z) {
    Loop& loop = loops_[z];
    if (!runs) {
      loop = {};
      damper_[z] = flow_m3_s_[z] = 0;
      continue;
    }
    const double warm_k = air_degc_[z] - zone_cooling_degc(z), cold_k = zone_heating_degc(z) - air_degc_[z];
    const double integral = air.loop_integral_per_kh * dt_s / 3600;
    loop.cooling_integral = std::clamp(loop.cooling_integral + integral * warm_k, 0.0, 1.0);
    loop.heating_integral = std::clamp(loop.heating_integral + integral * cold_k, 0.0, 1.0);
    loop.cooling = std::clamp(air.loop_gain_per_k * warm_k + loop.cooling_integral, 0.0, 1.0);
    loop.heating = std::clamp(air.loop_gain_per_k * cold_k + loop.heating_integral, 0.0, 1.0);
    const double wanted = air.flow_min_share[z] + (1 - air.flow_min_share[z]) * loop.cooling;
    const double reach = dt_s / damper_travel_s;
    damper_[z] += std::clamp(wanted - damper_[z], -reach, reach);
    if (!std::isnan(held_[z])) damper_[z] = held_[z];
    flow_m3_s_[z] = damper_[z] * air.flow_max_m3_s[z];
  }
}

/// Mixed air, fan, coil, chiller; then each box's own coil.
void ModulatingPlant::handle_air(double dt_s) {
  const ModulatingAir& air = room_.air;
  const double outdoor = disturbance_.weather.outdoor_temp_degc;
  flow_total_m3_s_ = std::accumulate(flow_m3_s_.begin(), flow_m3_s_.end(), 0.0);
  fan_kw_ = cooling_kw_ = heating_kw_ = 0;
  std::fill(reheat_now_kw_.begin(), reheat_now_kw_.end(), 0.0);
  if (flow_total_m3_s_ <= 0) return;

  const double design = std::accumulate(air.flow_max_m3_s.begin(), air.flow_max_m3_s.end(), 0.0);
  const double f = flow_total_m3_s_ / design;
  fan_kw_ = air.fan_kw * f * (air.static_share + (1 - air.static_share) * f * f);
  const double flow_w_k = flow_total_m3_s_ * air_heat_j_m3k;
  const double fan_rise_k = 1000 * fan_kw_ * air.fan_heat_share / flow_w_k;

  double returned = 0;
  for (std::size_t z = 0; z < air_degc_.size(); ++z) returned += flow_m3_s_[z] * air_degc_[z];
  returned /= flow_total_m3_s_;
  const double coil_wanted = std::max(setpoint_degc_, air.coldest_supply_degc) - fan_rise_k;
  const bool ventilates = hour_within(air.occupied_start_h, air.occupied_stop_h);
  double share = ventilates ? std::min(1.0, air.outdoor_min_m3_s / flow_total_m3_s_) : 0.0;
  if (air.economizer && outdoor < std::min(returned - 0.5, air.economizer_high_degc)) {
    share = std::clamp((returned - coil_wanted) / (returned - outdoor), share, 1.0);
  }
  const double mixed = returned + share * (outdoor - returned);
  const double mixed_kg_kg = humidity_kg_kg_ + share * (disturbance_.humidity_kg_kg - humidity_kg_kg_);

  // Below the dew point the coil dries: air leaves it nearly saturated.
  double off_coil = std::min(coil_wanted, mixed);
  double leaving_kg_kg = mixed_kg_kg;
  double load_kw = 0;
  if (mixed > coil_wanted) {
    leaving_kg_kg = std::min(mixed_kg_kg, humidity_ratio(coil_wanted, 95, disturbance_.weather.pressure_pa));
    const double latent_kw = flow_total_m3_s_ * 1.2 * (mixed_kg_kg - leaving_kg_kg) * evaporation_j_kg / 1000;
    const double wanted_kw = flow_w_k * (mixed - coil_wanted) / 1000 + latent_kw;
    load_kw = std::min(wanted_kw, air.coil_capacity_kw);
    off_coil = mixed - (mixed - coil_wanted) * load_kw / wanted_kw;
    leaving_kg_kg = mixed_kg_kg - (mixed_kg_kg - leaving_kg_kg) * load_kw / wanted_kw;
  } else if (mixed < coil_wanted) {
    heating_kw_ = flow_w_k * (coil_wanted - mixed) / 1000;  // too much cold outdoor air is warmed
    off_coil = coil_wanted;
  }
  const double supply_share = 1 - std::exp(-dt_s / air.supply_lag_s);
  supply_degc_ += supply_share * (off_coil + fan_rise_k - supply_degc_);

  if (load_kw > 0.1) {
    const double cop = std::max(1.5, air.chiller_cop + air.chiller_cop_per_k * (outdoor - 30));
    const double part = 1 + air.chiller_part_load_loss * (1 - std::min(1.0, load_kw / air.coil_capacity_kw));
    cooling_kw_ = load_kw / cop * part + air.pump_kw * std::min(1.0, 0.3 + load_kw / air.coil_capacity_kw);
  }
  for (std::size_t z = 0; z < air_degc_.size(); ++z) {
    discharge_degc_[z] = supply_degc_;
    if (loops_[z].heating <= 0 || flow_m3_s_[z] <= 0) continue;
    const double room_k = std::max(0.0, air.discharge_max_degc - supply_degc_);
    const double w_k = flow_m3_s_[z] * air_heat_j_m3k;
    reheat_now_kw_[z] = std::min(air.reheat_kw[z], loops_[z].heating * w_k * room_k / 1000);
    discharge_degc_[z] += 1000 * reheat_now_kw_[z] / w_k;
    heating_kw_ += reheat_now_kw_[z];
  }

  // One moisture balance for all rooms; outdoor air beyond the coil comes with what leaks in.
  const double volume = std::accumulate(room_.building.volume_m3.begin(), room_.building.volume_m3.end(), 0.0);
  const double zones = static_cast<double>(air_degc_.size());
  const double people = hour_within(air.occupied_start_h, air.occupied_stop_h) ? 1 : 0;
  const double made_kg_s = people * zones * air.moisture_g_s_per_zone / 1000;
  humidity_kg_kg_ +=
      dt_s * (made_kg_s / 1.2 + flow_total_m3_s_ * (leaving_kg_kg - humidity_kg_kg_)) / (2 * volume);  // 2: furniture
}

void ModulatingPlant::warm_zones(double dt_s) {
  const RcRoom& building = room_.building;
  const WeatherRecord& weather = disturbance_.weather;
  const double outdoor = weather.outdoor_temp_degc;
  const std::size_t zones = air_degc_.size();
  const std::vector<double> before = air_degc_;
  for (std::size_t z = 0; z < zones; ++z) {
    const std::array<double, facades> glass = {building.window_north_m2[z], building.window_east_m2[z],
                                               building.window_south_m2[z], building.window_west_m2[z]};
    double sun_w = 0, glass_m2 = 0, wall_sun_w_m2 = 0;
    for (std::size_t f = 0; f < facades; ++f) {
      sun_w += glass[f] * building.shgc * disturbance_.facade_w_m2[f];
      wall_sun_w_m2 += glass[f] * disturbance_.facade_w_m2[f];
      glass_m2 += glass[f];
    }
    if (glass_m2 > 0) wall_sun_w_m2 /= glass_m2;
    const double air = before[z];
    const double air_j_k = building.volume_m3[z] * air_heat_j_m3k * 3 * building.capacity_factor;
    const double mass_j_k = 1000 * building.mass_kj_k[z] * building.capacity_factor;
    const double wall_j_k = 1000 * building.wall_kj_k[z] * building.capacity_factor;
    const double ach = building.infiltration_ach * building.infiltration_share[z];
    const double out_w_k = building.window_u_w_m2k * glass_m2 + ach * building.volume_m3[z] * air_heat_j_m3k / 3600;
    double mixing_w = 0;
    const double mixing_w_k = building.mixing_interior_m3_s * air_heat_j_m3k;
    if (z > 0) mixing_w += mixing_w_k * (before[z - 1] - air);
    if (z + 1 < zones) mixing_w += mixing_w_k * (before[z + 1] - air);
    const double gain_w = disturbance_.gain_w[z];
    const double radiant_w = building.gain_radiant_share * gain_w + building.solar_to_mass_share * sun_w;
    const double mass_w = building.mass_ua_w_k[z] * (mass_degc_[z] - air);
    const double wall_w = 2 * building.wall_ua_w_k[z] * (wall_degc_[z] - air);
    const double skin = outdoor + building.wall_absorptance / building.wall_film_w_m2k * wall_sun_w_m2;
    const double skin_w = 2 * building.wall_ua_w_k[z] * (skin - wall_degc_[z]);
    const double box_w = flow_m3_s_[z] * air_heat_j_m3k * (discharge_degc_[z] - air);
    const double neighbour_w = building.neighbour_ua_w_k[z] * (building.neighbour_temp_degc - air);
    air_degc_[z] +=
        dt_s / air_j_k *
        (mixing_w + mass_w + wall_w + out_w_k * (outdoor - air) + neighbour_w + box_w + gain_w + sun_w - radiant_w);
    mass_degc_[z] += dt_s / mass_j_k * (radiant_w - mass_w);
    wall_degc_[z] += dt_s / wall_j_k * (skin_w - wall_w);
  }
}

void ModulatingPlant::count(double dt_s) {
  const double hours = dt_s / 3600;
  fan_sum_kw_ += fan_kw_ / inner_steps;
  cooling_sum_kw_ += cooling_kw_ / inner_steps;
  heat_sum_kw_ += heating_kw_ / inner_steps;
  energy_.fan_kwh += fan_kw_ * hours;
  energy_.cooling_kwh += cooling_kw_ * hours;
  energy_.reheat_kwh += heating_kw_ * hours;
  if (!hour_within(room_.air.occupied_start_h, room_.air.occupied_stop_h)) return;
  for (std::size_t z = 0; z < air_degc_.size(); ++z) {
    comfort_.above_degch += std::max(0.0, air_degc_[z] - zone_cooling_degc(z) - 0.5) * hours;
    comfort_.below_degch += std::max(0.0, zone_heating_degc(z) - 0.5 - air_degc_[z]) * hours;
    comfort_.saturated_h += damper_[z] > 0.95 ? hours : 0;
  }
}

void ModulatingPlant::read_sensors() {
  const RcRoom& building = room_.building;
  const std::int64_t slot = now_.seconds / step_s;
  const auto noise = [&](std::uint64_t stream, std::size_t place) { return draw_normal(seed_, stream, place, slot); };
  const auto hundredths = [](double value) { return std::round(value * 100) / 100; };
  const std::size_t zones = air_degc_.size();
  sensors_.room_temp_degc.resize(zones);
  sensors_.vav_on.assign(zones, fan_runs() ? 1.0 : 0.0);
  boxes_.damper.resize(zones);
  boxes_.zone_setpoint_degc.resize(zones);
  sensors_.heating_setpoint_degc.resize(zones);
  for (std::size_t z = 0; z < zones; ++z) {
    sensors_.room_temp_degc[z] = hundredths(air_degc_[z] + building.temp_noise_sd_k * noise(noise_zone, z));
    boxes_.damper[z] = hundredths(damper_[z]);
    boxes_.zone_setpoint_degc[z] = hundredths(zone_cooling_degc(z));
    sensors_.heating_setpoint_degc[z] = hundredths(zone_heating_degc(z));
  }
  boxes_.occupied = hour_within(room_.air.occupied_start_h, room_.air.occupied_stop_h) ? 1 : 0;
  boxes_.fan_runs = sensors_.vav_on.front();
  boxes_.supply_flow_m3_s = std::max(0.0, flow_total_m3_s_ * (1 + 0.02 * noise(noise_flow, 0)));
  sensors_.damper = boxes_.damper;
  sensors_.zone_setpoint_degc = boxes_.zone_setpoint_degc;
  sensors_.occupied = boxes_.occupied;
  sensors_.supply_flow_m3s = boxes_.supply_flow_m3_s;
  sensors_.ahu_on = boxes_.fan_runs;
  const auto metered = [&](double kw, std::size_t place) {
    return hundredths(std::max(0.0, kw * (1 + building.power_noise_share * noise(noise_meter, place))));
  };
  switch (building.powers) {
    case 0: sensors_.power_kw.clear(); break;
    case 1: sensors_.power_kw = {metered(fan_sum_kw_ + cooling_sum_kw_ + heat_sum_kw_, 0)}; break;
    case 2: sensors_.power_kw = {metered(fan_sum_kw_, 0), metered(cooling_sum_kw_ + heat_sum_kw_, 1)}; break;
    default: sensors_.power_kw = {metered(fan_sum_kw_, 0), metered(cooling_sum_kw_, 1), metered(heat_sum_kw_, 2)};
  }
  sensors_.outdoor_temp_degc =
      hundredths(disturbance_.weather.outdoor_temp_degc + building.temp_noise_sd_k * noise(noise_air, 0));
  sensors_.mau_temp_degc = sensors_.outdoor_temp_degc;  // outdoor air comes as it is
  sensors_.rain = disturbance_.weather.rain;
  sensors_.supply_temp_degc = hundredths(supply_degc_ + building.temp_noise_sd_k * noise(noise_air, 1));
  sensors_.setpoint_degc = setpoint_degc_;
}

}  // namespace airside::sim
