#include "sim/rc/rc_plant.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>
#include <stdexcept>

#include "sim/rc/rc_network.hpp"
#include "sim/stateless_draw.hpp"

namespace airside::sim {
namespace {

constexpr double evaporation_kj_kg = 2500;
constexpr double design_room_degc = 25.25;
enum NoiseStream : std::uint64_t { noise_room = 51, noise_fcu, noise_power, noise_mau, noise_outdoor, noise_supply };

double rounded(double value) { return std::round(value * 100) / 100; }

}  // namespace

RcPlant::RcPlant(RcRoom room, std::shared_ptr<const Weather> weather, CivilTime start, std::uint64_t seed,
                 double setpoint_degc)
    : weather_(std::move(weather)),
      seed_(seed_in_room(room, seed)),
      start_(start),
      now_(start),
      frozen_at_(start),
      setpoint_degc_(setpoint_degc),
      supply_degc_(setpoint_degc),
      duct_degc_(setpoint_degc) {
  check_room(room, "room " + room.name);
  room_ = std::make_shared<const RcRoom>(std::move(room));
  network_ = std::make_shared<const RcNetwork>(*room_);
  const auto zones = static_cast<std::size_t>(room_->zones());
  air_degc_.assign(zones, 25.0);
  mass_degc_.assign(zones, 25.0);
  wall_degc_.assign(zones, 27.0);
  deep_degc_.assign(zones, 25.0);
  wall_sun_k_.assign(zones, 0.0);
  sun_w_ = sol_air_k_ = wall_sun_k_;
  sensed_degc_.assign(zones, 25.0);
  flux_w_.assign(zones, 0.0);
  vav_w_k_.assign(static_cast<std::size_t>(room_->vavs), 0.0);
  fcu_on_.assign(static_cast<std::size_t>(room_->fcus), 0.0);
  fcu_duty_ = fcu_cold_ = fcu_on_;
  update_disturbance();
  update_thermostats();
  update_airflow();
  update_power();
  read_sensors();
}

CivilTime RcPlant::true_time() const {
  return {now_.seconds - static_cast<std::int64_t>(std::llround(room_->clock_shift_s))};
}

void RcPlant::update_disturbance() {
  const auto shift = static_cast<std::int64_t>(std::llround(room_->clock_shift_s));
  switch (future_) {
    case Future::actual: disturb(*room_, *weather_, seed_, true_time(), disturbance_); break;
    case Future::expected:
      expect(*room_, weather_->location(), held_, {frozen_at_.seconds - shift}, true_time(), disturbance_);
      break;
    case Future::frozen: break;
  }
  const RcRoom& room = *room_;
  const double outdoor = disturbance_.weather.outdoor_temp_degc;
  water_k_ = room.chilled_water_offset_k + room.chilled_water_drift_k_k * std::max(0.0, outdoor - 26);
  const double mau_w_k = room.outdoor_air_m3_s * RcNetwork::air_j_m3k;
  mau_degc_ = std::min(disturbance_.mau_setpoint_degc, outdoor);
  if (mau_w_k <= 0) {
    mau_load_kw_ = 0;
    return;
  }
  // Air leaves the coil saturated at most; a unit short of capacity lets temperature rise.
  const double dried = humidity_ratio(mau_degc_, 95, disturbance_.weather.pressure_pa);
  const double latent_kw =
      room.outdoor_air_m3_s * 1.2 * std::max(0.0, disturbance_.humidity_kg_kg - dried) * evaporation_kj_kg;
  const double wanted_kw = mau_w_k * (outdoor - mau_degc_) / 1000 + latent_kw;
  mau_load_kw_ = std::min(wanted_kw, room.mau_capacity_kw);
  if (wanted_kw > 0) mau_degc_ = outdoor - (outdoor - mau_degc_) * mau_load_kw_ / wanted_kw;
}

void RcPlant::obey_recording() {
  const RecordedRow& row = recording_->at(now_);
  disturbance_.vav_on = row.vav_on;
  if (!own_thermostats_) fcu_on_ = row.fcu_on;
  if (!row.zone_heat_kw.empty()) set_zone_heat(row.zone_heat_kw);
}

void RcPlant::command(std::vector<double> vav_on, std::vector<double> fcu_on) {
  if (vav_on.size() != vav_w_k_.size() || fcu_on.size() != fcu_on_.size())
    throw std::invalid_argument("RcPlant: a command must be given for every box and fan coil");
  vav_commanded_ = std::move(vav_on);
  fcu_commanded_ = std::move(fcu_on);
  update_disturbance();
  if (recording_) obey_recording();
  update_thermostats();
  obey_commands();
  update_airflow();
  sensors_.vav_on = disturbance_.vav_on;
  sensors_.fcu_on = fcu_on_;
}

void RcPlant::obey_commands() {
  for (std::size_t v = 0; v < vav_commanded_.size(); ++v) {
    if (std::isfinite(vav_commanded_[v])) disturbance_.vav_on[v] = vav_commanded_[v];
  }
  for (std::size_t f = 0; f < fcu_commanded_.size(); ++f) {
    if (std::isfinite(fcu_commanded_[f])) fcu_on_[f] = fcu_commanded_[f];
  }
}

void RcPlant::set_zone_heat(const std::vector<double>& kw) {
  if (kw.size() != air_degc_.size()) throw std::invalid_argument("RcPlant: heat must be given for every zone");
  heat_w_.resize(kw.size());
  std::transform(kw.begin(), kw.end(), heat_w_.begin(), [](double x) { return 1000 * x; });
}

void RcPlant::update_thermostats() {
  if (future_ == Future::frozen || !own_thermostats_) return;
  const RcRoom& room = *room_;
  const double hour = now_.second_of_day() / 3600.0;
  const bool hours = hour >= room.fcu_start_h && hour < room.fcu_stop_h;
  for (std::size_t f = 0; f < fcu_on_.size(); ++f) {
    const double seen = air_degc_[vav_w_k_.size() + f] + room.fcu_sensor_bias_k[f] - room.fcu_setpoint_offset_k[f];
    if (!hours || seen <= room.fcu_setpoint_degc - room.fcu_band_k)
      fcu_on_[f] = 0;
    else if (seen >= room.fcu_setpoint_degc + room.fcu_band_k)
      fcu_on_[f] = 1;
  }
}

bool RcPlant::ahu_rests() const {
  const double from = room_->ahu_stop_from_h, to = room_->ahu_stop_to_h, hour = now_.second_of_day() / 3600.0;
  return from <= to ? hour >= from && hour < to : hour >= from || hour < to;
}

double RcPlant::damper(std::size_t vav) const {
  const RcRoom& room = *room_;
  if (ahu_rests()) return 0;
  if (room.vav_stuck_damper[vav] >= 0) return room.vav_stuck_damper[vav];
  if (disturbance_.vav_on[vav] < 0.5) return room.vav_damper[vav] * room.vav_off_leak;
  const double opening = room.vav_damper[vav] + room.vav_modulation_per_k * (air_degc_[vav] - design_room_degc);
  return std::clamp(opening, 0.1 * room.vav_damper[vav], 1.0);
}

void RcPlant::update_airflow() {
  const RcRoom& room = *room_;
  double flow_w_k = 0;
  for (std::size_t v = 0; v < vav_w_k_.size(); ++v) {
    const double w_k = damper(v) * room.vav_flow_m3_s[v] * room.vav_flow_calibration[v] * RcNetwork::air_j_m3k;
    flow_w_k += w_k;
    vav_w_k_[v] = w_k * (1 - room.duct_leak_share);
  }
  ahu_w_k_ = flow_w_k;
}

/// The AHU: return air and its share of make-up air, warmed by the fan, then the coil; no heating.
void RcPlant::cool_supply() {
  if (ahu_w_k_ <= 1) return;
  const RcRoom& room = *room_;
  const RcNetwork& network = *network_;
  const std::size_t vavs = vav_w_k_.size();
  double returned = 0;
  for (std::size_t v = 0; v < vavs; ++v) returned += vav_w_k_[v] * air_degc_[v];
  returned /= ahu_w_k_ * (1 - room.duct_leak_share);
  for (std::size_t v = 0; v < vavs && room.plenum_gain_share > 0; ++v)
    returned += room.plenum_gain_share * disturbance_.gain_w[v] / ahu_w_k_;
  const double oa_w_k = std::min(ahu_w_k_, room.outdoor_air_m3_s * (1 - room.mau_room_share) * RcNetwork::air_j_m3k);
  const double mixed =
      returned + oa_w_k / ahu_w_k_ * (mau_degc_ - returned) + 1000 * fan_kw_ * room.fan_heat_share / ahu_w_k_;
  const double flow_m3_s = ahu_w_k_ / RcNetwork::air_j_m3k;
  const double wet_g_kg = std::max(0.0, 0.75 * (15.5 - supply_degc_));  // below the room's dew point the coil drips
  const double latent_kw = room.coil_latent_w_per_gkg_m3s * wet_g_kg * flow_m3_s / 1000;
  const double sensible_kw = std::max(0.1, room.coil_capacity_kw * (1 - room.coil_fouling) - latent_kw);
  const double coldest =
      std::max(room.chilled_water_degc + room.coil_approach_k + water_k_, mixed - 1000 * sensible_kw / ahu_w_k_);
  const double wanted = setpoint_degc_ - room.supply_sensor_offset_k;
  const double target = std::min(std::max(wanted, coldest), mixed);
  supply_degc_ += network.supply_share * (target - supply_degc_);
  coil_load_kw_ += (std::max(0.0, ahu_w_k_ * (mixed - supply_degc_) / 1000) + latent_kw) / network.inner_steps;
}

/// The sun on windows and walls, which is constant over a step.
void RcPlant::update_sun() {
  for (std::size_t z = 0; z < network_->zones.size(); ++z) {
    const RcNetwork::Zone& zone = network_->zones[z];
    double wall_sun_w_m2 = sun_w_[z] = 0;
    for (std::size_t f = 0; f < facades; ++f) {
      sun_w_[z] += zone.window_m2_shgc[f] * disturbance_.facade_w_m2[f];
      wall_sun_w_m2 += zone.wall_m2_share[f] * disturbance_.facade_w_m2[f];
    }
    sol_air_k_[z] = zone.wall_sun_k_m2_w * wall_sun_w_m2;
  }
}

/// Flows between zones.
void RcPlant::mix_zones() {
  std::fill(flux_w_.begin(), flux_w_.end(), 0.0);
  for (const auto& link : network_->links) {
    const double w = link.w_k * (air_degc_[link.b] - air_degc_[link.a]);
    flux_w_[link.a] += w;
    flux_w_[link.b] -= w;
  }
}

void RcPlant::inner_step() {
  const RcRoom& room = *room_;
  const RcNetwork& network = *network_;
  const std::size_t zones = air_degc_.size(), vavs = vav_w_k_.size();
  const WeatherRecord& weather = disturbance_.weather;
  const double outdoor = weather.outdoor_temp_degc, to_kj = network.dt_s / 1000;
  double stored_j = 0;

  cool_supply();
  duct_degc_ += network.duct_share * (supply_degc_ - duct_degc_);
  const double blown_degc = duct_degc_ + room.duct_gain_k;

  mix_zones();
  for (std::size_t z = 0; z < zones; ++z) {
    const RcNetwork::Zone& zone = network.zones[z];
    const double air = air_degc_[z];
    const double ach = room.infiltration_ach + room.infiltration_wind_ach_s_m * std::min(30.0, weather.wind_speed_m_s) +
                       room.infiltration_stack_ach_k * std::min(40.0, std::fabs(outdoor - air));
    const double plenum_share = z < vavs && ahu_w_k_ > 1 ? room.plenum_gain_share : 0;
    const double gain_w = disturbance_.gain_w[z] * (1 - plenum_share);
    const double heat_w = heat_w_.empty() ? 0 : heat_w_[z];
    const double mass_w = zone.mass_w_k * (mass_degc_[z] - air);
    const double wall_w = zone.wall_w_k * (wall_degc_[z] - air);
    const double door_w_k = disturbance_.door_ach.empty() ? 0 : zone.door_w_k_ach * disturbance_.door_ach[z];
    const double out_w = (zone.window_w_k + zone.infiltration_w_k_ach * ach + door_w_k) * (outdoor - air);
    const double neighbour_w = zone.neighbour_w_k * (room.neighbour_temp_degc - air);
    const double mau_w = zone.mau_w_k * (mau_degc_ - air);
    const double radiant_w = room.gain_radiant_share * gain_w + room.solar_to_mass_share * sun_w_[z];
    wall_sun_k_[z] = network.wall_sun_share < 1
                         ? wall_sun_k_[z] + network.wall_sun_share * (sol_air_k_[z] - wall_sun_k_[z])
                         : sol_air_k_[z];
    const double skin_degc = outdoor + wall_sun_k_[z] - room.rain_wall_drop_k * weather.rain;
    const double skin_w = zone.wall_w_k * (skin_degc - wall_degc_[z]);
    double cooled_w = 0;
    if (z < vavs) {
      cooled_w = vav_w_k_[z] * (blown_degc - air);
      energy_.vav_kj += cooled_w * to_kj;
    } else {
      const std::size_t f = z - vavs;
      const double runs = room.fcu_forced[f] > 0 ? 1 : room.fcu_forced[f] < 0 ? 0 : fcu_on_[f];
      fcu_cold_[f] = network.fcu_coil_share < 1 ? fcu_cold_[f] + network.fcu_coil_share * (runs - fcu_cold_[f]) : runs;
      cooled_w = -fcu_cold_[f] * room.fcu_flow_m3_s[f] * room.fcu_capacity_factor[f] * RcNetwork::air_j_m3k *
                 std::max(0.0, air - (room.fcu_supply_degc + water_k_));
      fcu_duty_[f] += runs / network.inner_steps;
      fcu_load_kw_ -= cooled_w / 1000 / network.inner_steps;
      energy_.fcu_kj += cooled_w * to_kj;
    }
    energy_.gains_kj += (gain_w + heat_w) * to_kj;
    energy_.solar_kj += sun_w_[z] * to_kj;
    energy_.outdoors_kj += (out_w + skin_w) * to_kj;
    energy_.neighbour_kj += neighbour_w * to_kj;
    energy_.mau_kj += mau_w * to_kj;

    const double air_k = zone.air_k_w * (flux_w_[z] + mass_w + wall_w + out_w + neighbour_w + mau_w + cooled_w +
                                         gain_w + heat_w + sun_w_[z] - radiant_w);
    const double deep_w = zone.deep_w_k * (deep_degc_[z] - mass_degc_[z]);
    const double mass_k = zone.mass_k_w * (radiant_w - mass_w + deep_w);
    const double deep_k = -zone.deep_k_w * deep_w;
    const double wall_k = zone.wall_k_w * (skin_w - wall_w);
    air_degc_[z] += air_k;
    mass_degc_[z] += mass_k;
    wall_degc_[z] += wall_k;
    deep_degc_[z] += deep_k;
    stored_j += air_k * zone.air_j_k + mass_k * zone.mass_j_k + wall_k * zone.wall_j_k + deep_k * zone.deep_j_k;
    const double felt =
        z < vavs ? air_degc_[z] + room.room_sensor_jet_share[z] * (blown_degc - air_degc_[z]) : air_degc_[z];
    sensed_degc_[z] += network.sensor_share * (felt - sensed_degc_[z]);
  }
  energy_.stored_kj += stored_j / 1000;
}

void RcPlant::update_power() {
  const RcRoom& room = *room_;
  double nominal_w_k = 0;
  for (std::size_t v = 0; v < vav_w_k_.size(); ++v)
    nominal_w_k += room.vav_flow_m3_s[v] * room.vav_damper[v] * RcNetwork::air_j_m3k;
  const double load = nominal_w_k > 0 ? ahu_w_k_ / nominal_w_k : 0;
  fan_kw_ = room.ahu_fan_kw * load * load;
  const double fcu_fans_kw = room.fcu_fan_kw * std::accumulate(fcu_duty_.begin(), fcu_duty_.end(), 0.0);
  const double warm_water = 1 + 0.03 * water_k_;  // a chiller likes warm water, 3 % a K
  const double cop = warm_water * std::max(1.0, room.chiller_cop + room.chiller_cop_per_k *
                                                                       (disturbance_.weather.outdoor_temp_degc - 30));
  const double cooling_kw = coil_load_kw_ + mau_load_kw_ + fcu_load_kw_;
  const double part_load = 1 + room.chiller_part_load_loss * std::max(0.0, 1 - cooling_kw / room.chiller_full_load_kw);
  chiller_kw_ = std::max(cooling_kw, room.chiller_min_load_kw) / cop * part_load + room.pump_kw;
  sensors_.power_kw.resize(static_cast<std::size_t>(room.powers));
  const double fans_kw = fan_kw_ + fcu_fans_kw + room.mau_fan_kw;
  if (room.powers == 0) return;
  sensors_.power_kw[0] = room.powers == 1 ? fans_kw + chiller_kw_ : room.powers == 2 ? fans_kw : fan_kw_;
  if (room.powers == 2) sensors_.power_kw[1] = chiller_kw_;
  if (room.powers <= 2) return;
  sensors_.power_kw[1] = fans_kw - fan_kw_;
  const auto circuits = sensors_.power_kw.begin() + 2;
  std::fill(circuits, sensors_.power_kw.end(), chiller_kw_ / (room.powers - 2));
}

double RcPlant::shown_temp_degc(std::size_t vav) const {
  const double days = static_cast<double>(now_.seconds - start_.seconds) / 86400;
  return sensed_degc_[static_cast<std::size_t>(room_->room_sensor_zone[vav]) - 1] + room_->room_sensor_bias_k[vav] +
         room_->room_sensor_drift_k_per_day[vav] * days;
}

void RcPlant::read_sensors() {
  const RcRoom& room = *room_;
  const std::int64_t slot = now_.seconds / step_s;
  const auto shown = [this](double value) { return exact_ ? value : rounded(value); };
  const auto noise = [&](double sd, std::uint64_t stream, std::size_t place) {
    return sd == 0 ? 0.0 : sd * draw_normal(seed_, stream, place, slot);
  };
  sensors_.room_temp_degc.resize(vav_w_k_.size());
  for (std::size_t v = 0; v < vav_w_k_.size(); ++v) {
    sensors_.room_temp_degc[v] = shown(shown_temp_degc(v) + noise(room.temp_noise_sd_k, noise_room, v));
  }
  sensors_.fcu_temp_degc.resize(fcu_on_.size());
  for (std::size_t f = 0; f < fcu_on_.size(); ++f) {
    sensors_.fcu_temp_degc[f] = shown(sensed_degc_[vav_w_k_.size() + f] + room.fcu_sensor_bias_k[f] +
                                      noise(room.temp_noise_sd_k, noise_fcu, f));
  }
  sensors_.vav_on = disturbance_.vav_on;
  sensors_.ahu_on = ahu_rests() ? 0 : 1;
  sensors_.fcu_on = fcu_on_;
  for (std::size_t p = 0; p < sensors_.power_kw.size(); ++p) {
    sensors_.power_kw[p] =
        shown(std::max(0.0, sensors_.power_kw[p] * (1 + noise(room.power_noise_share, noise_power, p))));
  }
  sensors_.mau_temp_degc = shown(mau_degc_ + noise(room.temp_noise_sd_k, noise_mau, 0));
  sensors_.outdoor_temp_degc = shown(disturbance_.weather.outdoor_temp_degc + room.outdoor_sensor_bias_k +
                                     noise(room.temp_noise_sd_k, noise_outdoor, 0));
  sensors_.rain = disturbance_.weather.rain;
  sensors_.supply_temp_degc =
      shown(supply_degc_ + room.supply_sensor_offset_k + noise(room.temp_noise_sd_k, noise_supply, 0));
  sensors_.setpoint_degc = setpoint_degc_;
}

void RcPlant::step() {
  coil_load_kw_ = fcu_load_kw_ = 0;
  update_sun();
  std::fill(fcu_duty_.begin(), fcu_duty_.end(), 0.0);
  for (int i = 0; i < network_->inner_steps; ++i) {
    if (i > 0) {
      update_thermostats();
      obey_commands();
    }
    inner_step();
  }
  now_.seconds += step_s;
  update_disturbance();
  if (recording_) obey_recording();
  update_thermostats();
  obey_commands();
  update_airflow();
  update_power();
}

void RcPlant::advance_to(CivilTime t) {
  const std::int64_t ahead = t.seconds - now_.seconds;
  if (ahead < 0 || ahead % step_s != 0) {
    throw std::invalid_argument("RcPlant at " + text_of(now_) + " cannot advance by " + std::to_string(ahead) +
                                " s; it moves forward in steps of 180 s");
  }
  while (now_ < t) {
    step();
    read_sensors();
  }
}

void RcPlant::set_setpoint(double setpoint_degc) {
  if (!std::isfinite(setpoint_degc))
    throw std::invalid_argument("RcPlant: the setpoint must be a finite number of degC");
  setpoint_degc_ = setpoint_degc;
  sensors_.setpoint_degc = setpoint_degc;
}

double RcPlant::mean_room_temp_degc() const {
  double sum = 0;
  for (std::size_t v = 0; v < vav_w_k_.size(); ++v) sum += air_degc_[v];
  return sum / static_cast<double>(vav_w_k_.size());
}

double RcPlant::mean_shown_temp_degc() const {
  double sum = 0;
  for (std::size_t v = 0; v < vav_w_k_.size(); ++v) sum += shown_temp_degc(v);
  return sum / static_cast<double>(vav_w_k_.size());
}

std::string RcPlant::description() const {
  return "RC room " + room_->name + " (" + std::to_string(room_->vavs) + " VAV, " + std::to_string(room_->fcus) +
         " FCU), seed " + std::to_string(seed_in_room(*room_, seed_)) + ", weather " + weather_->description();
}

}  // namespace airside::sim
