#pragma once
// ASHRAE Guideline 36 supply-air temperature reset by trim and respond: what a modern site runs without us. The box
// logs it as a shadow beside its own choice; studies drive rooms with it.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "airside/civil_time.hpp"
#include "airside/settings.hpp"
#include "airside/supervision/schedule.hpp"

namespace airside {

/// How a zone's cooling loop is seen, since VAVs that only report on and off show no loop of their own.
enum class CoolingLoop : std::uint8_t {
  zone_pi,  ///< a PI loop on the room temperature, as the VAV's controller has one; 0 while the VAV is shut
  airflow,  ///< airflow / maximum: 1 while the VAV is open
};

/// Source: docs/results.md, "Guideline 36".
struct Guideline36Settings {
  double sp_min_degc = 12.0;
  double sp_max_degc = 16.0;  ///< also SP0
  double trim_k = 0.1;        ///< up, each step without enough requests
  double respond_k = 0.2;     ///< down, for each request above the ignored ones
  double respond_max_k = 0.6;
  int ignored_requests = 2;  ///< I
  int delay_s = 600;         ///< Td, after the fan is proven on
  int step_s = 120;          ///< T
  bool oat_reset = true;     ///< sp_min at and above oat_max, linear between
  double oat_min_degc = 15.6;
  double oat_max_degc = 21.1;
  CoolingLoop loop = CoolingLoop::zone_pi;
  double loop_gain_per_k = 0.5;  ///< full cooling at 2 K above the cooling setpoint
  double loop_integral_per_kh = 1.0;
  int cooldown_s = 3600;       ///< before work: sp_min while the rooms are above the cooling setpoint
  bool clamp_to_site = false;  ///< true: never outside the site's action range
  int period_s = row_s;        ///< how often readings come; several steps are made at once when it exceeds T
};

/// As written: 12 to `sp_max_degc` (16 humid, 18 mild), outdoor-air reset, not clamped to the site's range.
constexpr Guideline36Settings guideline36_as_written(double sp_max_degc = 16.0) {
  Guideline36Settings s;
  s.sp_max_degc = sp_max_degc;
  return s;
}

/// The same logic on the site's range: action minimum to the schedule's night value, no outdoor-air reset (a
/// site above 21.1 degC all day would be pinned to its minimum, which is the constant baseline).
constexpr Guideline36Settings guideline36_on_site(const ControllerSettings& site, int ignored_requests = 2) {
  Guideline36Settings s;
  s.sp_min_degc = site.action_min_degc;
  s.sp_max_degc = std::min(site.expert_off_degc, site.action_max_degc);
  s.ignored_requests = ignored_requests;
  s.oat_reset = false;
  s.clamp_to_site = true;
  return s;
}

/// Each step, with R the sum of the zones' requests (either trim or respond):
///   Tmax = clamp(Tmax + (R <= I ? trim : -min(respond (R - I), respond_max)), SPmin, SPmax)
/// Requests of a zone: 3 at 3 K above the cooling setpoint, 2 at 2 K, 1 above 95 % cooling loop until below
/// 85 %. The cooling setpoint is the site's target. Outside working hours the fan of these plants keeps
/// running, so the schedule's night value is held and the reset starts anew at SP0.
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
    if (started_ == 0) reset_degc_ = settings.sp_max_degc;
    started_ = 1;
    if (!in_working_hours(site, t) || !fan) {
      reset_degc_ = settings.sp_max_degc;
      running_s_ = pending_s_ = was_occupied_ = 0;
      const bool soon = in_working_hours(site, CivilTime{t.seconds + settings.cooldown_s});
      const bool warm = finite > 0 && sum / finite > site.target_degc;
      return bounded(site, settings, soon && warm ? settings.sp_min_degc : site.expert_off_degc);
    }
    if (was_occupied_ != 0) step(settings);
    was_occupied_ = 1;
    if (!settings.oat_reset || !std::isfinite(outdoor_temp_degc)) return bounded(site, settings, reset_degc_);
    const double warm = std::clamp(
        (outdoor_temp_degc - settings.oat_min_degc) / (settings.oat_max_degc - settings.oat_min_degc), 0.0, 1.0);
    return bounded(site, settings, reset_degc_ + warm * (settings.sp_min_degc - reset_degc_));
  }

  int requests() const { return requests_; }  ///< of the last reading

 private:
  struct Zone {
    double integral = 0;
    std::int64_t calls = 0;
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
    if (loop > 0.95) zone.calls = 1;
    if (loop < 0.85) zone.calls = 0;
    if (error_k >= 3) return 3;
    if (error_k >= 2) return 2;
    return zone.calls != 0 ? 1 : 0;
  }

  /// The requests seen now stand for the time since the last reading.
  void step(const Guideline36Settings& s) {
    const std::int32_t before_s = running_s_;
    running_s_ += s.period_s;
    pending_s_ += running_s_ - std::max(before_s, std::min<std::int32_t>(s.delay_s, running_s_));
    for (; pending_s_ >= s.step_s; pending_s_ -= s.step_s) {
      const int excess = requests_ - s.ignored_requests;
      const double change = excess <= 0 ? s.trim_k : -std::min(s.respond_k * excess, s.respond_max_k);
      reset_degc_ = std::clamp(reset_degc_ + change, s.sp_min_degc, s.sp_max_degc);
    }
  }

  static double bounded(const ControllerSettings& site, const Guideline36Settings& s, double setpoint_degc) {
    const double in_range =
        s.clamp_to_site ? std::clamp(setpoint_degc, site.action_min_degc, site.action_max_degc) : setpoint_degc;
    return std::round(in_range / site.round_k) * site.round_k;
  }

  std::array<Zone, max_rooms> zones_{};
  double reset_degc_ = 0;  ///< Tmax
  std::int32_t requests_ = 0;
  std::int32_t running_s_ = 0;  ///< since the fan was proven on
  std::int32_t pending_s_ = 0;  ///< time not yet used up by steps
  std::int32_t was_occupied_ = 0;
  std::int32_t started_ = 0;
};

}  // namespace airside
