#include "tools/gap/verdict/decision.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace airside::tools::gap {

namespace {

constexpr double as_good_as_all = 0.5;

bool in_set(const Posterior& p, std::string_view id) { return std::ranges::find(p.set, id) != p.set.end(); }

/// "gain_base 81 %, neighbour_heat 18 %", and how many more there are.
std::string set_text(const Posterior& p) {
  constexpr std::size_t shown = 5;
  std::string text;
  for (std::size_t i = 0; i < std::min(shown, p.set.size()); ++i) {
    const std::string& id = p.set[i];
    const auto effect = std::ranges::find_if(p.effects, [&id](const auto& e) { return e.at.id() == id; });
    const double probability = id == "nothing" ? p.nothing : effect == p.effects.end() ? p.other : effect->probability;
    text += fmt::format("{}{} {:.0f} %", text.empty() ? "" : ", ", id == "other" ? "something else" : id,
                        100 * probability);
  }
  if (p.set.size() > shown) text += fmt::format(" and {} more", p.set.size() - shown);
  return text;
}

std::string why_too_small(const Finding& f) {
  const sim::Effect& e = *f.at.effect;
  return fmt::format(
      "its gain is {:.1f} x its limit, but at {:.2g} it is too near to {:g}: such an effect is {:g} or {}",
      f.log_likelihood_ratio / f.log_likelihood_limit, f.magnitude, e.null_value, e.least,
      e.least > e.null_value ? "more" : "less");
}

}  // namespace

Instead instead_of(const Finding* found, const Posterior& p) {
  if (p.effects.empty()) return Instead::nothing_else;
  if (found == nullptr) {
    const bool shows = p.likeliest() > std::max(p.nothing, p.other);
    return shows ? Instead::another : Instead::nothing_else;
  }
  if (p.nothing > as_good_as_all) return Instead::nobody;
  return p.sure && p.effects.front().at.id() != found->at.id() ? Instead::another : Instead::nothing_else;
}

void tell(Finding& f, const Posterior& p, const Alternatives& tried) {
  double next = 0;
  f.cannot_tell_from.clear();
  f.rivals.clear();
  for (const Alternative& a : tried.list) {
    if (a.at.id() == f.at.id() || !a.simulated) continue;
    next = std::max(next, a.log_likelihood_ratio);
    f.rivals.push_back({a.at, a.log_likelihood_ratio});
    if (in_set(p, a.at.id())) f.cannot_tell_from.push_back(a.at);
  }
  f.margin = next > 0 ? f.log_likelihood_ratio / next : 1e9;
  const EffectProbability* first = p.effects.empty() ? nullptr : &p.effects.front();
  const bool is_first = first != nullptr && first->at.id() == f.at.id();
  if (p.sure && is_first)
    f.why_not.clear();
  else if (is_first && first->vetoed && first->probability > as_good_as_all)
    f.why_not = "the locked days contradict it";
  else if (is_first && !f.at.effect->plausible(f.magnitude))
    f.why_not = why_too_small(f);
  else
    f.why_not = "not sure: " + set_text(p);
}

Decision decision_of(const std::vector<Finding>& findings, const std::vector<Posterior>& posteriors, bool more_needed) {
  const auto count =
      static_cast<std::size_t>(std::ranges::count_if(findings, [](const Finding& f) { return f.why_not.empty(); }));
  const Posterior& first = posteriors.front();
  const double effects = 1 - first.nothing - first.other;
  if (more_needed)
    return {VerdictKind::unknown,
            fmt::format("after {} effects another would still gain: something else is missing", findings.size())};
  if (count > 0) return {VerdictKind::named, "no other explanation is probable"};
  if (first.other > std::max(first.nothing, effects))
    return {VerdictKind::unknown, fmt::format("no effect explains it well: {}", set_text(first))};
  if (!findings.empty()) return {VerdictKind::ambiguous, findings.front().why_not};
  const bool alone = first.set.size() <= 1;
  return {VerdictKind::none, "no gap above the floor" + (alone ? "" : fmt::format(" ({})", set_text(first)))};
}

}  // namespace airside::tools::gap
