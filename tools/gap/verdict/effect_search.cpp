#include "tools/gap/verdict/effect_search.hpp"

#include <algorithm>

namespace airside::tools::gap {

namespace {

std::vector<std::size_t> candidates_of(const std::vector<Chosen>& chosen) {
  std::vector<std::size_t> candidates;
  for (const Chosen& c : chosen) candidates.push_back(c.candidate);
  return candidates;
}

}  // namespace

EffectSearch::EffectSearch(const FittedCase& c) : c_(c), unexplained_(unpatched().cost) {}

const std::vector<Refit>& EffectSearch::far(const Refit& now) const {
  const auto [at, added] = far_.try_emplace(candidates_of(now.chosen));
  Far& known = at->second;
  if (added || known.cost != now.cost) {
    const auto most = static_cast<std::size_t>(c_.rules.first_looks);
    known = {now.cost, c_.refitter.far(now, most, [&](std::size_t i) { return !c_.already(now, i); })};
  }
  return known.best;
}

/// The model with these effects, about itself; `near` it another simulated one with the same effects.
const Refit& EffectSearch::refit(const Refit& near) const {
  const auto [at, added] = refits_.try_emplace(candidates_of(near.chosen));
  if (added) at->second = c_.refitter.about_itself(c_.refitter.refit(near, near.tangent));
  return at->second;
}

const Refit& EffectSearch::unpatched() const {
  if (const auto at = refits_.find({}); at != refits_.end()) return at->second;
  const Eigen::Index parameters = std::ssize(c_.responses.test.parameters);
  return refit(c_.refitter.at({}, Eigen::VectorXd::Zero(parameters), c_.refitter.tangent()));
}

const Refit& EffectSearch::without(const Refit& now, std::size_t left_out) const {
  std::vector<Chosen> fewer = now.chosen;
  fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(left_out));
  if (fewer.empty()) return unpatched();
  if (const auto at = refits_.find(candidates_of(fewer)); at != refits_.end()) return at->second;
  return refit(c_.refitter.at(fewer, now.moved, now.tangent));
}

Refit EffectSearch::forward(const std::function<void(const Refit&)>& look) const {
  Refit now = unpatched();
  // Backward deletion may give back what forward selection took: the rounds are counted.
  for (int round = 0; round < 2 * c_.rules.most_effects && std::ssize(now.chosen) < c_.rules.most_effects; ++round) {
    const auto next = better(now);
    if (!next) break;
    now = *next;
    if (look) look(now);
  }
  return now;
}

std::optional<Refit> EffectSearch::better(const Refit& now) const {
  const std::optional<Refit> trial = tried_out(now);
  if (!trial) return std::nullopt;
  const Refit& fitted = refit(*trial);
  if (now.cost - fitted.cost < c_.limit(fitted.chosen.back().candidate) || !c_.plausible(fitted)) return std::nullopt;
  return without_superfluous(fitted);
}

std::optional<Refit> EffectSearch::tried_out(const Refit& now) const {
  std::optional<Refit> best;
  const auto keep = [&](Refit trial) {
    // What is too small is the shape of something else.
    if (c_.plausible(trial) && (!best || trial.cost < best->cost)) best = std::move(trial);
  };
  int tried = 0;
  double first_ratio = 0;
  for (const Score& score : beside(now, now.chosen.size()).scores(c_.refitter.effective(now))) {
    const double least =
        c_.limit(score.candidate) + shape_error(c_.rules, *now.tangent, now.chosen, explained(now), score.candidate);
    if (score.log_likelihood_ratio < least || c_.already(now, score.candidate)) continue;
    if (tried == 0) first_ratio = score.log_likelihood_ratio;
    if (tried >= c_.rules.first_looks || score.log_likelihood_ratio < c_.rules.first_look_share * first_ratio) break;
    ++tried;
    Refit trial = c_.refitter.add(now, score, now.tangent);
    if (now.cost - trial.cost >= least) keep(std::move(trial));
  }
  for (const Refit& start : far(now)) {
    const std::size_t candidate = start.chosen.back().candidate;
    const double least =
        c_.limit(candidate) + shape_error(c_.rules, *now.tangent, now.chosen, explained(now), candidate);
    if (now.cost - start.cost < least) break;
    keep(c_.refitter.refit(start, now.tangent));
  }
  return best;
}

/// Backward: an effect that the others have made superfluous goes.
Refit EffectSearch::without_superfluous(const Refit& now) const {
  for (std::size_t i = 0; now.chosen.size() > 1 && i + 1 < now.chosen.size(); ++i) {
    const Refit& fewer = without(now, i);
    if (fewer.cost - now.cost < c_.limit(now.chosen[i].candidate)) return fewer;
  }
  return now;
}

}  // namespace airside::tools::gap
