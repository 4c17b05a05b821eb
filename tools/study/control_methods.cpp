#include "tools/study/control_methods.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "hal/text/input_error.hpp"
#include "sim/energyplus/plant.hpp"
#include "sim/rc/rc_floor.hpp"
#include "sim/rc/rc_plant.hpp"
#include "tools/run/training/transfer.hpp"

namespace airside::tools {

std::vector<std::string> floor_names(bool energyplus) {
  if (energyplus) return {"floor-full"};
  return {"floor-frozen", "floor-profile", "floor-full"};
}

void check_method(const std::string& option, const std::string& name, bool energyplus) {
  std::vector<std::string> known = baseline_names();
  for (const std::string& floor : floor_names(energyplus)) known.push_back(floor);
  if (std::find(known.begin(), known.end(), name) != known.end()) return;
  throw hal::InputError(option, '"' + name + '"', fmt::format("one of ours, {}", fmt::join(known, ", ")),
                        "choose a name from the list; ours is this project's own, with the preset of the site");
}

Prepared prepare(const Trial& trial, const OnProgress& progress) {
  Prepared out;
  out.model = make_plant(trial.plant, trial.site, trial.expert_days + trial.days);
  const std::int64_t start = start_of(trial.plant).seconds;
  const CivilTime begin{start + trial.expert_days * std::int64_t{86400}};
  out.until = {begin.seconds + trial.days * std::int64_t{86400}};
  if (trial.expert_days > 0) out.history = run_schedule(trial.site, *out.model, begin, progress).rows;
  if (!trial.faults.empty()) {
    out.model->advance_to(begin);
    out.faulty = std::make_unique<sim::FaultyModel>(*out.model, trial.faults);
  }
  return out;
}

ControlRun run_ours(const Trial& trial, Prepared& prepared, const OurWeights& weights, const OnProgress& progress) {
  BlobBytes blob = weights.blob;
  if (weights.transfer) {
    FineTuneOptions options;
    options.steps = weights.steps;
    options.seed = trial.plant.seed;
    options.provenance = "fine-tuned in a trial: " + command_text(trial.plant, trial.site);
    blob = transfer(trial.site, weights.blob, prepared.history, options).blob;
  }
  return run_controller(trial.site, prepared.room(), blob, prepared.history, prepared.until, trial.site.file.seed,
                        progress);
}

ControlRun run_method(const Trial& trial, Prepared& prepared, const std::string& name, const OnProgress& progress) {
  if (!name.starts_with("floor-")) {
    const auto plant = is_energyplus(trial.plant, trial.site) ? PlantKind::energyplus : PlantKind::rc;
    const auto baseline = make_baseline(name, trial.site.settings, plant);
    return run_baseline(trial.site, prepared.room(), *baseline, prepared.history, prepared.until, progress);
  }
  const ControllerSettings& s = trial.site.settings;
  const double target = s.target_degc, low = s.action_min_degc, high = s.action_max_degc;
  if (auto* rc = dynamic_cast<sim::RcPlant*>(prepared.model.get())) {
    std::optional<sim::Foresight> foresight;
    if (name == "floor-frozen") foresight = sim::Foresight::frozen;
    if (name == "floor-profile") foresight = sim::Foresight::profile;
    if (name == "floor-full") foresight = sim::Foresight::full;
    if (foresight) {
      return run_setpoints(
          trial.site, *rc,
          [&] { return sim::floor_setpoint(*rc, target, low, high, *foresight, control_cycle(s).seconds()); },
          prepared.until, progress);
    }
  }
  if (auto* engine = dynamic_cast<sim::EnergyPlusPlant*>(prepared.model.get());
      engine != nullptr && name == "floor-full") {
    return run_setpoints(
        trial.site, *engine,
        [&] { return sim::full_forecast_setpoint(*engine, target, low, high, control_cycle(s).seconds()); },
        prepared.until, progress);
  }
  throw hal::InputError("method " + name, "a floor that this plant cannot give",
                        "floor-frozen, floor-profile, floor-full on rc; floor-full on EnergyPlus",
                        "choose another method or --plant");
}

}  // namespace airside::tools
