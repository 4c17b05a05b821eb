#include "tools/gap/verdict/finding_judge.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <string>

namespace airside::tools::gap {

namespace {

class FindingJudge {
 public:
  FindingJudge(const FittedCase& c, const EffectSearch& search) : c_(c), search_(search) {}

  Finding finding(const Refit& now, std::size_t i) const {
    const Chosen& c = now.chosen[i];
    const Selection selection = beside(now, i);
    Finding f;
    f.at = c_.candidate(c).at;
    f.magnitude = c_.refitter.magnitude(c);
    f.sd = sd_of(c, f.magnitude, selection);
    f.share = c_.rules.magnitude_share;
    const Refit& others = search_.without(now, i);
    f.log_likelihood_ratio = others.cost - now.cost;
    f.same_sign = same_sign(others.chosen, c.candidate);
    f.log_likelihood_limit = c_.limit(c.candidate);
    return f;
  }

  /// Who may stand in the place of what `others` lack: number `i` of `now` as it is there, if there is a model with
  /// findings; the likely ones by linear responses, and those that show only when they are large, by simulation; the
  /// rest as linear responses have it.
  Alternatives alternatives(const Refit& others, const Refit* now, std::size_t i) const {
    const Selection selection(others.tangent->evidence(), places_of(others));
    const std::vector<Score> scores = selection.scores(c_.refitter.effective(others));
    std::map<std::string, Tried> tried;
    if (now != nullptr) tried.emplace(c_.candidate(now->chosen[i]).at.id(), Tried{now->chosen[i], *now, true});
    simulate(tried, others, scores);
    Alternatives all;
    for (const Chosen& c : others.chosen) all.beside.push_back(c_.candidate(c).at.id());
    all.residual_ratio = ratio_of(others);
    all.residual_ratio_chance = c_.residual_ratio_of_chance();
    for (const auto& [id, t] : tried) all.list.push_back(alternative(t, others, selection));
    for (const Score& s : scores) {
      if (c_.already(others, s.candidate) || tried.contains(candidate(s).at.id())) continue;
      Alternative a;
      a.at = candidate(s).at;
      a.candidate = s.candidate;
      a.log_likelihood_ratio = s.log_likelihood_ratio;
      a.magnitude = c_.refitter.magnitude({s.candidate, s.steps});
      a.sd = s.steps_sd * std::abs(candidate(s).probe - a.at.effect->null_value);
      a.of_reference = c_.nulls.log_likelihood_ratio[s.candidate];
      all.list.push_back(a);
    }
    std::stable_sort(all.list.begin(), all.list.end(), [](const Alternative& a, const Alternative& b) {
      return a.log_likelihood_ratio > b.log_likelihood_ratio;
    });
    const auto lead = std::ranges::find_if(all.list, [](const Alternative& a) { return a.simulated; });
    int looks = 0;
    for (Alternative& a : all.list) {
      if (lead != all.list.end()) a.cosine = std::abs(selection.cosine(lead->candidate, a.candidate));
      a.places = places_of(*a.at.effect);
      a.overlap = channel_overlap(*others.tangent, others.chosen, a.candidate);
      if (!a.simulated || ++looks > c_.rules.locked_looks) continue;
      const Predicted p = c_.refitter.predicted(tried.at(a.at.id()).refit, others);
      a.locked = true;
      a.locked_log_likelihood_ratio = p.log_likelihood_ratio;
      a.locked_expected = p.expected;
    }
    return all;
  }

 private:
  struct Tried {
    Chosen chosen;
    Refit refit;
    bool found = false;
  };

  const Candidate& candidate(const Score& s) const { return c_.responses.test.candidates[s.candidate]; }
  double ratio_of(const Refit& at) const { return at.distance / c_.samples() / c_.fit.residual_ratio; }

  static std::vector<std::size_t> places_of(const Refit& at) {
    std::vector<std::size_t> places;
    for (const Chosen& c : at.chosen) places.push_back(c.candidate);
    return places;
  }

  /// Candidates stand in pairs, one for each direction.
  int places_of(const sim::Effect& effect) const {
    const auto& all = c_.responses.test.candidates;
    return static_cast<int>(
        std::count_if(all.begin(), all.end(), [&](const Candidate& c) { return c.at.effect == &effect; }) / 2);
  }

  void simulate(std::map<std::string, Tried>& tried, const Refit& others, const std::vector<Score>& scores) const {
    const auto keep = [&](const Refit& refit) {
      const Tried trial{refit.chosen.back(), refit, false};
      const auto [at, added] = tried.try_emplace(c_.candidate(trial.chosen).at.id(), trial);
      if (!added && !at->second.found && refit.cost < at->second.refit.cost) at->second = trial;
    };
    int looks = 0;
    for (const Score& s : scores) {
      if (c_.already(others, s.candidate)) continue;
      if (++looks > c_.alternatives() || s.log_likelihood_ratio <= 1) break;
      if (!tried.contains(candidate(s).at.id())) keep(c_.refitter.add(others, s, others.tangent));
    }
    for (const Refit& start : search_.far(others)) keep(c_.refitter.refit(start, others.tangent));
  }

  Alternative alternative(const Tried& t, const Refit& others, const Selection& selection) const {
    Alternative a;
    a.at = c_.candidate(t.chosen).at;
    a.candidate = t.chosen.candidate;
    a.magnitude = c_.refitter.magnitude(t.chosen);
    a.sd = sd_of(t.chosen, a.magnitude, selection);
    a.share = c_.rules.magnitude_share;
    a.log_likelihood_ratio = others.cost - t.refit.cost;
    a.of_reference = c_.nulls.log_likelihood_ratio[t.chosen.candidate];
    a.residual_ratio = ratio_of(t.refit);
    a.simulated = true;
    a.found = t.found;
    return a;
  }

  double sd_of(const Chosen& chosen, double magnitude, const Selection& selection) const {
    const Candidate& c = c_.candidate(chosen);
    const double norm = selection.dot(chosen.candidate, chosen.candidate);
    const double null_value = c.at.effect->null_value;
    return std::hypot((c.probe - null_value) / std::sqrt(std::max(1e-12, norm)),
                      c_.rules.magnitude_share * (magnitude - null_value));
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

std::vector<Alternatives> alternatives_of(const FittedCase& c, const EffectSearch& search, const Refit& now) {
  const FindingJudge judge(c, search);
  std::vector<Alternatives> all;
  for (std::size_t i = 0; i < now.chosen.size(); ++i)
    all.push_back(judge.alternatives(search.without(now, i), &now, i));
  if (all.empty()) all.push_back(judge.alternatives(search.unpatched(), nullptr, 0));
  return all;
}

std::vector<Finding> findings_of(const FittedCase& c, const EffectSearch& search, const Refit& now) {
  const FindingJudge judge(c, search);
  std::vector<Finding> findings;
  for (std::size_t i = 0; i < now.chosen.size(); ++i) findings.push_back(judge.finding(now, i));
  return findings;
}

}  // namespace airside::tools::gap
