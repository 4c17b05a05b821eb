#pragma once
// The objective "band": least electric energy such that every zone stays in its band and no box stays open. Rows are
// watched, cycles are learned from, and of all setpoints the one of least cost is proposed.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "airside/civil_time.hpp"
#include "airside/demand/demand_reading.hpp"
#include "airside/demand/night_cooling.hpp"
#include "airside/demand/power_model.hpp"
#include "airside/demand/power_shapes.hpp"
#include "airside/demand/zone_loads.hpp"
#include "airside/demand/zone_signals.hpp"
#include "airside/demand_settings.hpp"

namespace airside {

/// J(A) = P(A) + P_stored(A) + caution sd(P(A) - P(trusted))
///        + P_mean (sum of saturation and warm cost + move_cost (A - A_last)^2)
/// Shape: at most max_zones zones, max_candidates setpoints. Cost: one forecast a zone and candidate.
/// Plain bytes: part of the durable state.  Source: docs/method.md 17.
class BandObjective {
 public:
  void reset(const DemandSettings& s) {
    *this = BandObjective();
    loads_.reset(s);
  }

  /// Whether dampers and zone setpoints carry this objective now: at least half of the zones show both.
  static bool carries(const DemandReading& at) { return shows_band(at); }

  /// A row, decisions' rows included: sums up the running cycle. A row without flow or signals breaks it off.
  void observe(const DemandSettings& s, const DemandReading& at) {
    night_.watch(loads_, at);
    if (!at.flows || !carries(at) || !std::isfinite(at.outdoor_degc)) {
      rows_ = has_begin_ = 0;
      return;
    }
    if (band_cycle.starts(at.time)) {
      if (has_begin_ != 0 && at.time.seconds - begin_.seconds == band_cycle.seconds() && rows_ == band_cycle.rows)
        learn(s, at);
      begin_cycle(at);
    }
    sum_up(s, at);
  }

  int learned() const { return power_.learned(); }
  bool is_ready(const DemandSettings& s) const { return learned() >= s.ready_cycles && power_.finite(); }
  const PowerModel& power() const { return power_; }
  const ZoneLoads& loads() const { return loads_; }

  /// What is expected of one setpoint held from now.  Errors: cost_kw NaN where the model has no number.
  DemandForecast evaluate(const DemandSettings& s, const DemandReading& at, const DemandChoice& c,
                          double setpoint_degc) const {
    const double growth = loads_.growth(at.time);
    const double fall_k = loads_.setpoint_fall_k(at.time, mean_of_seen(at.zones, at.zones.setpoint_degc));
    const Outlook there = outlook(s, at, setpoint_degc, growth, fall_k);
    const Outlook before = outlook(s, at, trusted_degc(at, c), growth, fall_k);
    const PowerShapes x = power_shapes(there.air), x0 = power_shapes(before.air);
    const double scale = std::max(power_.mean_kw(), 1e-3);
    const double move = std::isfinite(c.last_degc) ? setpoint_degc - c.last_degc : 0.0;
    DemandForecast f;
    f.setpoint_degc = setpoint_degc;
    f.power_kw = power_.power_kw(x) + s.heat_worth * power_.heating_kw(x);
    f.most_open = there.most_open;
    const double stored = night_.stored_heat_share(at.time, at.outdoor_degc, there.air.room_degc);
    f.cost_kw = f.power_kw + stored * power_.cooling_kw(x0.lift - x.lift, at.outdoor_degc) +
                s.caution * power_.difference_sd_kw(x, x0) + scale * (there.penalty + s.move_cost * move * move);
    return f;
  }

  /// The setpoint of least cost; while the fan rests the one that was chosen first after the last rest, since the fan
  /// will start on it; where the fan cycles at night to cool, never warmer than the schedule. Errors: setpoint_degc NaN
  /// where the signals do not carry the objective, or too little has been learned: the schedule holds then.
  DemandForecast choose(const DemandSettings& s, const DemandReading& at, const DemandChoice& c) {
    DemandForecast best;
    if (!is_ready(s)) return best;
    // The warmer the air, the longer runs a fan that cycles at night: no cycle's power shows that.
    const double limit = night_.expects(at.time) ? std::clamp(c.schedule_degc, c.min_degc, c.max_degc) : c.max_degc;
    if (!at.flows) {
      rested_at_s_ = at.time.seconds;
      started_ = 0;
      if (std::isfinite(start_degc_)) best.setpoint_degc = std::clamp(start_degc_, c.min_degc, limit);
      return best;
    }
    const bool starts = started_ == 0 && at.time.seconds - rested_at_s_ <= 2 * band_cycle.seconds();
    started_ = 1;
    if (!carries(at) || !std::isfinite(at.outdoor_degc)) return best;
    const bool moves = c.last_degc >= c.min_degc && c.last_degc <= limit && !starts;
    const double warmest = moves ? std::min(limit, c.last_degc + s.warm_step_k) : limit;
    const int n = std::clamp(static_cast<int>(std::lround((warmest - c.min_degc) / c.step_k)), 0, 400);
    for (int i = 0; i <= n; ++i) {
      const DemandForecast f = evaluate(s, at, c, std::min(c.min_degc + i * c.step_k, warmest));
      if (std::isfinite(f.cost_kw) && !(f.cost_kw >= best.cost_kw && std::isfinite(best.setpoint_degc))) best = f;
    }
    if (moves && !(best.setpoint_degc < c.last_degc && is_hot(at))) {
      const DemandForecast stays = evaluate(s, at, c, c.last_degc);
      if (stays.cost_kw <= best.cost_kw + s.stay_share * power_.mean_kw()) best = stays;
    }
    if (starts && std::isfinite(best.setpoint_degc)) start_degc_ = best.setpoint_degc;
    return best;
  }

 private:
  static constexpr std::int64_t never = -1'000'000'000'000;

  struct Outlook {
    AirState air;
    double penalty = 0;  ///< shares of the mean power
    double most_open = 0;
  };

  /// Quadratic, then linear: where every setpoint leaves a zone short of air, the colder one still is the better.
  static double saturation(double over) {
    constexpr double linear_from = 0.5, most = 1.5;
    const double x = std::clamp(over, 0.0, most), low = std::min(x, linear_from);
    return low * low + (x - low);
  }

  /// Zones, flow and penalty at another supply temperature, the loads held.
  Outlook outlook(const DemandSettings& s, const DemandReading& at, double supply_degc, double growth,
                  double fall_k) const {
    Outlook o;
    double damper_sum = 0, room_sum = 0, cold = 0;
    int seen = 0;
    const std::size_t n = std::min(at.zones.count(), max_zones);
    for (std::size_t i = 0; i < n; ++i) {
      if (!zone_is_seen(at.zones, i) || !loads_.is_known(i)) continue;
      const ZoneForecast f = loads_.forecast(s, at.zones, i, supply_degc, growth, fall_k);
      ++seen;
      damper_sum += f.damper;
      room_sum += at.zones.temp_degc[i];
      const double heats = loads_.heating_share(i, at.zones.temp_degc[i], at.zones.setpoint_degc[i]);
      if (!loads_.is_set_back(i, at.zones.setpoint_degc[i])) {
        o.air.cold_share += heats;
        o.air.ventilation += s.outdoor_share;
      }
      cold += loads_.heat_k(at.zones, i, supply_degc, f.damper, night_.free_cooling_share(at.zones.temp_degc[i]));
      const double excess_cost = s.warm_cost * std::min(f.excess_k, 2.0);
      o.penalty += loads_.weight(i) * (s.saturation_cost * saturation(f.wanted - s.damper_high) + excess_cost);
      o.penalty += loads_.cold_weight(i) * s.cold_cost * std::min(f.short_k, 2.0);
      o.most_open = std::max(o.most_open, f.wanted);
    }
    if (seen == 0) {
      o.air.flow = std::numeric_limits<double>::quiet_NaN();
      return o;
    }
    o.air.flow = damper_sum / seen;
    o.air.supply_degc = supply_degc;
    o.air.room_degc = room_sum / seen;
    o.air.outdoor_degc = at.outdoor_degc;
    o.air.cold_share /= seen;
    o.air.ventilation /= seen;
    o.air.cold_boxes_k = cold / seen;
    return o;
  }

  bool is_hot(const DemandReading& at) const { return night_.is_hot(mean_of_seen(at.zones, at.zones.temp_degc)); }
  /// What doubt counts against leaving: the schedule; where it is hot the coldest air, since little but the plant
  /// cools.
  double trusted_degc(const DemandReading& at, const DemandChoice& c) const {
    return is_hot(at) ? c.min_degc : std::clamp(c.schedule_degc, c.min_degc, c.max_degc);
  }

  AirState air_now(const DemandReading& at) const {
    AirState a{.supply_degc = at.supply_degc, .outdoor_degc = at.outdoor_degc};
    int seen = 0;
    const std::size_t n = std::min(at.zones.count(), max_zones);
    for (std::size_t i = 0; i < n; ++i) {
      if (!zone_is_seen(at.zones, i)) continue;
      ++seen;
      a.flow += at.zones.damper[i];
      a.room_degc += at.zones.temp_degc[i];
      const double heats = loads_.heating_share(i, at.zones.temp_degc[i], at.zones.setpoint_degc[i]);
      a.cold_share += loads_.is_set_back(i, at.zones.setpoint_degc[i]) ? 0.0 : heats;
      a.cold_boxes_k += heats * at.zones.damper[i] * (at.zones.temp_degc[i] - at.supply_degc);
    }
    a.flow /= seen;
    a.room_degc /= seen;
    a.cold_share /= seen;
    a.cold_boxes_k /= seen;
    return a;
  }

  void begin_cycle(const DemandReading& at) {
    begin_ = at.time;
    has_begin_ = 1;
    rows_ = 0;
    shape_sum_ = {};
    demand_sum_.fill(0);
    total_sum_ = fan_sum_ = flow_sum_ = 0;
    for (std::size_t i = 0; i < std::min(at.zones.count(), max_zones); ++i) begin_temp_[i] = at.zones.temp_degc[i];
  }

  void sum_up(const DemandSettings& s, const DemandReading& at) {
    if (has_begin_ == 0) return;
    ++rows_;
    add(shape_sum_, power_shapes(air_now(at)));
    for (const double kw : at.power_kw) total_sum_ += kw;
    flow_sum_ += at.flow_m3_s;
    const auto fan = static_cast<std::size_t>(s.fan_meter);
    fan_sum_ += fan >= 1 && fan <= at.power_kw.size() && at.power_kw.size() > 1
                    ? at.power_kw[fan - 1]
                    : std::numeric_limits<double>::quiet_NaN();
    for (std::size_t i = 0; i < std::min(at.zones.count(), max_zones); ++i) {
      demand_sum_[i] += at.zones.damper[i] * (at.zones.temp_degc[i] - at.supply_degc);
      if (!zone_is_seen(at.zones, i)) continue;
      loads_.note_row(s, at.zones, i, at.coldest, at.warmest);
    }
  }

  void learn(const DemandSettings& s, const DemandReading& at) {
    PowerShapes mean;
    add(mean, shape_sum_, 1.0 / rows_);
    power_.update(s, mean,
                  {.total_kw = total_sum_ / rows_, .fan_kw = fan_sum_ / rows_, .flow_m3_s = flow_sum_ / rows_});
    const std::size_t n = std::min(at.zones.count(), max_zones);
    std::size_t back = 0;
    for (std::size_t i = 0; i < n; ++i) {
      const double moved_k = at.zones.temp_degc[i] - begin_temp_[i];
      loads_.update(s, i, demand_sum_[i] / rows_, moved_k);
      if (!zone_is_seen(at.zones, i)) continue;
      back += loads_.is_set_back(i, at.zones.setpoint_degc[i]) ? 1u : 0u;
      loads_.note_free_load(i, loads_.heating_share(i, begin_temp_[i], at.zones.setpoint_degc[i]));
      loads_.note_held(i, at.zones.temp_degc[i], moved_k, at.zones.damper[i], at.zones.setpoint_degc[i]);
    }
    loads_.note_profile(at.time, n, mean_of_seen(at.zones, at.zones.setpoint_degc), 2 * back > n);
  }

  ZoneLoads loads_;
  NightCooling night_;
  PowerModel power_;
  PowerShapes shape_sum_;
  std::array<double, max_zones> demand_sum_{}, begin_temp_{};
  double total_sum_ = 0, fan_sum_ = 0, flow_sum_ = 0;
  double start_degc_ = std::numeric_limits<double>::quiet_NaN();  ///< the first choice after the last rest
  CivilTime begin_;
  std::int32_t rows_ = 0;
  std::int32_t has_begin_ = 0;
  std::int64_t rested_at_s_ = never;  ///< when it was last asked with the fan at rest
  std::int64_t started_ = 0;          ///< 1: it was asked since, with the fan running
};

}  // namespace airside
