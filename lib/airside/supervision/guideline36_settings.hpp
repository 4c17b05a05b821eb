#pragma once
// The numbers of ASHRAE Guideline 36's supply-air temperature reset.

#include <algorithm>
#include <cstdint>

#include "airside/civil_time.hpp"
#include "airside/settings.hpp"

namespace airside {

/// How a zone's cooling loop is seen, since VAVs that only report on and off show no loop of their own.
enum class CoolingLoop : std::uint8_t {
  zone_pi,  ///< a PI loop on the room temperature, as the VAV's controller has one; 0 while the VAV is shut
  airflow,  ///< airflow / maximum: 1 while the VAV is open
};

/// The reset's numbers. Units: degC, K, s.  Source: docs/results.md, "Guideline 36".
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

}  // namespace airside
