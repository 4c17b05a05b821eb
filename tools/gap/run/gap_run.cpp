#include "tools/gap/run/gap_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/text/input_error.hpp"
#include "sim/json/merge_patch.hpp"
#include "tools/gap/model/energyplus_engine.hpp"
#include "tools/gap/model/stretches.hpp"
#include "tools/gap/run/gap_stages.hpp"
#include "tools/gap/run/more_days.hpp"
#include "tools/gap/run/proposed_tests.hpp"
#include "tools/gap/surrogate/asked_model.hpp"
#include "tools/gap/verdict/verdict_json.hpp"

namespace airside::tools::gap {

namespace {

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

PatchedModel patch_model(const GapRun& run) {
  const CaseDescription& source = run.request.source;
  if (source.engine == "energyplus") {
    const sim::EnergyPlusOptions options = energyplus_options_of(source);
    PatchedModel patched = patched_energyplus(model_of(source), options.names, run.after, options.own);
    check_patched_energyplus(patched, run.request.source.model);
    return patched;
  }
  const auto& engine = dynamic_cast<const RcEngine&>(*run.loaded.engine);
  return patched_room(model_of(source), engine.room(), run.after);
}

/// What differs in weather, clock or sensors alone takes no energy.
bool changes_building(const sim::Effect& e) { return !e.rc.empty() || !e.energyplus.empty() || !e.any_model.empty(); }

/// What each finding costs, beside the others.
void weigh_energy(GapRun& run, const Engine& engine, const Eigen::MatrixXd& simulated_before) {
  const Window& test = run.loaded.data.test;
  const std::vector<Finding>& findings = run.verdict.findings;
  for (std::size_t i = 0; i < findings.size(); ++i) {
    if (!changes_building(*findings[i].at.effect)) {
      run.energy.emplace_back();
      continue;
    }
    Changes fewer = run.after;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(run.before.size() + i));
    const Eigen::MatrixXd without =
        findings.size() == 1 ? simulated_before : binned(engine.simulate(fewer, test.recording), engine.channels());
    run.energy.push_back(energy_of(findings[i], run.simulated_after, without, engine.channels()));
  }
}

/// Parameters, changes, and the curves and residuals of the model without and with them.
void simulate_curves(GapRun& run, const Engine& engine) {
  const Window& test = run.loaded.data.test;
  run.parameters = reference_parameters(run.verdict.fit, run.verdict.nulls.nuisance, run.responses.test);
  if (!run.request.findings_only) {
    for (const ReferenceParameter& p : run.parameters) run.before.push_back(p.change);
  }
  run.after = run.before;
  for (const Finding& f : run.verdict.findings) run.after.push_back({f.at, f.magnitude});
  const auto curve_of = [&](const Changes& changes) -> Eigen::MatrixXd {
    return changes.empty() ? run.responses.test.base
                           : binned(engine.simulate(changes, test.recording), engine.channels());
  };
  const Eigen::MatrixXd simulated_before = curve_of(run.before);
  run.simulated_after = run.verdict.findings.empty() ? simulated_before : curve_of(run.after);
  run.residual_given = test.measured - run.responses.test.base;
  run.residual_before = test.measured - simulated_before;
  run.residual_after = test.measured - run.simulated_after;
  weigh_energy(run, engine, simulated_before);
}

/// The model alone with each suspicion.
void simulate_suspicions(GapRun& run, const Engine& engine) {
  const Window& test = run.loaded.data.test;
  for (Suspicion& s : run.suspicions) {
    Changes changes = run.before;
    changes.push_back(s.tried.asked);
    s.residual = test.measured - binned(engine.simulate(changes, test.recording), engine.channels());
  }
}

/// The test that tells the candidates apart, or the heat that is missing.
void explain(GapRun& run, const Engine& engine) {
  const Verdict& v = run.verdict;
  const Window& test = run.loaded.data.test;
  const Changes fitted = v.fit.changes();
  if (v.kind == VerdictKind::ambiguous) {
    run.experiments = proposed_tests(engine, test, v, run.responses.test, run.request.jobs);
  } else if (v.kind == VerdictKind::unknown) {
    HeatRules rules;
    rules.nuisance = v.nulls.nuisance;
    run.heat = reconstruct_heat(engine, test, v.fit, run.responses.test, fitted, run.request.jobs, rules);
    const Eigen::MatrixXd with_heat =
        binned(engine.simulate(fitted, heated(test.recording, run.heat->heat_kw)), engine.channels());
    run.meter_offsets = meter_offsets(test.measured - with_heat - v.fit.structural(run.responses.test), test.recording,
                                      engine.channels());
  }
}

}  // namespace

Eigen::Index GapRun::locked_from() const { return gap::locked_from(rules, residual_given.rows()); }

GapRun run_gap(const GapRequest& request, const std::vector<sim::Effect>& effects, StagedProgress& progress) {
  GapRun run;
  run.request = request;
  run.loaded = load_case(request.source, request.site, request.cache);
  AskedModel asked(
      *run.loaded.engine, [&progress] { progress.advance(); }, [&progress] { progress.advance(replays_of_dear_run); });
  const Engine& engine = asked.engine();
  run.rules.buildings = request.buildings.value_or(engine.usual_buildings());
  run.request.buildings = run.rules.buildings;
  require_apart(run.loaded.logs);
  add_more_days(run, effects);
  fmt::print(stderr, "{}", warnings_text(run));  // before minutes of simulations, not only in their report
  Changes tries;
  for (const std::string& text : request.tries) tries.push_back(parse_tried(text, effects, *run.loaded.engine));
  const CaseData& data = run.loaded.data;
  if (!data.has_reference()) run.request.findings_only = true;  // nothing was fitted to days without an effect
  const Library library = library_of(engine, effects);
  run.not_applicable = library.not_applicable;
  const GapStages stages(engine, library, static_cast<int>(data.test.measured.rows() / bins_per_day), request.jobs,
                         run.rules.buildings, asked.by_surrogate());
  progress.start("comparing the log with " + run.loaded.engine->description(), stages.stages());
  run.responses = asked.responses(library, data, request.jobs);
  progress.enter(GapStage::fitting);
  const auto look = [&](const Outlook& outlook) {
    progress.expect(GapStage::searching, stages.search(outlook));
    progress.expect(GapStage::explaining, stages.explanation(outlook));
    if (outlook.searching && outlook.found == 0) progress.enter(GapStage::searching);
  };
  const auto try_all = [&](const Analysed& analysed) {
    for (const sim::EffectChange& suspected : tries) run.suspicions.push_back({try_effect(analysed, suspected), {}});
  };
  run.verdict = asked.analyse(data, run.responses, run.rules, request.jobs, look, try_all);
  const bool has_rivals = rivals_of(run.verdict, run.responses.test).size() > 1;
  progress.expect(GapStage::explaining, stages.explanation(run.verdict.kind, has_rivals));
  progress.enter(GapStage::explaining);
  simulate_curves(run, asked.model());
  simulate_suspicions(run, asked.model());
  explain(run, engine);
  progress.finish();

  const bool found = !run.verdict.findings.empty();
  if (found && (run.verdict.kind == VerdictKind::named || request.best_guess)) run.patched = patch_model(run);
  return run;
}

std::vector<FarParameter> far_parameters(const GapRun& run) {
  constexpr double far = 2;
  std::vector<FarParameter> list;
  if (run.loaded.data.has_reference()) return list;
  const std::vector<Parameter>& parameters = run.responses.test.parameters;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const sim::Effect& e = *parameters[i].at.effect;
    const double sds = run.verdict.moved(static_cast<Eigen::Index>(i));
    if (std::abs(sds) < far) continue;
    list.push_back({{parameters[i].at, std::clamp(e.null_value + sds * parameters[i].prior_sd, e.low, e.high)}, sds});
  }
  std::ranges::sort(list, [](const auto& a, const auto& b) { return std::abs(a.prior_sds) > std::abs(b.prior_sds); });
  return list;
}

std::string no_reference_text(const GapRun& run) {
  if (run.loaded.data.has_reference()) return "";
  std::string far;
  for (const FarParameter& p : far_parameters(run)) {
    far += fmt::format("{}{} {:.3g}{} ({:.1f} standard deviations of its prior)", far.empty() ? "" : ", ",
                       p.change.at.text(), p.change.magnitude, unit_suffix(*p.change.at.effect), p.prior_sds);
  }
  return "there was no reference period, so whatever the twin's parameters may be off by their priors counts against "
         "every effect" +
         (far.empty() ? "" : "; these days want parameters far from there: " + far);
}

std::vector<const CleanLog*> logs_of(const GapRun& run) {
  std::vector<const CleanLog*> logs{&run.loaded.logs.reference, &run.loaded.logs.measured};
  for (const AddedDays& added : run.added) logs.push_back(&added.log);
  return logs;
}

std::string warnings_text(const GapRun& run) {
  std::string text;
  for (const CleanLog* log : logs_of(run)) text += warnings_text(*log);
  return text;
}

std::string other_weather_text(const GapRun& run) {
  std::string text;
  for (const CleanLog* log : logs_of(run)) {
    if (!log->outdoor_difference || !log->outdoor_difference->other_weather()) continue;
    text += fmt::format("{}{} ({:.1f} K rms)", text.empty() ? "" : " and ", log->place, log->outdoor_difference->rms_k);
  }
  if (text.empty()) return "";
  return fmt::format(
      "all this is in doubt, since {} is hardly the weather of the days of the log: its outdoor "
      "temperature differs from that of {}, so its sun, humidity and wind may be those of other days; "
      "give the weather of these days (--weather)",
      run.request.source.weather, text);
}

std::string sentence_of(const GapRun& run) {
  const std::string continued = continued_text(run);
  std::string text = continued.empty() ? sentence_of(run.verdict) : continued + ". " + sentence_of(run.verdict);
  if (run.verdict.kind == VerdictKind::named) {
    for (std::size_t i = 0; i < run.energy.size(); ++i) {
      const std::string energy = sentence_of(run.energy[i], run.request.price);
      const Finding& f = run.verdict.findings[i];
      const std::string name = run.energy.size() > 1 ? f.at.id() + ": " : "";
      text += "; " + name + (energy.empty() ? "" : energy + "; ") + "to confirm it on site: " + f.at.effect->confirm;
    }
  }
  const std::string no_reference = no_reference_text(run);
  if (!no_reference.empty()) text += "; " + no_reference;
  const std::string other_weather = other_weather_text(run);
  if (!other_weather.empty()) text += "; " + other_weather;
  if (!run.experiments.empty()) text += "; " + sentence_of(run.experiments);
  if (run.heat) text += ". " + run.heat->text;
  const std::string meters = text_of(run.meter_offsets);
  if (!meters.empty()) text += "; beside it " + meters;
  return text;
}

void keep_patched_run(const GapRun& run, const std::filesystem::path& folder) {
  const auto* engine = dynamic_cast<const EnergyPlusEngine*>(run.loaded.engine.get());
  if (engine == nullptr) {
    throw hal::InputError("--keep-run", "an RC room", "an EnergyPlus twin", "leave --keep-run out");
  }
  const sim::EnergyPlusTwin twin = engine->changed_twin(run.after);
  const sim::Recording& days = run.loaded.data.test.recording;
  const std::size_t first_stretch = days.later.empty() ? days.rows.size() : days.later.front().row;
  const sim::Recording lived = sim::changed_recording(part_of(days, 0, first_stretch), run.after);
  sim::replay_energyplus(twin, lived, {.thermostats = false, .cache = {}, .keep = folder, .engine_runs = nullptr});
}

}  // namespace airside::tools::gap
