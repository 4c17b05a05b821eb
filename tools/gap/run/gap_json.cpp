#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/text/civil_text.hpp"
#include "tools/gap/map/mapping.hpp"
#include "tools/gap/model/stretches.hpp"
#include "tools/gap/run/detectable.hpp"
#include "tools/gap/run/gap_inputs.hpp"
#include "tools/gap/run/gap_run.hpp"
#include "tools/gap/verdict/verdict_json.hpp"

namespace airside::tools::gap {

namespace {

using nlohmann::json;

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
          {"hours", g.count},
          {"passes", g.passes()}};
}

/// Of each meter; no monthly figures where there are not two months.
json meters_json(const GapRun& run, const Eigen::MatrixXd& residual) {
  const sim::Channels at = run.channels();
  const Window& test = run.loaded.data.test;
  json meters = json::object();
  for (int c = at.power(); c < at.fcu_duty(); ++c) {
    const MeterFigures f =
        guideline_14_meter(test.measured, residual, test.recording, c, run.locked_from(), residual.rows());
    const json monthly = {{"cv_rmse_percent", f.monthly.cv_rmse_percent},
                          {"nmbe_percent", f.monthly.nmbe_percent},
                          {"months", f.monthly.count},
                          {"passes", f.monthly.passes_monthly()}};
    meters[at.name(c)] = {{"hourly", figures_json(f.hourly)}, {"monthly", f.monthly.count > 1 ? monthly : json()}};
  }
  return meters;
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
          {"guideline_14_meters", meters_json(run, residual)},
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
  json later = json::array();
  for (const sim::LaterStretch& stretch : run.loaded.data.test.recording.later)
    later.push_back({{"step", stretch.row / rows_per_bin}, {"from", hal::civil_text(stretch.from)}});
  return {{"from", hal::civil_text(run.loaded.data.test.recording.from)},
          {"later", later},
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

/// Sizes from which effects stand out.
json detectable_json(const GapRun& run) {
  json list = json::array();
  for (const Detectable& d : detectable_sizes(run)) {
    list.push_back({{"id", d.at.id()},
                    {"size", finite_json(d.size)},
                    {"unit", d.at.effect->unit},
                    {"bound", d.bound},
                    {"visible", d.visible}});
  }
  return list;
}

json period_json(const Window& window) {
  if (window.measured.rows() == 0) return nullptr;
  const Span span = span_of(window.recording);
  return {{"from", hal::civil_text(span.from)},
          {"to", hal::civil_text(span.to)},
          {"days", window.measured.rows() / bins_per_day}};
}

}  // namespace

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
      entry["gain"] = f.log_likelihood_ratio;
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
          {"gain_limit", run.verdict.log_likelihood_limit},
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
  j["missing_power"] = run.heat ? json_of(run.meter_offsets, at) : json();
  j["model"] = {{"engine", run.request.source.engine}, {"file", run.request.source.model}};
  j["reference"] = period_json(run.loaded.data.reference);
  j["measured"] = period_json(run.loaded.data.test);
  j["locked_days"] = {{"days", (run.residual_given.rows() - run.locked_from()) / bins_per_day},
                      {"from", hal::civil_text(run.loaded.data.test.recording.time(
                                   static_cast<std::size_t>(run.locked_from()) * rows_per_bin))},
                      {"given", model_json(run, run.residual_given)},
                      {"before", model_json(run, run.residual_before)},
                      {"after", model_json(run, run.residual_after)}};
  j["clean_up"] = json::array();
  if (!run.request.source.reference_log.empty()) j["clean_up"].push_back(json_of(run.loaded.logs.reference));
  j["clean_up"].push_back(json_of(run.loaded.logs.measured));
  for (const AddedDays& added : run.added) j["clean_up"].push_back(json_of(added.log));
  j["parameters"] = json::array();
  for (const ReferenceParameter& p : run.parameters) {
    j["parameters"].push_back({{"id", p.change.at.id()},
                               {"magnitude", p.change.magnitude},
                               {"sd", finite_json(p.sd)},
                               {"unit", p.change.at.effect->unit}});
  }
  j["energy"] = json::array();
  for (std::size_t i = 0; i < run.energy.size(); ++i)
    j["energy"].push_back(json_of(run.energy[i], run.verdict.findings[i], at, run.request.price));
  j["after_curve"] = after_curve_json(run);
  j["far_parameters"] = json::array();
  for (const FarParameter& p : far_parameters(run))
    j["far_parameters"].push_back(
        {{"id", p.change.at.id()}, {"magnitude", p.change.magnitude}, {"prior_sds", p.prior_sds}});
  j["stand_in"] = run.loaded.engine->stand_in().has_value();
  j["own_control"] = run.loaded.engine->plays_commands() ? json() : json(own_control_text(*run.loaded.engine));
  if (!run.request.source.map.empty()) j["map"] = json_of(read_mapping(run.request.source.map));
  j["not_applicable"] = json::array();
  for (const NotApplicable& n : run.not_applicable) j["not_applicable"].push_back({{"id", n.id}, {"why", n.why}});
  j["detectable"] = detectable_json(run);
  j["tried"] = suspicions_json(run);
  j["inputs"] = inputs_json(run.request);
  j["continued"] = continued_json(run);
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

}  // namespace airside::tools::gap
