#include "tools/gap/verdict/outlook.hpp"

#include <algorithm>

namespace airside::tools::gap {

namespace {

/// Whether another single effect does so nearly as well as the best that a test on site must tell them apart.
bool has_rival(const FittedCase& c, const std::vector<Score>& scores, const Score& best) {
  const double least = best.log_likelihood_ratio - sure_excess(best.log_likelihood_ratio, c.constants());
  return std::any_of(scores.begin(), scores.end(), [&](const Score& other) {
    return other.candidate != best.candidate && other.log_likelihood_ratio > least;
  });
}

}  // namespace

Outlook outlook_of(const FittedCase& c, const Refit& now, double explained) {
  Outlook outlook;
  outlook.found = static_cast<int>(now.chosen.size());
  const Eigen::VectorXd r = c.refitter.effective(now);
  Refit then{now.chosen, {}, {}, 0, 0, now.tangent};
  double left = now.distance;
  while (std::ssize(then.chosen) < c.rules.most_effects) {
    const Selection selection = beside(then, then.chosen.size());
    const std::vector<Score> scores = selection.scores(r);
    const auto best = std::find_if(scores.begin(), scores.end(),
                                   [&](const Score& score) { return !c.already(then, score.candidate); });
    if (best == scores.end()) break;
    const double gain = best->log_likelihood_ratio;
    if (gain < c.limit(best->candidate) + shape_error(c.rules, *now.tangent, then.chosen, explained, best->candidate))
      break;
    if (then.chosen.empty()) outlook.alike = has_rival(c, scores, *best);
    then.chosen.push_back({best->candidate, best->steps});
    explained += gain;
    left -= gain;
    ++outlook.more;
  }
  const double noise = c.samples() * c.fit.residual_ratio;
  outlook.unknown = left / noise > c.residual_ratio_of_chance() + c.constants().shape_share * explained / noise;
  return outlook;
}

Outlook first_outlook(const FittedCase& c) {
  const Eigen::Index parameters = std::ssize(c.responses.test.parameters);
  return outlook_of(c, c.refitter.at({}, Eigen::VectorXd::Zero(parameters), c.refitter.tangent()), 0);
}

}  // namespace airside::tools::gap
