#include <fmt/format.h>

#include "sim/weather/epw.hpp"
#include "tools/gap/run/gap_run.hpp"

namespace airside::tools::gap {

RetrainPlan retrain_plan(const CaseDescription& source, const RetrainRequest& request) {
  RetrainPlan plan;
  plan.site = request.site;
  plan.plant = source.engine;
  plan.twin = {source.model, source.engine == "rc" ? std::vector<std::string>{} : source.patches, {}};
  if (source.engine == "rc") {
    plan.patched.room = request.patched_file.string();
  } else {
    plan.patched = plan.twin;
    plan.patched.patches.push_back(request.patched_file.string());
  }
  plan.measured = request.measured;
  plan.seeds = request.seeds;
  plan.pretrain_days = request.pretrain_days;
  plan.days = request.days;
  plan.jobs = request.jobs;
  if (sim::read_epw(source.weather, {.whole_year = false, .from = {}, .to = {}})->covers_year()) {
    plan.weather = source.weather;
  }
  return plan;
}

void retrain_patched(GapRun& run, const RetrainRequest& request, StagedProgress& progress) {
  const PatchedModel& patched = run.patched.value();
  RetrainPlan plan = retrain_plan(run.request.source, request);
  plan.patched.changes_in_model = true;
  const bool energyplus = run.request.source.engine == "energyplus";
  if (energyplus) plan.patched.changes = run.after;
  const bool stand_in = plan.measured.room.empty();
  if (stand_in) plan.measured = plan.patched;
  check_retrain_rooms(plan);
  progress.start(fmt::format("pretraining on 2 twins x {} seeds", plan.seeds),
                 {{"training and running", static_cast<double>(retrain_steps(plan))}});
  run.retraining = retrain(plan, [&progress] { progress.advance(); });
  progress.finish();
  run.retraining->stand_in = stand_in;
  std::vector<std::string>& remarks = run.retraining->remarks;
  if (stand_in) {
    remarks.push_back(
        "The patched twin plays the measured room, since none was given: this is what the patch is worth to the "
        "controller if it is the whole truth.");
  }
  std::string beside;
  int corrections = 0;
  for (std::size_t i = 0; i < patched.changes.size(); ++i) {
    for (const std::string& line : patched.changes[i].beside) {
      if (energyplus && line.starts_with("loop ")) continue;
      if (i < run.before.size()) {
        ++corrections;
      } else {
        beside += (beside.empty() ? "" : "; ") + line;
      }
    }
  }
  if (!beside.empty())
    remarks.push_back("Found, but held by no model, so nothing was pretrained on it: " + beside + ".");
  if (corrections > 0) {
    remarks.push_back(fmt::format(
        "{} fitted corrections of sensors, clock or weather are not in the patched twin either: the ledger lists them.",
        corrections));
  }
  if (plan.weather.empty()) {
    remarks.push_back(std::string("The weather file does not hold a whole year: both twins and the measured room lived "
                                  "in ") +
                      (energyplus ? "Tampa's weather." : "made-up weather."));
  }
}

}  // namespace airside::tools::gap
