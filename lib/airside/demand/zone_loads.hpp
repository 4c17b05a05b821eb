#pragma once
// What each zone asks of the supply air: its load as damper times temperature difference, learned from how the zone's
// temperature answers, and the damper that this load needs at another supply temperature.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "airside/civil_time.hpp"
#include "airside/demand/recursive_least_squares.hpp"
#include "airside/demand/zone_signals.hpp"
#include "airside/demand_settings.hpp"

namespace airside {

/// The damper that a zone needs at a supply temperature, and what its temperature does if that is out of reach.
struct ZoneForecast {
  double wanted = 0;    ///< damper wanted, may exceed 1
  double damper = 0;    ///< damper reached
  double excess_k = 0;  ///< of the zone's temperature over its band after a cycle
  double short_k = 0;   ///< what a zone that is below its band by now would lack after s.recover_cycles
};

/// dT = c - b u,  u = damper (T - T_supply); load q = c / b: the u that holds the temperature.
/// b walks slowly, c as fast as people come. Shape: max_zones, the first n in use. Units: K, damper 0..1, u and q in K.
/// Cost: one update of two coefficients a zone and cycle. Plain bytes.  Source: docs/method.md 17.2.
class ZoneLoads {
 public:
  void reset(const DemandSettings& s) {
    for (Zone& zone : zones_) {
      zone = {};
      zone.model.reset({s.cooling_gain_prior, 0.0}, {0.5 * s.cooling_gain_prior, 3.0});
    }
    profile_.fill(0);
    setpoint_profile_.fill(0);
  }

  /// Learns from a cycle that began at t: mean u of zone i over it, and how far the zone's temperature moved.
  void update(const DemandSettings& s, std::size_t i, double mean_u_k, double moved_k) {
    Zone& zone = zones_[i];
    if (!std::isfinite(mean_u_k) || !std::isfinite(moved_k)) return;
    if (zone.seen == 0)
      zone.model.reset({s.cooling_gain_prior, s.cooling_gain_prior * mean_u_k}, {0.3 * s.cooling_gain_prior, 0.5});
    zone.seen = 1;
    zone.model.forget(0.05);
    zone.model.update({-mean_u_k, 1.0}, moved_k, 0.1);
    zone.model.bound(0, 0.3 * s.cooling_gain_prior, 4 * s.cooling_gain_prior);
    const double b = zone.model.theta()[0];
    zone.load_k = std::clamp(zone.model.theta()[1] / b, 0.0, std::max(0.0, mean_u_k + credited_rise_k / b));
  }

  /// Remembers how the day's loads go: the mean load of a time of day. Loads of a day off, on which zones are set back
  /// and the fan cycles, say nothing of working days.
  void note_profile(CivilTime t, std::size_t count, double mean_setpoint_degc, bool set_back) {
    if (mean_setpoint_degc > 0) setpoint_profile_[static_cast<std::size_t>(profile_slot_of(t))] = mean_setpoint_degc;
    if (set_back) return;
    double& slot = profile_[static_cast<std::size_t>(profile_slot_of(t))];
    const double now = mean_load_k(count);
    if (now > 0) slot += (slot > 0 ? 0.3 : 1.0) * (now - slot);
  }

  /// By which factor loads use to change from the cycle at t to the next; 1 where the day is not known yet.
  double growth(CivilTime t) const {
    const double now = profile_[static_cast<std::size_t>(profile_slot_of(t))];
    const double next = profile_[static_cast<std::size_t>((profile_slot_of(t) + 1) % profile_slots)];
    return now > 0 && next > 0 ? std::clamp(next / now, 0.8, 1.25) : 1.0;
  }

  /// The setpoint that zone i is expected to get where the mean of all is to fall: not lower than it ever was, since a
  /// zone that is not set back keeps its own.  Units: degC; fall_k <= 0.
  double expected_setpoint_degc(std::size_t i, double setpoint_degc, double fall_k) const {
    return std::min(setpoint_degc, std::max(zones_[i].least_setpoint_degc, setpoint_degc + fall_k));
  }

  /// By how much zone setpoints fell yesterday within the cycles to come, K, <= 0: rooms are to be ready, and a box
  /// whose setpoint falls opens at once.
  double setpoint_fall_k(CivilTime t, double mean_setpoint_degc) const {
    double lowest = 0;
    for (int ahead = 1; ahead <= 5; ++ahead) {
      const double then = setpoint_profile_[static_cast<std::size_t>((profile_slot_of(t) + ahead) % profile_slots)];
      if (then > 0) lowest = std::min(lowest, then - mean_setpoint_degc);
    }
    return lowest;
  }

  /// The smallest opening that a damper keeps while air flows; a box that no longer shuts so far is noticed in days.
  void note_damper(std::size_t i, double damper) {
    double& least = zones_[i].least_damper;
    if (damper > 0.01) least = std::min(least + 0.0005, damper < least ? damper : least + 0.0005);
  }

  /// The lowest setpoint that a zone is given: in setback the cooling setpoint lies far above, and the heating one,
  /// which no point shows, far below.
  void note_setpoint(std::size_t i, double setpoint_degc) {
    double& least = zones_[i].least_setpoint_degc;
    least = std::min(least + 0.0005, setpoint_degc);
  }
  /// A zone that stays too warm with its damper open while the coldest air is blown is out of reach: a jammed damper, a
  /// sensor in the sun. What it asks for counts half after four such hours, and in full again after a day without.
  void note_reach(const DemandSettings& s, const ZoneSignals& zones, std::size_t i, bool coldest) {
    double& weight = zones_[i].weight;
    const bool helpless = coldest && zones.damper[i] > 0.95 && zones.temp_degc[i] > zones.setpoint_degc[i] + s.band_k;
    weight = helpless ? weight * 0.983 : std::min(1.0, weight + 1.0 / rows_per_day);
  }
  double weight(std::size_t i) const { return zones_[i].weight; }

  /// The same for a zone that stays too cold while the warmest air is blown: a reheat valve that is shut for good.
  void note_cold_reach(const DemandSettings& s, const ZoneSignals& zones, std::size_t i, bool warmest) {
    double& weight = zones_[i].cold_weight;
    const bool helpless = warmest && zones.temp_degc[i] < zone_heating_degc(zones, i) - s.band_k;
    weight = helpless ? weight * 0.983 : std::min(1.0, weight + 1.0 / rows_per_day);
  }
  double cold_weight(std::size_t i) const { return zones_[i].cold_weight; }

  /// The highest heating setpoint that a zone is given while it is not set back; a wrong one is forgotten by 1.2 K in a
  /// day of running fan.
  void note_heating(std::size_t i, double heating_degc, double setpoint_degc) {
    double& most = zones_[i].most_heating_degc;
    if (std::isfinite(heating_degc) && !is_set_back(i, setpoint_degc)) most = std::max(most - 0.005, heating_degc);
  }

  /// What a row shows of zone i.  `coldest`, `warmest`: the setpoint applied is the lowest, the highest one.
  void note_row(const DemandSettings& s, const ZoneSignals& zones, std::size_t i, bool coldest, bool warmest) {
    note_damper(i, zones.damper[i]);
    note_setpoint(i, zones.setpoint_degc[i]);
    note_reach(s, zones, i, coldest);
    note_heating(i, zone_heating_degc(zones, i), zones.setpoint_degc[i]);
    note_cold_reach(s, zones, i, warmest);
  }

  bool is_set_back(std::size_t i, double setpoint_degc) const {
    return setpoint_degc > zones_[i].least_setpoint_degc + 1.0;
  }
  /// The lowest temperature at which a zone has been standing still with its damper at its least: there it heats, or
  /// nowhere. Forgotten by 0.7 K a day of running fan, since seasons and thermostats change.
  void note_held(std::size_t i, double room_degc, double moved_k, double damper, double setpoint_degc) {
    Zone& zone = zones_[i];
    if (!std::isfinite(moved_k) || is_set_back(i, setpoint_degc)) return;
    zone.held_degc += 0.7 / band_cycle.per_day();
    const bool held = std::abs(moved_k) < 0.1 && damper < zone.least_damper + 0.02;
    if (held) zone.held_degc = std::min(zone.held_degc, room_degc);
  }

  /// How near zone i is to where it heats: by its heating setpoint where a point shows it, else some 3 K below where it
  /// cools, and where it was seen to be held. In setback as well: a zone that is cooled that far in the evening is
  /// heated in the morning.  0..1.
  double heating_share(std::size_t i, double room_degc, double setpoint_degc) const {
    const double heats = zones_[i].most_heating_degc;
    if (heats > 0) return std::clamp((heats + 0.4 - room_degc) / 0.3, 0.0, 1.0);
    const double cools = std::min({setpoint_degc, zones_[i].least_setpoint_degc, warmest_cooling_degc});
    const double held = std::clamp((zones_[i].held_degc + 0.4 - room_degc) / 0.3, 0.0, 1.0);
    return std::clamp(cools - 1.5 - room_degc, 0.0, 1.0) * held;
  }

  /// The load of a zone that floats, after a cycle that began with the zone so near to where it heats: what it has
  /// without heat. In a heated zone the load holds the heat as well, so the last one seen is kept, and believed less.
  void note_free_load(std::size_t i, double heating_share) {
    Zone& zone = zones_[i];
    if (heating_share < 0.5) {
      zone.free_load_k += zone.has_free_load != 0 ? 0.5 * (zone.load_k - zone.free_load_k) : zone.load_k;
      zone.has_free_load = 1;
      zone.unheated_cycles = std::min(zone.unheated_cycles + 1, remembered_cycles);
    } else {
      zone.free_load_k *= forget_free_load;
      zone.unheated_cycles = 0;
    }
  }

  /// When zone i was last near where it heats.  1: now; 0: not in three days of running fan.
  double heats_of_late(std::size_t i) const {
    return 1 - static_cast<double>(zones_[i].unheated_cycles) / remembered_cycles;
  }

  /// Heat that zone i takes at `supply_degc` with its damper at d, in units of its open box, K:
  ///   max(cools, heats_of_late) (d (T_heat - A) - q_free)+  where a point shows T_heat,
  /// else d (T - A) as far as it is near where it heats.  `cools`: NightCooling::free_cooling_share().
  double heat_k(const ZoneSignals& zones, std::size_t i, double supply_degc, double damper, double cools) const {
    const double room = zones.temp_degc[i], heats_to = zones_[i].most_heating_degc;
    const double share = heating_share(i, room, zones.setpoint_degc[i]);
    const double all = share * damper * (room - supply_degc);
    if (!(heats_to > 0) || zones_[i].has_free_load == 0) return all;
    const double free_k = share < 0.5 ? zones_[i].load_k : zones_[i].free_load_k;
    const double taken_k = std::max(0.0, damper * (heats_to - supply_degc) - std::max(0.0, free_k));
    return std::max(cools, heats_of_late(i)) * taken_k;
  }

  bool is_known(std::size_t i) const { return zones_[i].seen != 0; }
  double load_k(std::size_t i) const { return zones_[i].load_k; }
  double gain(std::size_t i) const { return zones_[i].model.theta()[0]; }
  double least_damper(std::size_t i) const { return std::min(zones_[i].least_damper, 1.0); }

  /// What zone i does at `supply_degc` when its load is `factor` times the present one.
  ///   wanted = (q + (T - T_set)+ / (b n)) / (T_ref - T_supply),  T_ref = min(T, T_set);  0 while minimum flow suffices
  ZoneForecast forecast(const DemandSettings& s, const ZoneSignals& zones, std::size_t i, double supply_degc,
                        double factor, double fall_k) const {
    const double room = zones.temp_degc[i], set = expected_setpoint_degc(i, zones.setpoint_degc[i], fall_k);
    const double b = gain(i), q = load_k(i) * factor;
    const double least = least_damper(i);
    const double warm_k = std::max(0.0, room - set);
    const double difference = std::max(1.0, std::min(room, set) - supply_degc);
    const bool stays_below = room + b * (q - least * (room - supply_degc)) < set;
    ZoneForecast f;
    f.wanted = stays_below ? 0.0 : (q + warm_k / (b * s.recover_cycles)) / difference;
    f.damper = std::clamp(f.wanted, least, 1.0);
    const double next = room + b * (q - f.damper * (room - supply_degc));
    f.excess_k = f.wanted > 1 ? std::max(0.0, next - set - s.band_k) : 0.0;
    const double cold_degc = zone_heating_degc(zones, i) - s.band_k;
    const double falls_k = b * f.damper * (room - supply_degc) - zones_[i].model.theta()[1];
    const double colder = room - s.recover_cycles * falls_k;
    f.short_k = room < cold_degc ? std::max(0.0, cold_degc - colder) : 0.0;
    return f;
  }

 private:
  static constexpr double warmest_cooling_degc = 25;  ///< a room that is cooled at 30 is not heated at 27
  static constexpr double forget_free_load = 0.92;    ///< a cycle: half in two and a half hours
  static constexpr double credited_rise_k = 0.3;      ///< in a cycle; a zone that rises faster is warming up
  static constexpr std::int32_t remembered_cycles = 3 * band_cycle.per_day();

  struct Zone {
    RecursiveLeastSquares<2> model;
    double load_k = 0;
    double least_damper = 1.0;
    double least_setpoint_degc = 100.0;
    double weight = 1.0, cold_weight = 1.0;
    double most_heating_degc = 0;  ///< 0: no point shows it
    double free_load_k = 0;        ///< see note_free_load()
    std::int32_t has_free_load = 0;
    std::int32_t unheated_cycles = 0;  ///< since it was last near where it heats, at most remembered_cycles
    double held_degc = 100.0;          ///< see note_held()
    std::int64_t seen = 0;
  };

  double mean_load_k(std::size_t count) const {
    double sum = 0;
    int known = 0;
    for (std::size_t i = 0; i < std::min(count, max_zones); ++i) {
      if (zones_[i].seen != 0) sum += zones_[i].load_k, ++known;
    }
    return known > 0 ? sum / known : 0.0;
  }

  std::array<Zone, max_zones> zones_{};
  std::array<double, profile_slots> profile_{};           ///< mean load, K
  std::array<double, profile_slots> setpoint_profile_{};  ///< mean zone setpoint, degC
};

}  // namespace airside
