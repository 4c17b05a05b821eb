#include "tools/gap/run/proposed_tests.hpp"

#include <algorithm>

namespace airside::tools::gap {

Changes rivals_of(const Verdict& verdict, const Responses& responses) {
  constexpr std::size_t most_members = 5, places_of_ranking = 3;
  if (verdict.findings.empty()) return {};
  const Finding& first = verdict.findings.front();
  Changes members{{first.at, first.magnitude}};
  const auto add = [&](const Score& score) {
    const Candidate& c = responses.candidates[score.candidate];
    const sim::Effect& e = *c.at.effect;
    const double magnitude = e.null_value + score.steps * (c.probe - e.null_value);
    members.push_back({c.at, std::clamp(magnitude, e.low, e.high)});
  };
  for (const sim::EffectAt& at : first.cannot_tell_from) {
    for (const Score& score : verdict.ranking) {
      if (responses.candidates[score.candidate].at.id() == at.id() && members.size() < most_members) add(score);
    }
  }
  const auto is_member = [&](const std::string& id) {
    return std::any_of(members.begin(), members.end(), [&](const auto& m) { return m.at.id() == id; });
  };
  for (std::size_t i = 0; members.size() < 2 && i < std::min(places_of_ranking, verdict.ranking.size()); ++i) {
    if (!is_member(responses.candidates[verdict.ranking[i].candidate].at.id())) add(verdict.ranking[i]);
  }
  return members;
}

std::vector<ExperimentProposal> proposed_tests(const Engine& engine, const Window& window, const Verdict& verdict,
                                               const Responses& responses, int jobs) {
  ExperimentRules rules;
  rules.nuisance = verdict.nulls.nuisance;
  const Changes members = rivals_of(verdict, responses);
  return propose_experiments(engine, window, verdict.fit, responses, members, verdict.fit.changes(), jobs, rules);
}

bool proposes_tests(const Verdict& verdict) {
  return verdict.kind == VerdictKind::ambiguous || (verdict.kind == VerdictKind::unknown && !verdict.findings.empty());
}

nlohmann::json proposals_json(std::span<const ExperimentProposal> proposals) {
  nlohmann::json list = nlohmann::json::array();
  for (const ExperimentProposal& one : proposals) list.push_back(json_of(one));
  return list;
}

}  // namespace airside::tools::gap
