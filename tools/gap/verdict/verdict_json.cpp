#include "tools/gap/verdict/verdict_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/text/civil_text.hpp"

namespace airside::tools::gap {

namespace {

using nlohmann::json;

constexpr const char* place_kinds[] = {"floor", "facade", "zone", "vav", "fcu", "vav_pair"};

json place_json(const sim::EffectAt& at) {
  const std::string id = at.id();
  const auto mark = id.find('@');
  return mark == std::string::npos ? json(nullptr) : json(id.substr(mark + 1));
}

json buildings_json(const Verdict& v) {
  if (v.buildings == 0) return nullptr;
  return {{"drawn", v.buildings}, {"add_alone", v.buildings_add_alone}, {"add", v.buildings_add}};
}

json finding_json(const Finding& f) {
  json alike = json::array();
  for (const sim::EffectAt& at : f.cannot_tell_from) alike.push_back(at.id());
  json rivals = json::array();
  for (const Rival& r : f.rivals) rivals.push_back({{"id", r.at.id()}, {"gain", r.log_likelihood_ratio}});
  const sim::Effect& effect = *f.at.effect;
  const MagnitudeInterval interval = interval_of(f);
  return {{"id", f.at.id()},
          {"effect", effect.name},
          {"place_kind", place_kinds[static_cast<int>(effect.place)]},
          {"place", place_json(f.at)},
          {"text", f.at.text()},
          {"magnitude", f.magnitude},
          {"sd", finite_json(f.sd)},
          {"unit", effect.unit},
          {"null", effect.null_value},
          {"interval", {interval.low, interval.high}},
          {"gain", f.log_likelihood_ratio},
          {"gain_limit", f.log_likelihood_limit},
          {"gain_over_limit",
           f.log_likelihood_limit > 0 ? finite_json(f.log_likelihood_ratio / f.log_likelihood_limit) : json()},
          {"margin", f.margin},
          {"same_sign_share", f.same_sign},
          {"class", alike},
          {"rivals", rivals},
          {"why_not", f.why_not},
          {"looks_like", effect.looks_like},
          {"confirm", effect.confirm}};
}

json locked_json(const LockedDays& locked, const sim::Channels& channels) {
  if (locked.rmse_before.size() != channels.count()) return nullptr;
  json by_channel;
  for (int c = 0; c < channels.count(); ++c) {
    by_channel[channels.name(c)] = {{"unit", channels.unit(c)},
                                    {"rmse_before", finite_json(locked.rmse_before(c))},
                                    {"rmse_after", finite_json(locked.rmse_after(c))},
                                    {"mean_before", finite_json(locked.mean_before(c))},
                                    {"mean_after", finite_json(locked.mean_after(c))}};
  }
  return {{"score_before", locked.score_before},
          {"score_after", locked.score_after},
          {"score_floor", locked.score_floor},
          {"score_right", locked.score_right},
          {"gain", locked.log_likelihood_ratio},
          {"predicted_gain", locked.predicted_log_likelihood_ratio},
          {"temp_rmse_before_k", locked.temp_rmse_before_k},
          {"temp_rmse_after_k", locked.temp_rmse_after_k},
          {"power_rmse_before_kw", locked.power_rmse_before_kw},
          {"power_rmse_after_kw", locked.power_rmse_after_kw},
          {"channels", by_channel}};
}

/// Simulated candidates, and the others that are not quite improbable.
json posterior_json(const Posterior& p, const Alternatives& tried) {
  constexpr double improbable = 0.001;
  json candidates = json::array();
  for (const EffectProbability& e : p.effects) {
    const Alternative& a = tried.list[e.from];
    if (!a.simulated && e.probability < improbable) continue;
    json one = {{"id", a.at.id()},
                {"effect", a.at.effect->name},
                {"place", place_json(a.at)},
                {"text", a.at.text()},
                {"probability", e.probability},
                {"size", a.magnitude},
                {"sd", finite_json(a.sd)},
                {"gain", a.log_likelihood_ratio},
                {"gain_of_reference", a.of_reference},
                {"places", a.places},
                {"overlap", a.overlap},
                {"cosine", a.cosine},
                {"simulated", a.simulated},
                {"residual_ratio", a.simulated ? finite_json(a.residual_ratio) : json()},
                {"locked_gain", a.locked ? finite_json(a.locked_log_likelihood_ratio) : json()},
                {"locked_predicted_gain", a.locked ? finite_json(a.locked_expected) : json()},
                {"contradicted", e.vetoed}};
    candidates.push_back(std::move(one));
  }
  return {{"beside", tried.beside},
          {"candidates", candidates},
          {"nothing", p.nothing},
          {"other", p.other},
          {"set", p.set},
          {"sure", p.sure},
          {"name_needs", p.name_needs},
          {"residual_ratio", finite_json(tried.residual_ratio)},
          {"residual_ratio_chance", finite_json(tried.residual_ratio_chance)}};
}

}  // namespace

json finite_json(double value) { return std::isfinite(value) ? json(value) : json(nullptr); }

json json_of(const Verdict& v, const std::string& name, const Responses& responses, const sim::Channels& channels,
             const Rules& rules) {
  json effects = json::array(), unsure = json::array(), ranking = json::array(), ratios = json::array(),
       null_ratios = json::array(), limits = json::array();
  for (const Finding& f : v.findings) effects.push_back(finding_json(f));
  for (const Finding& f : v.unsure) unsure.push_back(finding_json(f));
  for (std::size_t i = 0; i < v.ranking.size() && i < 10; ++i) {
    ranking.push_back(responses.candidates[v.ranking[i].candidate].at.id());
    ratios.push_back(v.ranking[i].log_likelihood_ratio);
    null_ratios.push_back(v.nulls.log_likelihood_ratio.at(v.ranking[i].candidate));
    limits.push_back(log_likelihood_limit(rules, v.nulls, v.ranking[i].candidate));
  }
  json posterior = json::array();
  for (std::size_t i = 0; i < v.posteriors.size(); ++i)
    posterior.push_back(posterior_json(v.posteriors[i], v.alternatives[i]));
  return {{"case", name},
          {"posterior", posterior},
          {"verdict", text_of(v.kind)},
          {"reason", v.reason},
          {"effects", effects},
          {"unsure", unsure},
          {"ranking", ranking},
          {"ranking_gains", ratios},
          {"ranking_gains_of_reference", null_ratios},
          {"ranking_gain_limits", limits},
          {"best_gain", v.best_log_likelihood_ratio},
          {"gain_limit", v.log_likelihood_limit},
          {"leftover", finite_json(v.residual_ratio)},
          {"buildings", buildings_json(v)},
          {"thresholds",
           {{"gain", v.log_likelihood_limit},
            {"gain_anywhere", rules.log_likelihood_limit},
            {"gain_share_of_reference", rules.null_share},
            {"leftover", finite_json(v.residual_ratio_limit)}}},
          {"locked", locked_json(v.locked, channels)}};
}

json refused_json(const std::string& name, const std::string& reason) {
  return {{"case", name}, {"verdict", "refused"}, {"reason", reason}, {"effects", json::array()}};
}

json json_of(const CleanLog& log) {
  json rows = json::array();
  for (const Remark& r : log.remarks) {
    rows.push_back({{"defect", text_of(r.defect)},
                    {"action", text_of(r.action)},
                    {"column", r.column},
                    {"from", hal::civil_text(r.from)},
                    {"to", hal::civil_text(r.to)},
                    {"count", r.count},
                    {"text", r.text}});
  }
  json j = {{"log", log.place}, {"rows", log.rows.size()}, {"remarks", rows}, {"outdoor_difference", nullptr}};
  if (log.outdoor_difference) {
    const OutdoorDifference& d = *log.outdoor_difference;
    j["outdoor_difference"] = {{"mean_k", d.mean_k},
                               {"rms_k", d.rms_k},
                               {"lag_min", d.lag_min},
                               {"shifted_rms_k", d.shifted_rms_k},
                               {"irregular_k", d.irregular_k},
                               {"days", d.days},
                               {"daily_k", d.daily_k},
                               {"daily_correlation", d.daily_correlation},
                               {"other_weather", d.other_weather()}};
  }
  if (!log.rows.empty()) {
    j["from"] = hal::civil_text(log.rows.front().time);
    j["to"] = hal::civil_text(log.rows.back().time);
  }
  return j;
}

std::string sentence_of(const Finding& f) {
  std::string text = fmt::format("{}: {}", f.at.text(), magnitude_text(f));
  if (!f.cannot_tell_from.empty()) {
    std::string alike;
    for (const sim::EffectAt& at : f.cannot_tell_from) alike += (alike.empty() ? "" : "; or ") + at.text();
    text += "; the data cannot tell it from: " + alike;
  }
  return text;
}

std::string text_of(const Posterior& p, const Alternatives& tried) {
  const std::string beside = tried.beside.empty() ? "" : fmt::format(" beside {}", fmt::join(tried.beside, ", "));
  std::string text = fmt::format("how probable{} (together {} hold 90 %):\n", beside, fmt::join(p.set, ", "));
  const auto row = [&text](double probability, const std::string& what) {
    text += fmt::format("  {:>5.1f} %  {}\n", 100 * probability, what);
  };
  int rows = 0;
  for (const EffectProbability& e : p.effects) {
    if (e.probability < 0.01 || ++rows > 6) break;
    const Alternative& a = tried.list[e.from];
    row(e.probability,
        fmt::format("{}: {}{}", a.at.id(), magnitude_text(a), e.vetoed ? ", which the locked days contradict" : ""));
  }
  row(p.nothing, "nothing");
  row(p.other, "something that no effect is");
  return text;
}

std::string sentence_of(const Verdict& v) {
  std::string found;
  for (const Finding& f : v.findings) found += (found.empty() ? "" : "; and ") + sentence_of(f);
  std::string beside;
  for (const Finding& f : v.unsure)
    beside += fmt::format("{}{} ({})", beside.empty() ? "; not sure beside it: " : "; ", sentence_of(f), f.why_not);
  switch (v.kind) {
    case VerdictKind::named: return "named: " + found + beside;
    case VerdictKind::ambiguous: return fmt::format("ambiguous: perhaps {} ({})", found, v.reason);
    case VerdictKind::unknown: return "unknown: " + v.reason;
    case VerdictKind::none: return v.reason;
  }
  return v.reason;
}

std::vector<Remark> shown_remarks(const CleanLog& log) {
  const auto minor = [&log](const Remark& r) {
    return r.defect == Defect::missing_value && r.action == Action::left_out && 50 * r.count < log.rows.size();
  };
  const auto columns = std::count_if(log.remarks.begin(), log.remarks.end(), minor);
  if (columns < 3) return log.remarks;
  std::vector<Remark> shown;
  Remark all;
  std::size_t most = 0;
  for (const Remark& r : log.remarks) {
    if (!minor(r)) {
      shown.push_back(r);
      continue;
    }
    const std::size_t count = all.count + r.count;
    const CivilTime from = all.count == 0 ? r.from : std::min(all.from, r.from);
    const CivilTime to = all.count == 0 ? r.to : std::max(all.to, r.to);
    all = r;
    all.from = from;
    all.to = to;
    all.count = count;
    most = std::max(most, r.count);
  }
  all.column = fmt::format("{} columns", columns);
  all.text = fmt::format("{} values missing, at most {} in a column; left out", all.count, most);
  shown.insert(shown.begin(), all);
  return shown;
}

std::string text_of(const CleanLog& log) {
  if (log.remarks.empty()) return "";
  std::string text = fmt::format("clean-up of {}\n", log.place);
  for (const Remark& r : shown_remarks(log)) {
    text += fmt::format("  {:<9} {:<16} {:<20} {}: {}\n", text_of(r.action), text_of(r.defect),
                        r.column.empty() ? "all" : r.column, hal::civil_text(r.from).substr(0, 16), r.text);
  }
  return text;
}

}  // namespace airside::tools::gap
