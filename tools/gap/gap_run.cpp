#include "tools/gap/gap_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "sim/json/merge_patch.hpp"
#include "sim/weather/epw.hpp"
#include "tools/gap/model/energyplus_engine.hpp"
#include "tools/gap/verdict/verdict_json.hpp"
#include "tools/run/progress.hpp"

namespace airside::tools::gap {

namespace {

using nlohmann::json;

/// Standard deviations of fitted parameters are of the posterior, inflated as the workflow inflates it.
std::vector<ReferenceParameter> reference_parameters(const ReferenceFit& fit, const Nuisance& nuisance,
                                                     const Responses& responses) {
  const Changes changes = fit.changes();
  std::vector<ReferenceParameter> fitted;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    const double variance = nuisance.inflation * fit.covariance(k, k);
    fitted.push_back({changes[i], responses.parameters[i].prior_sd * std::sqrt(std::max(0.0, variance))});
  }
  return fitted;
}

/// The first finding and what the log cannot tell it from, each at the magnitude that it would have.
Changes rivals(const GapRun& run) {
  const Finding& first = run.verdict.findings.front();
  Changes members{{first.at, first.magnitude}};
  for (const sim::EffectAt& at : first.cannot_tell_from) {
    for (const Score& score : run.verdict.ranking) {
      const Candidate& c = run.responses.test.candidates[score.candidate];
      if (c.at.id() != at.id() || members.size() >= 5) continue;
      const sim::Effect& e = *at.effect;
      members.push_back({at, std::clamp(e.null_value + score.steps * (c.probe - e.null_value), e.low, e.high)});
    }
  }
  return members;
}

PatchedModel patch_model(const GapRun& run) {
  const CaseDescription& source = run.request.source;
  if (source.engine == "energyplus") {
    PatchedModel patched = patched_energyplus(model_of(source), energyplus_options_of(source).names, run.after);
    check_patched_energyplus(patched, run.request.source.model);
    return patched;
  }
  const auto& engine = dynamic_cast<const RcEngine&>(*run.loaded.engine);
  return patched_room(model_of(source), engine.room(), run.after);
}

json change_json(const PatchedChange& patched) {
  const sim::Effect& effect = *patched.change.at.effect;
  json edits = json::array();
  for (const ModelEdit& e : patched.edits)
    edits.push_back({{"where", e.where}, {"before", e.before}, {"after", e.after}});
  return {{"id", patched.change.at.id()},
          {"text", patched.change.at.text()},
          {"magnitude", patched.change.magnitude},
          {"unit", effect.unit},
          {"null", effect.null_value},
          {"edits", edits},
          {"beside_the_model", patched.beside}};
}

json figures_json(const Guideline14& g) {
  return {{"cv_rmse_percent", g.cv_rmse_percent},
          {"nmbe_percent", g.nmbe_percent},
          {"hours", g.hours},
          {"passes", g.passes()}};
}

/// The model alone on the locked days.
json model_json(const GapRun& run, const Eigen::MatrixXd& residual) {
  const sim::Channels at = run.channels();
  const Eigen::MatrixXd& measured = run.loaded.data.test.measured;
  const ChannelErrors errors = errors_of(residual, run.locked_from(), residual.rows());
  json by_channel;
  for (int c = 0; c < at.count(); ++c) {
    by_channel[at.name(c)] = {
        {"unit", at.unit(c)}, {"rmse", finite_json(errors.rmse(c))}, {"mean", finite_json(errors.mean(c))}};
  }
  return {{"temp_rmse_k", joint_rmse(errors, 0, at.mau_temp() + 1)},
          {"power_rmse_kw", joint_rmse(errors, at.power(), at.fcu_duty())},
          {"guideline_14_room_temp",
           figures_json(guideline_14_room_temp(measured, residual, at, run.locked_from(), residual.rows()))},
          {"guideline_14_power",
           figures_json(guideline_14_power(measured, residual, at, run.locked_from(), residual.rows()))},
          {"channels", by_channel}};
}

/// Half-hour means of every channel, whether measured or not. Units are in the names.
json after_curve_json(const GapRun& run) {
  const sim::Channels at = run.channels();
  json channels;
  for (int c = 0; c < at.count(); ++c) {
    json values = json::array();
    for (const double x : run.simulated_after.col(c)) values.push_back(finite_json(std::round(x * 1e4) / 1e4));
    channels[at.name(c)] = std::move(values);
  }
  return {{"from", hal::civil_text(run.loaded.data.test.recording.from)},
          {"step_s", 86400 / bins_per_day},
          {"channels", std::move(channels)}};
}

void append_readable(const json& j, const std::string& margin, std::string& text) {
  const bool deep = j.is_object() || std::any_of(j.begin(), j.end(), [](const json& x) { return x.is_structured(); });
  if (!j.is_structured() || j.empty() || !deep) {
    text += j.dump(-1, ' ', false, json::error_handler_t::replace);
    return;
  }
  const std::string inner = margin + " ";
  text += j.is_object() ? "{" : "[";
  const char* comma = "\n";
  for (const auto& [key, value] : j.items()) {
    text += comma + inner;
    if (j.is_object()) text += json(key).dump(-1, ' ', false, json::error_handler_t::replace) + ": ";
    append_readable(value, inner, text);
    comma = ",\n";
  }
  text += "\n" + margin + (j.is_object() ? "}" : "]");
}

json period_json(const Window& window) {
  return {{"from", hal::civil_text(window.recording.from)},
          {"to", hal::civil_text(window.recording.to())},
          {"days", window.measured.rows() / bins_per_day}};
}

}  // namespace

Eigen::Index GapRun::locked_from() const {
  const Eigen::Index days = residual_given.rows() / bins_per_day;
  return (days - static_cast<Eigen::Index>(std::lround(rules.locked_share * static_cast<double>(days)))) * bins_per_day;
}

GapRun run_gap(const GapRequest& request, const std::vector<sim::Effect>& effects) {
  GapRun run;
  run.request = request;
  run.loaded = load_case(request.source, request.site, request.cache);
  require_apart(run.loaded.logs);
  run.request.source.model = request.source.model;
  const Engine& engine = *run.loaded.engine;
  const CaseData& data = run.loaded.data;
  const Library library = library_of(engine, effects);
  Progress bar("simulating every effect on " + engine.description(), 2 * runs_of(library, true));
  const auto responses = [&](const Window& window) {
    return simulate_responses(engine, library, window.recording, true, request.jobs, [&bar] { bar.advance(); });
  };
  run.responses = {responses(data.reference), responses(data.test)};
  bar.finish();

  Progress judging("fitting, comparing, checking on locked days", 2);
  run.verdict = analyse(engine, data, run.responses, run.rules, request.jobs);
  judging.advance();
  const ReferenceFit& fit = run.verdict.fit;
  const Nuisance& nuisance = run.verdict.nulls.nuisance;
  run.parameters = reference_parameters(fit, nuisance, run.responses.test);
  if (!request.findings_only) {
    for (const ReferenceParameter& p : run.parameters) run.before.push_back(p.change);
  }
  run.after = run.before;
  for (const Finding& f : run.verdict.findings) run.after.push_back({f.at, f.magnitude});
  const auto curve_of = [&](const Changes& changes) -> Eigen::MatrixXd {
    return changes.empty() ? run.responses.test.base : binned(engine.simulate(changes, data.test.recording));
  };
  const Eigen::MatrixXd simulated_before = curve_of(run.before);
  run.simulated_after = run.verdict.findings.empty() ? simulated_before : curve_of(run.after);
  run.residual_given = data.test.measured - run.responses.test.base;
  run.residual_before = data.test.measured - simulated_before;
  run.residual_after = data.test.measured - run.simulated_after;
  if (run.verdict.kind == VerdictKind::ambiguous) {
    ExperimentRules rules;
    rules.nuisance = nuisance;
    run.experiments = propose_experiments(engine, data.test, fit, run.responses.test, rivals(run), fit.changes(),
                                          request.jobs, rules);
  } else if (run.verdict.kind == VerdictKind::unknown) {
    HeatRules rules;
    rules.nuisance = nuisance;
    run.heat = reconstruct_heat(engine, data.test, fit, run.responses.test, fit.changes(), request.jobs, rules);
  }
  judging.finish();

  const bool found = !run.verdict.findings.empty();
  if (found && (run.verdict.kind == VerdictKind::named || request.best_guess)) run.patched = patch_model(run);
  return run;
}

std::string sentence_of(const GapRun& run) {
  std::string text = sentence_of(run.verdict);
  if (!run.experiments.empty()) text += ". " + sentence_of(run.experiments);
  if (run.heat) text += ". " + run.heat->text;
  return text;
}

json ledger_of(const GapRun& run) {
  const PatchedModel& patched = run.patched.value();
  json entries = json::array();
  for (std::size_t i = 0; i < patched.changes.size(); ++i) {
    json entry = change_json(patched.changes[i]);
    if (i < run.before.size()) {
      entry["role"] = "parameter";
      entry["sd"] = finite_json(run.parameters[i].sd);
      entry["why"] = "fitted to the reference period";
    } else {
      const Finding& f = run.verdict.findings[i - run.before.size()];
      const MagnitudeInterval interval = interval_of(f);
      entry["role"] = "finding";
      entry["sd"] = finite_json(f.sd);
      entry["interval"] = {interval.low, interval.high};
      entry["gain"] = f.gain;
      entry["margin"] = f.margin;
      entry["same_sign_share"] = f.same_sign;
      entry["why"] = f.why_not.empty() ? "named" : f.why_not;
      entry["class"] = json::array();
      for (const sim::EffectAt& at : f.cannot_tell_from) entry["class"].push_back(at.id());
      entry["confirm"] = f.at.effect->confirm;
    }
    entries.push_back(std::move(entry));
  }
  const json before = model_json(run, run.residual_before), after = model_json(run, run.residual_after);
  const auto locked = [](const json& j) {
    return json{{"temp_rmse_k", j["temp_rmse_k"]}, {"power_rmse_kw", j["power_rmse_kw"]}};
  };
  return {{"format", 1},
          {"site", run.request.site},
          {"engine", run.request.source.engine},
          {"model", run.request.source.model},
          {"patches", run.request.source.patches},
          {"verdict", text_of(run.verdict.kind)},
          {"reason", run.verdict.reason},
          {"gain_limit", run.verdict.gain_limit},
          {"reference", period_json(run.loaded.data.reference)},
          {"measured", period_json(run.loaded.data.test)},
          {"locked_days", {{"before", locked(before)}, {"after", locked(after)}}},
          {"digest_before", model_digest(patched.before)},
          {"digest_after", model_digest(patched.after)},
          {"entries", entries},
          {"patch", patched.patch},
          {"reverse", patched.reverse},
          {"revert", "airside gap revert LEDGER MODEL -o OUT"},
          {"command", run.request.command}};
}

json json_of(const GapRun& run) {
  const sim::Channels at = run.channels();
  json j = json_of(run.verdict, run.request.site, run.responses.test, at, run.rules);
  j["format"] = 1;
  j["sentence"] = sentence_of(run);
  j["experiments"] = json::array();
  for (const ExperimentProposal& e : run.experiments) j["experiments"].push_back(json_of(e));
  j["missing_heat"] = run.heat ? json_of(*run.heat, false) : json();
  j["model"] = {{"engine", run.request.source.engine}, {"file", run.request.source.model}};
  j["reference"] = period_json(run.loaded.data.reference);
  j["measured"] = period_json(run.loaded.data.test);
  j["locked_days"] = {{"days", (run.residual_given.rows() - run.locked_from()) / bins_per_day},
                      {"from", hal::civil_text({run.loaded.data.test.recording.from.seconds +
                                                run.locked_from() / bins_per_day * std::int64_t{86400}})},
                      {"given", model_json(run, run.residual_given)},
                      {"before", model_json(run, run.residual_before)},
                      {"after", model_json(run, run.residual_after)}};
  j["clean_up"] = json::array();
  if (!run.request.source.reference_log.empty()) j["clean_up"].push_back(json_of(run.loaded.logs.reference));
  j["clean_up"].push_back(json_of(run.loaded.logs.measured));
  j["parameters"] = json::array();
  for (const ReferenceParameter& p : run.parameters) {
    j["parameters"].push_back({{"id", p.change.at.id()},
                               {"magnitude", p.change.magnitude},
                               {"sd", finite_json(p.sd)},
                               {"unit", p.change.at.effect->unit}});
  }
  j["after_curve"] = after_curve_json(run);
  j["retraining"] = run.retraining ? json_of(*run.retraining) : json();
  j["patched"] = run.patched.has_value();
  if (run.patched) {
    j["digest_before"] = model_digest(run.patched->before);
    j["digest_after"] = model_digest(run.patched->after);
  }
  j["command"] = run.request.command;
  return j;
}

std::string readable_text(const json& j) {
  std::string text;
  append_readable(j, "", text);
  return text + "\n";
}

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

void retrain_patched(GapRun& run, const RetrainRequest& request) {
  const PatchedModel& patched = run.patched.value();
  RetrainPlan plan = retrain_plan(run.request.source, request);
  plan.patched.changes_in_model = true;
  const bool energyplus = run.request.source.engine == "energyplus";
  if (energyplus) plan.patched.changes = run.after;
  const bool stand_in = plan.measured.room.empty();
  if (stand_in) plan.measured = plan.patched;
  check_retrain_rooms(plan);
  Progress bar(fmt::format("pretraining on 2 twins x {} seeds", plan.seeds), retrain_steps(plan));
  run.retraining = retrain(plan, [&bar] { bar.advance(); });
  bar.finish();
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

void keep_patched_run(const GapRun& run, const std::filesystem::path& folder) {
  const auto* engine = dynamic_cast<const EnergyPlusEngine*>(run.loaded.engine.get());
  if (engine == nullptr) {
    throw hal::InputError("--keep-run", "an RC room", "an EnergyPlus twin", "leave --keep-run out");
  }
  sim::EnergyPlusTwin twin = engine->twin();
  twin.model = sim::merge_patched(std::move(twin.model), sim::model_patch(engine->twin().model, twin.names, run.after),
                                  "effects");
  twin.loops = sim::changed_loops(engine->twin().loops, run.after);
  const sim::Recording lived = sim::changed_recording(run.loaded.data.test.recording, run.after);
  sim::replay_energyplus(twin, lived, {.thermostats = false, .cache = {}, .keep = folder, .engine_runs = nullptr});
}

}  // namespace airside::tools::gap
