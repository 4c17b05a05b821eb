#pragma once
// ASHRAE Guideline 36 supply-air temperature reset by trim and respond: what a modern site runs without us.

#include <vector>

#include "tools/baselines/baseline.hpp"

namespace airside::tools {

/// How a zone's cooling loop is seen, since the plants' VAVs are open or shut and have no loop of their own.
enum class CoolingLoop {
  zone_pi,  ///< a PI loop on the room temperature, as the VAV's controller has one; 0 while the VAV is shut
  airflow,  ///< airflow / maximum: 1 while the VAV is open
};

/// Source: BASELINES.
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
Guideline36Settings guideline36_as_written(double sp_max_degc = 16.0);

/// The same logic on the site's range: action minimum to the schedule's night value, no outdoor-air reset (a
/// site above 21.1 degC all day would be pinned to its minimum, which is the constant baseline).
Guideline36Settings guideline36_on_site(const ControllerSettings& site, int ignored_requests = 2);

/// Each step, with R the sum of the zones' requests (either trim or respond):
///   Tmax = clamp(Tmax + (R <= I ? trim : -min(respond (R - I), respond_max)), SPmin, SPmax)
/// Requests of a zone: 3 at 3 K above the cooling setpoint, 2 at 2 K, 1 above 95 % cooling loop until below
/// 85 %. The cooling setpoint is the site's target. Outside working hours the fan of these plants keeps
/// running, so the schedule's night value is held and the reset starts anew at SP0.
class Guideline36Baseline final : public BaselineController {
 public:
  Guideline36Baseline(const ControllerSettings& site, const Guideline36Settings& settings, std::string name)
      : site_(site), settings_(settings), name_(std::move(name)), reset_degc_(settings.sp_max_degc) {}
  std::string name() const override { return name_; }
  int decision_period_s() const override { return settings_.period_s; }
  double decide(const CycleObservation& now) override;

  int requests() const { return requests_; }  ///< of the last decision

 private:
  struct Zone {
    double integral = 0;
    bool calls = false;
  };
  int zone_requests(Zone& zone, double error_k, bool open, double dt_h) const;
  double bounded(double setpoint_degc) const;

  ControllerSettings site_;
  Guideline36Settings settings_;
  std::string name_;
  double reset_degc_;  ///< Tmax
  std::vector<Zone> zones_;
  int requests_ = 0;
  int running_s_ = 0;  ///< since the fan was proven on
  int pending_s_ = 0;  ///< time not yet used up by steps
  bool was_occupied_ = false;
};

}  // namespace airside::tools
