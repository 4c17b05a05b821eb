#include "sim/energyplus/rooms.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace airside::sim {
namespace {

constexpr std::uint64_t purpose_occupancy = 1, purpose_vav = 2, purpose_floor = 3;
constexpr double noise_memory_s = 2400;  // of the minute-to-minute occupancy

struct Knot {
  double minute, fraction;
};
constexpr std::array<Knot, 12> office_day = {{{0, 0.08},
                                              {390, 0.08},
                                              {450, 0.35},
                                              {540, 0.95},
                                              {690, 1.00},
                                              {735, 0.80},
                                              {795, 0.85},
                                              {840, 1.00},
                                              {1020, 0.95},
                                              {1110, 0.50},
                                              {1200, 0.12},
                                              {1440, 0.08}}};

/// Standard normal, by the sum of twelve uniforms: no libm, the same bits on every machine.
double normal(SplitMix64& stream) {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += stream.uniform();
  return sum;
}

}  // namespace

double office_profile(double minute_of_day) {
  const double minute = std::clamp(minute_of_day, 0.0, 1440.0);
  for (std::size_t i = 1; i < office_day.size(); ++i) {
    if (minute > office_day[i].minute) continue;
    const Knot& a = office_day[i - 1];
    const Knot& b = office_day[i];
    return a.fraction + (b.fraction - a.fraction) * (minute - a.minute) / (b.minute - a.minute);
  }
  return office_day.back().fraction;
}

RoomLoops::RoomLoops(const RoomLoopOptions& options, int vavs, int fcus, std::uint64_t seed, double setpoint_degc)
    : options_(options),
      vavs_(vavs),
      seed_(seed),
      sensor_stream_(SplitMix64(seed ^ 0x5E4503u).next()),
      occupancy_stream_(SplitMix64(seed ^ 0x0CC09u).next()),
      occupancy_noise_(static_cast<std::size_t>(vavs + fcus), 0.0),
      lagged_setpoint_degc_(setpoint_degc) {
  commands_.supply_setpoint_degc = setpoint_degc;
  commands_.vav_on.assign(static_cast<std::size_t>(vavs), 1.0);
  commands_.fcu_on.assign(static_cast<std::size_t>(fcus), 0.0);
  commands_.occupancy.assign(static_cast<std::size_t>(vavs + fcus), 0.0);
}

SplitMix64 RoomLoops::day_stream(std::int64_t day, int zone, std::uint64_t purpose) const {
  SplitMix64 mixed(seed_);
  std::uint64_t key = mixed.next() ^ static_cast<std::uint64_t>(day) * 0x100000001B3u;
  key = SplitMix64(key ^ purpose << 32).next() ^ static_cast<std::uint64_t>(zone + 1);
  return SplitMix64(SplitMix64(key).next());
}

double RoomLoops::profile(CivilTime t, int zone) const {
  SplitMix64 floor_day = day_stream(t.day(), 0, purpose_floor);
  SplitMix64 zone_day = day_stream(t.day(), zone, purpose_occupancy);
  const double noise = options_.occupancy_noise;
  const double floor_level = 1.0 + 0.06 * noise * std::clamp(normal(floor_day), -2.5, 2.5);
  const double floor_shift_min = 10.0 * noise * floor_day.symmetric();
  const double level = 1.0 + 0.08 * noise * std::clamp(normal(zone_day), -2.5, 2.5);
  const double shift_min = 12.0 * noise * zone_day.symmetric();
  const double minute = t.minute_of_day() - options_.occupancy_shift_min - floor_shift_min - shift_min;
  double fraction = office_profile(minute) * level * floor_level;
  if (options_.weekends && t.weekday() >= 5) fraction = 0.08;
  return fraction;
}

bool RoomLoops::vav_out(CivilTime t, int vav) const {
  SplitMix64 day = day_stream(t.day(), vav, purpose_vav);
  if (day.uniform() >= options_.vav_off_per_day) return false;
  const double from_min = 480.0 + 540.0 * day.uniform();
  const double minutes = 36.0 + 54.0 * day.uniform();
  const double now_min = t.minute_of_day();
  return now_min >= from_min && now_min < from_min + minutes;
}

bool RoomLoops::fcu_wanted(CivilTime t, double temp_degc, bool on) const {
  const int minute = t.minute_of_day();
  if (minute < options_.fcu_from_hour * 60 || minute >= options_.fcu_to_hour * 60) return false;
  return on ? temp_degc >= options_.fcu_setpoint_degc - options_.fcu_band_k
            : temp_degc > options_.fcu_setpoint_degc + options_.fcu_band_k;
}

const RoomCommands& RoomLoops::step(CivilTime t, int step_s, double setpoint_degc,
                                    const std::vector<double>& fcu_temps_degc) {
  lagged_setpoint_degc_ =
      setpoint_degc + (lagged_setpoint_degc_ - setpoint_degc) *
                          (options_.supply_lag_s > 0 ? std::exp(-step_s / options_.supply_lag_s) : 0.0);
  commands_.supply_setpoint_degc = lagged_setpoint_degc_ + options_.supply_bias_k;
  for (int i = 0; i < vavs_; ++i) commands_.vav_on[static_cast<std::size_t>(i)] = vav_out(t, i) ? 0.0 : 1.0;
  for (std::size_t i = 0; i < commands_.fcu_on.size(); ++i)
    commands_.fcu_on[i] = fcu_wanted(t, fcu_temps_degc[i], commands_.fcu_on[i] > 0.5) ? 1.0 : 0.0;
  for (const SwitchedFanCoil& by_hand : options_.switched) {
    if (t.seconds >= by_hand.from_s && t.seconds < by_hand.to_s)
      commands_.fcu_on.at(static_cast<std::size_t>(by_hand.fcu)) = by_hand.on ? 1.0 : 0.0;
  }

  const double keep = std::exp(-step_s / noise_memory_s);
  const double draw = 0.05 * options_.occupancy_noise * std::sqrt(1.0 - keep * keep);
  for (std::size_t z = 0; z < occupancy_noise_.size(); ++z) {
    occupancy_noise_[z] = keep * occupancy_noise_[z] + draw * normal(occupancy_stream_);
    const double fraction = profile(t, static_cast<int>(z));
    commands_.occupancy[z] = std::clamp(options_.occupancy_scale * fraction * (1.0 + occupancy_noise_[z]), 0.0, 2.0);
  }
  return commands_;
}

RoomCommands RoomLoops::warm_up(CivilTime t, double setpoint_degc, const std::vector<double>& fcu_temps_degc) const {
  RoomCommands commands = commands_;
  commands.supply_setpoint_degc = setpoint_degc + options_.supply_bias_k;
  for (std::size_t i = 0; i < commands.fcu_on.size(); ++i)
    commands.fcu_on[i] = fcu_wanted(t, fcu_temps_degc[i], true) ? 1.0 : 0.0;
  for (std::size_t z = 0; z < commands.occupancy.size(); ++z)
    commands.occupancy[z] = options_.occupancy_scale * profile(t, static_cast<int>(z));
  return commands;
}

double RoomLoops::sensed_degc(double true_degc) {
  return std::round((true_degc + options_.sensor_noise_k * normal(sensor_stream_)) * 100.0) / 100.0;
}

}  // namespace airside::sim
