#pragma once
// A fan that cycles at night to cool: what was left in the rooms in the evening is cooled at night.

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include "airside/civil_time.hpp"
#include "airside/demand/demand_reading.hpp"
#include "airside/demand/zone_loads.hpp"
#include "airside/demand/zone_signals.hpp"

namespace airside {

/// Remembers when the fan last cooled rooms that were set back: it started from rest with a zone near its setpoint and
/// outdoor air that cools little, and rested again before the setback ended.
/// Cost: one look at each zone a row. Plain bytes.  Source: docs/method.md 17.5.
class NightCooling {
 public:
  /// A row, those at rest included.
  void watch(const ZoneLoads& loads, const DemandReading& at) {
    if (std::isfinite(at.outdoor_degc)) {
      coldest_degc_ = std::min(coldest_degc_ + forget_k, static_cast<float>(at.outdoor_degc));
    }
    std::size_t seen = 0, back = 0, warm = 0;
    for (std::size_t i = 0; i < std::min(at.zones.count(), max_zones); ++i) {
      if (!zone_is_seen(at.zones, i)) continue;
      ++seen;
      back += loads.is_set_back(i, at.zones.setpoint_degc[i]) ? 1u : 0u;
      const double temp_degc = at.zones.temp_degc[i];
      const bool full = temp_degc > at.zones.setpoint_degc[i] - near_k;
      warm += full && at.outdoor_degc > temp_degc - colder_outdoors_k ? 1u : 0u;
    }
    if (2 * back <= seen) {
      phase_ = not_set_back;
    } else if (!at.flows && !at.doubted) {
      if (phase_ == cools) seen_at_s_ = at.time.seconds;
      phase_ = rests;
    } else if (phase_ == rests) {
      phase_ = warm > 0 ? cools : runs;
    } else if (phase_ == not_set_back) {
      phase_ = runs;
    }
  }

  /// Whether most zones are set back, on a night like those in which the fan cycled to cool.
  bool expects(CivilTime t) const { return phase_ != not_set_back && is_remembered(t); }

  /// How far outdoor air cools rooms for nothing at some time of the day, nights included, by the coldest that it was
  /// of late: not at all where that was no colder than the room, in full where it was 4 K colder.  0..1.
  double free_cooling_share(double room_degc) const {
    return std::clamp((room_degc - coldest_outdoors_degc()) / colder_outdoors_k, 0.0, 1.0);
  }

  /// No night of late was 4 K colder than the rooms: little but the plant cools them.
  bool is_hot(double room_degc) const { return free_cooling_share(room_degc) < 1; }
  double coldest_outdoors_degc() const { return static_cast<double>(coldest_degc_); }

  /// Which share of the heat that warmer air leaves in the rooms is cooled out later: none where the fan did not cycle
  /// for that of late; else all where it is hot, and none where outdoor air is colder than the rooms.  0..1.
  double stored_heat_share(CivilTime t, double outdoor_degc, double room_degc) const {
    if (!is_remembered(t)) return 0;
    return is_hot(room_degc) ? 1.0 : std::clamp((outdoor_degc - room_degc) / hot_k, 0.0, 1.0);
  }

 private:
  static constexpr double near_k = 2.5, colder_outdoors_k = 4.0, hot_k = 8.0;
  static constexpr float forget_k = 2.0F / static_cast<float>(rows_per_day);
  static constexpr std::int64_t remembered_s = 48 * 3600, never = -1'000'000'000'000;
  bool is_remembered(CivilTime t) const {
    const std::int64_t since_s = t.seconds - seen_at_s_;
    return since_s >= 0 && since_s <= remembered_s;
  }

  enum Phase : std::int32_t { not_set_back, rests, cools, runs };

  std::int64_t seen_at_s_ = never;
  Phase phase_ = not_set_back;
  float coldest_degc_ = 100;  ///< lowest outdoor temperature; forgotten by 2 K a day
};

}  // namespace airside
