#pragma once
// Rooms whose AHU rests at night: how each method gets the rooms back after the fan's start.

#include <span>
#include <string>

#include "tools/run/control_run.hpp"
#include "tools/run/plant_choice.hpp"

namespace airside::tools {

/// Mean |room mean - target| of a run's rows, degC.
struct NightFigures {
  double first_hour_degc = 0;         ///< after the fan's start, every scored day
  double first_three_hours_degc = 0;  ///< the same until three hours after it
  double working_degc = 0;            ///< in the site's working hours
  double first_day_degc = 0;          ///< the first three hours of the first day
};

/// Errors: std::invalid_argument for a run without a row in these hours.
NightFigures night_figures(const Site& site, std::span<const hal::LogRow> rows, double fan_start_h);

/// The built-in site whose fan runs between these hours only, and says so; no point shows it.
Site resting_site(double fan_start_h, double fan_stop_h);

struct NightRun {
  PlantChoice room, twin;  ///< of the RC plant; their AHU rests as the site's does
  double fan_start_h = 6, fan_stop_h = 20;
  int pretrain_days = 31, expert_days = 5, days = 14, steps = 3000;
};

/// One method on one room: "ours-product", pretrained on the twin and fine-tuned on the schedule's days, or a name of
/// run_method().
NightFigures run_nights(const NightRun& run, const std::string& method);

}  // namespace airside::tools
