// An earlier verdict beside the one that more days led to.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "hal/text/civil_text.hpp"
#include "tools/gap/run/gap_inputs.hpp"
#include "tools/gap/verdict/verdict_json.hpp"

namespace airside::tools::gap {

namespace {

using nlohmann::json;

constexpr std::size_t first_places = 3, most_candidates = 10;

void add_id(std::vector<std::string>& ids, const std::string& id) {
  if (ids.size() < most_candidates && std::find(ids.begin(), ids.end(), id) == ids.end()) ids.push_back(id);
}

/// What was found, what is not separable from it, and the first of the ranking.
void add_candidates(std::vector<std::string>& ids, const json& verdict) {
  for (const char* list : {"effects", "unsure"}) {
    for (const json& effect : verdict.at(list)) {
      add_id(ids, effect.at("id"));
      for (const json& alike : effect.at("class")) add_id(ids, alike);
    }
  }
  const json& ranking = verdict.at("ranking");
  for (std::size_t i = 0; i < ranking.size() && i < first_places; ++i) add_id(ids, ranking[i]);
}

double gain_of(const json& verdict, const std::string& id) {
  for (const char* list : {"effects", "unsure"}) {
    for (const json& effect : verdict.at(list)) {
      if (effect.at("id") == id) return effect.at("gain");
    }
  }
  for (const json& effect : verdict.at("effects")) {
    for (const json& rival : effect.at("rivals")) {
      if (rival.at("id") == id) return rival.at("gain");
    }
  }
  const json& ranking = verdict.at("ranking");
  const auto at = std::find(ranking.begin(), ranking.end(), json(id));
  if (at == ranking.end()) return std::numeric_limits<double>::quiet_NaN();
  return verdict.at("ranking_gains").at(static_cast<std::size_t>(at - ranking.begin()));
}

long days_of(const Window& window) { return static_cast<long>(window.measured.rows() / bins_per_day); }

}  // namespace

std::vector<CandidateBeforeAfter> candidates_before_after(const GapRun& run) {
  if (run.request.earlier.is_null()) return {};
  const json& before = run.request.earlier;
  const json after = json_of(run.verdict, run.request.site, run.responses.test, run.channels(), run.rules);
  std::vector<std::string> ids;
  add_candidates(ids, after);
  add_candidates(ids, before);
  std::vector<CandidateBeforeAfter> candidates;
  for (const std::string& id : ids) {
    CandidateBeforeAfter c{id, gain_of(before, id), gain_of(after, id), std::numeric_limits<double>::quiet_NaN()};
    for (std::size_t k = 0; k < run.responses.test.candidates.size(); ++k) {
      if (run.responses.test.candidates[k].at.id() == id)
        c.limit = log_likelihood_limit(run.rules, run.verdict.nulls, k);
    }
    candidates.push_back(c);
  }
  return candidates;
}

std::string continued_text(const GapRun& run) {
  if (run.request.earlier.is_null() || run.added.empty()) return "";
  const AddedDays& last = run.added.back();
  const std::string test = last.test.empty() ? "" : fmt::format(", in which the test {} was done", last.test);
  const long days = days_of(last.window);
  return fmt::format("with {} more day{}{}: {} -> {}", days, days == 1 ? "" : "s", test,
                     run.request.earlier.at("verdict").get<std::string>(), text_of(run.verdict.kind));
}

json continued_json(const GapRun& run) {
  if (run.request.earlier.is_null() || run.added.empty()) return nullptr;
  json added = json::array(), candidates = json::array();
  for (const AddedDays& more : run.added) {
    added.push_back({{"log", more.log.place},
                     {"test", more.test},
                     {"from", hal::civil_text(more.window.recording.from)},
                     {"to", hal::civil_text(more.window.recording.to())},
                     {"days", days_of(more.window)}});
  }
  for (const CandidateBeforeAfter& c : candidates_before_after(run)) {
    candidates.push_back({{"id", c.id},
                          {"gain_before", finite_json(c.before)},
                          {"gain_after", finite_json(c.after)},
                          {"gain_limit", finite_json(c.limit)}});
  }
  const json& earlier = run.request.earlier;
  return {
      {"sentence", continued_text(run)},
      {"earlier",
       {{"verdict", earlier.at("verdict")}, {"sentence", earlier.at("sentence")}, {"report", earlier.at("report")}}},
      {"added", added},
      {"candidates", candidates}};
}

}  // namespace airside::tools::gap
