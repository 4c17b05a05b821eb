#pragma once
// The whole workflow on one site: logs in, verdict, patched model and everything that a report shows out.

#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "tools/gap/case/case_loader.hpp"
#include "tools/gap/explain/experiment.hpp"
#include "tools/gap/explain/finding_energy.hpp"
#include "tools/gap/explain/flux.hpp"
#include "tools/gap/explain/meter_offset.hpp"
#include "tools/gap/model/model_error.hpp"
#include "tools/gap/model/patched_model.hpp"
#include "tools/gap/retrain/retrain.hpp"
#include "tools/gap/tried/tried_effect.hpp"
#include "tools/gap/verdict/verdict.hpp"
#include "tools/run/progress/staged_progress.hpp"

namespace airside::tools::gap {

/// Days that came after a first verdict.
struct MoreDays {
  std::string log;
  std::string test;  ///< name of the test on site that was done in them; empty: none
};

struct GapRequest {
  CaseDescription source;
  std::string site;     ///< name, for reports
  std::string command;  ///< that repeats the run
  std::filesystem::path cache;
  int jobs = 1;
  bool findings_only = false;      ///< the twin keeps its own parameters; only what was found is added
  bool best_guess = false;         ///< patch the model with an ambiguous verdict too
  std::vector<std::string> tries;  ///< "vav_flow@2=0.5": the user's own suspicions
  std::filesystem::path effects;   ///< folder of their files
  bool sun_on_site = false;        ///< the weather file's sun was measured on the site
  std::optional<int> buildings;    ///< as Rules::buildings; none: the model's usual number
  Price price;                     ///< of what a finding costs
  std::vector<MoreDays> more;      ///< in the order in which they came
  nlohmann::json earlier;          ///< gap.json of the verdict that they continue; null without
};

struct AddedDays {
  CleanLog log;
  std::string test;
  Window window;
};

/// A suspicion of the user's.
struct Suspicion {
  TriedEffect tried;
  Eigen::MatrixXd residual;  ///< as GapRun's, with this effect alone
};

/// A parameter that the measured days want far from its prior, where no reference period speaks for it.
struct FarParameter {
  sim::EffectChange change;
  double prior_sds = 0;  ///< from null
};

/// A parameter of the twin, as the reference period wants it.
struct ReferenceParameter {
  sim::EffectChange change;
  double sd = 0;  ///< of the magnitude, inflated for residuals that are not independent
};

/// Residuals are measured minus simulated, bins x channels, of the model alone: what anyone gets who runs it.
struct GapRun {
  GapRequest request;
  Rules rules;
  LoadedCase loaded;             ///< its measured window with the days that were added
  std::vector<AddedDays> added;  ///< as GapRequest::more
  WindowResponses responses;
  Verdict verdict;
  std::vector<ReferenceParameter> parameters;
  Changes before, after;                        ///< to the model as given: parameters; and what was found
  Eigen::MatrixXd residual_given;               ///< of the model as given
  Eigen::MatrixXd residual_before;              ///< with fitted parameters
  Eigen::MatrixXd residual_after;               ///< and with what was found
  Eigen::MatrixXd simulated_after;              ///< the curve of the model with what was found
  std::vector<FindingEnergy> energy;            ///< one a finding
  std::vector<ExperimentProposal> experiments;  ///< ambiguous: tests that tell the candidates apart, best first
  std::optional<UnknownHeat> heat;              ///< unknown: what is missing in each zone
  std::vector<MeterOffset> meter_offsets;       ///< unknown: power that this heat does not explain, one a meter
  std::vector<Suspicion> suspicions;            ///< one a try
  std::vector<NotApplicable> not_applicable;    ///< effects that this model cannot have
  std::optional<PatchedModel> patched;          ///< named, or asked for
  std::optional<Retraining> retraining;         ///< asked for: what the patch is worth to the controller

  sim::Channels channels() const { return loaded.engine->channels(); }
  /// First bin of the days that were locked away.
  Eigen::Index locked_from() const;
};

/// Those at two prior standard deviations or more, the farthest first; none where there was a reference period.
std::vector<FarParameter> far_parameters(const GapRun& run);

/// What a missing reference period costs, and parameters that these days want far away; "" where there was one.
std::string no_reference_text(const GapRun& run);

/// Reference, measured and added days.
std::vector<const CleanLog*> logs_of(const GapRun& run);
/// warnings_text() of all of them.
std::string warnings_text(const GapRun& run);
/// That the weather file is hardly that of the logs' days, and what hangs on it; "" where it is.
std::string other_weather_text(const GapRun& run);

/// The verdict in one sentence, with what it costs and how to confirm it, the test to do or the heat that is missing.
std::string sentence_of(const GapRun& run);

/// Runs it.  `effects` must outlive the result.
/// Errors: RefusedLog, before any simulation; hal::InputError; std::runtime_error of a simulation that died.
/// Cost: as simulate_responses() of both windows, then as analyse().
GapRun run_gap(const GapRequest& request, const std::vector<sim::Effect>& effects, StagedProgress& progress);

/// What was added to the model, why, how sure that is, and the patch that takes it back. `run.patched` must be set.
/// Format: docs/formats.md.
nlohmann::json ledger_of(const GapRun& run);

/// How far a model is off on the fitted or on the locked days: hourly means as ASHRAE Guideline 14 wants them.
struct PeriodErrors {
  double temp_rmse_k = 0, power_rmse_kw = 0;
  Guideline14 room_temp, power;
};
PeriodErrors fitted_errors(const GapRun& run, const Eigen::MatrixXd& residual);
PeriodErrors locked_errors(const GapRun& run, const Eigen::MatrixXd& residual);

/// Each suspicion beside the model without it and the one with what was found. Format: docs/formats.md.
nlohmann::json suspicions_json(const GapRun& run);
/// The same for a terminal, "" without any.
std::string suspicions_text(const GapRun& run);

/// A candidate in the earlier verdict and in this one. 2 ln likelihood, by real simulation where it was simulated, else
/// by linear responses; NaN where it was not listed.
struct CandidateBeforeAfter {
  std::string id;
  double before = 0, after = 0, limit = 0;
};
std::vector<CandidateBeforeAfter> candidates_before_after(const GapRun& run);
/// "with 5 more days: ambiguous -> named", "" where nothing is continued.
std::string continued_text(const GapRun& run);

/// What --json prints.
nlohmann::json json_of(const GapRun& run);

/// JSON for people who open the file: a key a line, a list of mere values on one.
std::string readable_text(const nlohmann::json& j);

/// What is asked of a retraining after the workflow.
struct RetrainRequest {
  Site site = built_in_site();
  RetrainRoom measured;                ///< empty: the patched twin plays it
  std::filesystem::path patched_file;  ///< rc: the patched room; EnergyPlus: the merge patch
  int seeds = 5, pretrain_days = 31, days = 7, jobs = 1;
};

/// Both twins, from the files that hold them, and the measured room.
RetrainPlan retrain_plan(const CaseDescription& source, const RetrainRequest& request);

/// Pretrains again and sets `run.retraining`. `run.patched` must be set.
/// Errors: as retrain().
void retrain_patched(GapRun& run, const RetrainRequest& request, StagedProgress& progress);

/// The patched model's run over the measured period, in a folder in which plain `energyplus` repeats it.
/// Errors: hal::InputError for an engine that is not EnergyPlus.
void keep_patched_run(const GapRun& run, const std::filesystem::path& folder);

}  // namespace airside::tools::gap
