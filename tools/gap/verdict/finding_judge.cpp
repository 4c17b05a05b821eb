#include "tools/gap/verdict/finding_judge.hpp"

#include <algorithm>
#include <cmath>

namespace airside::tools::gap {

namespace {

class FindingJudge {
 public:
  FindingJudge(const FittedCase& c, const EffectSearch& search) : c_(c), search_(search) {}

  Finding finding(const Refit& now, std::size_t i) const {
    const Chosen& c = now.chosen[i];
    const Candidate& chosen = c_.candidate(c);
    const Selection selection = beside(now, i);
    Finding f;
    f.at = chosen.at;
    f.magnitude = c_.refitter.magnitude(c);
    const double norm = selection.dot(c.candidate, c.candidate);
    const double step = chosen.probe - chosen.at.effect->null_value;
    f.sd = std::hypot(step / std::sqrt(std::max(1e-12, norm)),
                      c_.rules.magnitude_share * (f.magnitude - chosen.at.effect->null_value));
    const Refit& others = search_.without(now, i);
    f.log_likelihood_ratio = others.cost - now.cost;
    f.same_sign = same_sign(others.chosen, c.candidate);
    const double rival = add_rivals(f, now, others, selection, c.candidate);
    f.margin = rival > 0 ? f.log_likelihood_ratio / rival : 1e9;
    f.log_likelihood_limit = c_.limit(c.candidate);
    if (f.log_likelihood_ratio < f.log_likelihood_limit)
      f.why_not = "its gain is within the noise";
    else if (f.log_likelihood_ratio < rival + c_.rules.margin_log_likelihood)
      f.why_not = "another effect explains nearly as much";
    else if (!f.cannot_tell_from.empty())
      f.why_not = "effects of one class: the data cannot tell them apart";
    else if (f.same_sign < c_.rules.same_sign_share)
      f.why_not = "its sign changes from day to day";
    return f;
  }

 private:
  /// Every other effect in its stead, the likely ones by real simulation: who does nearly as well joins the class.
  /// Returns the gain of the best that does not look the same.
  double add_rivals(Finding& f, const Refit& now, const Refit& others, const Selection& selection,
                    std::size_t found) const {
    const auto scores = selection.scores(c_.refitter.effective(others));
    double best = 0;
    int tried = 0;
    std::vector<sim::EffectAt> nearly;
    for (const Score& s : scores) {
      const Candidate& other = c_.responses.test.candidates[s.candidate];
      if (other.at.id() == f.at.id() || c_.already(others, s.candidate)) continue;
      if (++tried > c_.rules.rivals) break;
      const Refit in_its_stead = c_.refitter.add(others, s, now.tangent);
      if (!c_.plausible(in_its_stead)) continue;
      const double log_likelihood_ratio = others.cost - in_its_stead.cost;
      const Rival rival{other.at, log_likelihood_ratio, selection.cosine(found, s.candidate)};
      f.rivals.push_back(rival);
      const bool alike = std::abs(rival.cosine) > c_.rules.class_cosine;
      if (!alike) best = std::max(best, rival.log_likelihood_ratio);
      if (rival.log_likelihood_ratio < c_.rules.rival_share * f.log_likelihood_ratio) continue;
      if (alike ||
          f.log_likelihood_ratio - rival.log_likelihood_ratio < least_excess(c_.rules, f.log_likelihood_ratio, rival))
        f.cannot_tell_from.push_back(other.at);
      if (f.log_likelihood_ratio < c_.rules.class_ratio * rival.log_likelihood_ratio) nearly.push_back(other.at);
    }
    // Once it is a class, all that do nearly as well are in it.
    if (!f.cannot_tell_from.empty()) {
      for (const sim::EffectAt& at : nearly) {
        const bool listed = std::any_of(f.cannot_tell_from.begin(), f.cannot_tell_from.end(),
                                        [&at](const sim::EffectAt& other) { return other.id() == at.id(); });
        if (!listed) f.cannot_tell_from.push_back(at);
      }
    }
    return best;
  }

  /// A magnitude for every two days, each counted by its information; seen from the reference's model, as another one
  /// has moved its parameters to where the effect is not missed.
  double same_sign(const std::vector<Chosen>& others, std::size_t candidate) const {
    std::vector<std::size_t> places;
    for (const Chosen& c : others) places.push_back(c.candidate);
    const Selection selection(c_.refitter.tangent()->evidence(), places);
    const Eigen::VectorXd r = c_.refitter.whiten(c_.refitter.unmoved_residual(others));
    const auto z = c_.refitter.tangent()->evidence().response(candidate);
    const Eigen::Index block = 2 * bins_per_day * c_.data.test.measured.cols();
    const Eigen::Index count = (z.size() + block - 1) / block;
    Eigen::MatrixXd by_block = Eigen::MatrixXd::Zero(z.size(), count), m(z.size(), count);
    for (Eigen::Index b = 0; b < count; ++b) {
      const Eigen::Index n = std::min(block, z.size() - b * block);
      by_block.col(b).segment(b * block, n) = z.segment(b * block, n);
      m.col(b) = selection.times(by_block.col(b));
    }
    Eigen::MatrixXd information = m.transpose() * by_block;
    information.diagonal().array() += 1e-9 * information.trace();  // blocks in which it does not show
    const Eigen::MatrixXd covariance = information.ldlt().solve(Eigen::MatrixXd::Identity(count, count));
    const Eigen::VectorXd steps = covariance * (m.transpose() * r);
    double all = 0, agree = 0;
    for (Eigen::Index b = 0; b < count; ++b) {
      const double weight = 1 / covariance(b, b);
      all += weight;
      if (steps(b) > 0) agree += weight;
    }
    return all > 0 ? agree / all : 1;
  }

  const FittedCase& c_;
  const EffectSearch& search_;
};

}  // namespace

std::vector<Finding> findings_of(const FittedCase& c, const EffectSearch& search, const Refit& now) {
  const FindingJudge judge(c, search);
  std::vector<Finding> findings;
  for (std::size_t i = 0; i < now.chosen.size(); ++i) findings.push_back(judge.finding(now, i));
  return findings;
}

}  // namespace airside::tools::gap
