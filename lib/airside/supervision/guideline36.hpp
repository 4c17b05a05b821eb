#pragma once
// ASHRAE Guideline 36 supply-air temperature reset by trim and respond: what a modern site runs otherwise. The box
// logs it as a shadow beside its own choice; studies drive rooms with it.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "airside/civil_time.hpp"
#include "airside/settings.hpp"
#include "airside/supervision/guideline36_settings.hpp"  // IWYU pragma: export
#include "airside/supervision/schedule.hpp"
#include "airside/supervision/trim_and_respond.hpp"

namespace airside {

/// The reset of trim_and_respond.hpp, by the room temperatures alone: the cooling setpoint is the site's target.
/// Outside working hours the fan of these plants keeps running, so the schedule's night value is held and the reset
/// starts anew at SP0.
/// Plain bytes: part of the durable state.
class Guideline36 {
 public:
  static constexpr std::size_t max_rooms = 32;  ///< further rooms are not asked

  /// The setpoint from `t` until the next reading, rounded, degC. Called every `period_s`.
  /// Shape: rooms_degc and vav_on of one length; an empty vav_on means all open. Errors: a room that is not finite
  /// asks for nothing.
  double setpoint_degc(const ControllerSettings& site, const Guideline36Settings& settings, CivilTime t,
                       std::span<const double> rooms_degc, std::span<const double> vav_on, double outdoor_temp_degc) {
    const double dt_h = settings.period_s / 3600.0;
    const std::size_t rooms = std::min(rooms_degc.size(), max_rooms);
    requests_ = 0;
    bool fan = rooms == 0;
    double sum = 0;
    int finite = 0;
    for (std::size_t i = 0; i < rooms; ++i) {
      const bool open = i >= vav_on.size() || vav_on[i] > 0.5;
      fan = fan || open;
      requests_ += zone_requests(settings, zones_[i], rooms_degc[i] - site.target_degc, open, dt_h);
      if (std::isfinite(rooms_degc[i])) sum += rooms_degc[i], ++finite;
    }
    if (!in_working_hours(site, t) || !fan) {
      was_occupied_ = 0;
      const bool soon = in_working_hours(site, CivilTime{t.seconds + settings.cooldown_s});
      const bool warm = finite > 0 && sum / finite > site.target_degc;
      return bounded(site, settings, soon && warm ? settings.sp_min_degc : site.expert_off_degc);
    }
    if (was_occupied_ != 0) {
      reset_.row(settings, requests_);
    } else {
      reset_.restart(settings);
    }
    was_occupied_ = 1;
    return bounded(site, settings, reset_.setpoint_degc(settings, outdoor_temp_degc));
  }

  int requests() const { return requests_; }  ///< of the last reading

 private:
  struct Zone {
    double integral = 0;
    CoolingRequests cooling;
  };

  static int zone_requests(const Guideline36Settings& s, Zone& zone, double error_k, bool open, double dt_h) {
    if (!open || !std::isfinite(error_k)) {
      zone = {};
      return 0;
    }
    double loop = 1.0;
    if (s.loop == CoolingLoop::zone_pi) {
      zone.integral = std::clamp(zone.integral + s.loop_integral_per_kh * error_k * dt_h, 0.0, 1.0);
      loop = std::clamp(s.loop_gain_per_k * error_k + zone.integral, 0.0, 1.0);
    }
    return zone.cooling.row(loop, error_k >= 2, error_k >= 3);
  }

  static double bounded(const ControllerSettings& site, const Guideline36Settings& s, double setpoint_degc) {
    const double in_range =
        s.clamp_to_site ? std::clamp(setpoint_degc, site.action_min_degc, site.action_max_degc) : setpoint_degc;
    return std::round(in_range / site.round_k) * site.round_k;
  }

  std::array<Zone, max_rooms> zones_{};
  TrimAndRespond reset_;
  std::int32_t requests_ = 0;
  std::int32_t was_occupied_ = 0;
};

}  // namespace airside
