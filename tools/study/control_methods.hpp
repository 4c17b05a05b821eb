#pragma once
// One method on one room: the schedule's days first, then the scored days. Simulation and studies share it, so that
// every row of every table is made the same way.

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "sim/faults/faulty_model.hpp"
#include "tools/run/control_run.hpp"
#include "tools/run/plant_choice.hpp"

namespace airside::tools {

/// A room with the days that every method gets.
struct Trial {
  Site site;
  PlantChoice plant;
  int expert_days = 5;
  int days = 14;
  sim::FaultScript faults = {};  ///< in the controlled days
};

/// Names that run_method knows beside baseline_names(): floors that need the plant's own future.
/// "floor-frozen", "floor-profile" (rc only), "floor-full".
std::vector<std::string> floor_names(bool energyplus);

/// Refuses a name that run_method would not know, before anything is computed. `option` is what the user typed it
/// after. Errors: hal::InputError.
void check_method(const std::string& option, const std::string& name, bool energyplus);

/// A made plant that has run the schedule's days.
struct Prepared {
  std::unique_ptr<sim::PlantModel> model;
  std::unique_ptr<sim::FaultyModel> faulty;  ///< before the model, where the trial has faults
  std::vector<hal::LogRow> history;
  CivilTime until;

  /// What a method controls.
  sim::PlantModel& room() { return faulty ? *faulty : *model; }
};
Prepared prepare(const Trial& trial, const OnProgress& progress = {});

/// What `ours` starts from.
struct OurWeights {
  BlobBytes blob;        ///< source or finished weights; empty with transfer: from scratch
  bool transfer = true;  ///< fine-tune on the schedule's days first
  int steps = 3000;
};

/// The controller of the site's preset.
ControlRun run_ours(const Trial& trial, Prepared& prepared, const OurWeights& weights, const OnProgress& progress = {});

/// A baseline, with the gains tuned on the trial's kind of plant, or a floor by name.
/// Errors: hal::InputError on a name that is neither, or a floor that the plant cannot give.
ControlRun run_method(const Trial& trial, Prepared& prepared, const std::string& name, const OnProgress& progress = {});

}  // namespace airside::tools
