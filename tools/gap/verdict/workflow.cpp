#include "tools/gap/verdict/workflow.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include "tools/gap/inference/refit.hpp"

namespace airside::tools::gap {

namespace {

class Analysis {
 public:
  Analysis(const Engine& engine, const CaseData& data, const WindowResponses& responses, const Rules& rules, int jobs)
      : engine_(engine),
        data_{evidence_of(data.reference, engine.channels()), evidence_of(data.test, engine.channels())},
        responses_(responses),
        rules_(rules),
        fit_(fit_reference(engine, responses.reference, data_.reference, jobs)),
        kept_(train_bins()),
        nulls_(null_blocks(fit_, responses.reference, data_.reference)),
        refitter_(engine, data_.test, responses.test, fit_, nulls_.nuisance, kept_, jobs) {}

  Verdict run() {
    Verdict verdict;
    verdict.fit = fit_;
    verdict.nulls = nulls_;
    Refit now = unpatched();
    unexplained_ = now.cost;
    verdict.residual_before = refitter_.unmoved_residual({});
    verdict.ranking = Selection(now.tangent->evidence()).scores(refitter_.effective(now));
    if (!verdict.ranking.empty()) {
      verdict.best_gain = verdict.ranking.front().gain;
      verdict.gain_limit = limit(verdict.ranking.front().candidate);
    }
    // Backward deletion may give back what forward selection took: the rounds are counted.
    for (int round = 0; round < 2 * rules_.most_effects && std::ssize(now.chosen) < rules_.most_effects; ++round) {
      const auto next = better(now);
      if (!next) break;
      now = *next;
    }
    verdict.findings = findings_of(now);
    for (auto weak = weak_finding(now, verdict.findings); weak; weak = weak_finding(now, verdict.findings)) {
      now = without(now, static_cast<std::size_t>(*weak));
      verdict.findings = findings_of(now);
    }
    // One effect after another: what the last one adds must help on days that nobody looked at.
    while (now.chosen.size() > 1) {
      const Refit& fewer = without(now, now.chosen.size() - 1);
      if (refitter_.predicted(now, fewer).gain > 0) break;
      now = fewer;
      verdict.findings = findings_of(now);
    }
    verdict.residual_after = refitter_.unmoved_residual(now.chosen);
    more_needed_ = std::ssize(now.chosen) == rules_.most_effects && better(now).has_value();
    verdict.leftover = now.distance / samples() / fit_.leftover;
    const double explained = (unexplained_ - now.cost) / samples() / fit_.leftover;
    verdict.leftover_limit = leftover_of_chance() + rules_.shape_share * explained;
    if (!verdict.findings.empty()) verdict.gain_limit = verdict.findings.front().gain_limit;
    judge(verdict, now);
    return verdict;
  }

 private:
  Eigen::Index bins() const { return data_.test.measured.rows(); }
  Eigen::Index locked_from() const {
    const auto days = bins() / bins_per_day;
    return (days - static_cast<Eigen::Index>(std::lround(rules_.locked_share * static_cast<double>(days)))) *
           bins_per_day;
  }
  std::vector<bool> train_bins() const {
    auto kept = counted_bins(bins());
    std::fill(kept.begin() + locked_from(), kept.end(), false);
    return kept;
  }
  /// What is left scatters the more the fewer days are fitted.
  double leftover_of_chance() const {
    const double days = std::max(1.0, static_cast<double>(std::count(kept_.begin(), kept_.end(), true)) / bins_per_day);
    return 1 + (rules_.leftover_limit - 1) * std::sqrt(std::max(1.0, rules_.leftover_days / days));
  }
  double samples() const {
    const auto r = refitter_.whiten(data_.test.measured - responses_.test.base);
    return std::max(1.0, static_cast<double>((r.array() != 0).count()));
  }
  const Candidate& candidate(const Chosen& c) const { return responses_.test.candidates[c.candidate]; }
  /// The model with these effects, about itself; `near` it another simulated one with the same effects.
  const Refit& refit(const Refit& near) const {
    std::vector<std::size_t> key;
    for (const Chosen& c : near.chosen) key.push_back(c.candidate);
    const auto [at, added] = refits_.try_emplace(key);
    if (added) at->second = refitter_.about_itself(refitter_.refit(near, near.tangent));
    return at->second;
  }
  const Refit& unpatched() const {
    if (const auto at = refits_.find({}); at != refits_.end()) return at->second;
    return refit(refitter_.at({}, Eigen::VectorXd::Zero(parameter_count()), refitter_.tangent()));
  }
  /// Without one of its effects.
  const Refit& without(const Refit& now, std::size_t left_out) const {
    std::vector<Chosen> fewer = now.chosen;
    fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(left_out));
    if (fewer.empty()) return unpatched();
    return refit(refitter_.at(fewer, now.moved, now.tangent));
  }
  Eigen::Index parameter_count() const { return std::ssize(responses_.test.parameters); }

  /// The model with one more effect, the best of the few most likely ones by real simulation. One that its own limit
  /// keeps out is no candidate here, but stays a rival of whatever gets in.
  std::optional<Refit> better(const Refit& now) const {
    std::optional<Refit> best;
    std::size_t tried = 0;
    double first_gain = 0;
    for (const Score& score : beside(now, now.chosen.size()).scores(refitter_.effective(now))) {
      const double least = limit(score.candidate) + shape_error(now, score.candidate);
      if (score.gain < least || already(now, score.candidate)) continue;
      if (tried == 0) first_gain = score.gain;
      if (tried >= 4 || score.gain < 0.5 * first_gain) break;
      ++tried;
      Refit trial = refitter_.add(now, score, now.tangent);
      if (now.cost - trial.cost < least || !plausible(trial)) continue;
      if (!best || trial.cost < best->cost) best = std::move(trial);
    }
    if (!best) return std::nullopt;
    best = refit(*best);
    if (now.cost - best->cost < limit(best->chosen.back().candidate) || !plausible(*best)) return std::nullopt;
    // Backward: an effect that the others have made superfluous goes.
    for (std::size_t i = 0; best->chosen.size() > 1 && i + 1 < best->chosen.size(); ++i) {
      const Refit& fewer = without(*best, i);
      if (fewer.cost - best->cost < limit(best->chosen[i].candidate)) return fewer;
    }
    return best;
  }

  double limit(std::size_t candidate) const { return gain_limit(rules_, nulls_, candidate); }

  std::vector<Finding> findings_of(const Refit& now) const {
    std::vector<Finding> findings;
    for (std::size_t i = 0; i < now.chosen.size(); ++i) findings.push_back(finding(now, i));
    return findings;
  }

  /// The least of those that are neither sure nor large beside the others: more likely their shape than an effect.
  std::optional<std::ptrdiff_t> weak_finding(const Refit& now, const std::vector<Finding>& findings) const {
    if (findings.size() < 2) return std::nullopt;
    const auto least = std::min_element(findings.begin(), findings.end(),
                                        [](const Finding& a, const Finding& b) { return a.gain < b.gain; });
    const double large = rules_.further_share * (unexplained_ - now.cost);
    if (least->why_not.empty() || least->gain >= std::max(large, least->gain_limit)) return std::nullopt;
    return least - findings.begin();
  }

  /// What the chosen effects' own wrong shape may look like: a share of what they explain, as far as they show in the
  /// channels in which the candidate shows.
  double shape_error(const Refit& now, std::size_t candidate) const {
    const Eigen::VectorXd own = channel_norms(now, candidate);
    double overlap = 0;
    for (const Chosen& c : now.chosen) {
      const Eigen::VectorXd other = channel_norms(now, c.candidate);
      const double norms = own.norm() * other.norm();
      if (norms > 0) overlap = std::max(overlap, own.dot(other) / norms);
    }
    return rules_.further_share * overlap * overlap * std::max(0.0, unexplained_ - now.cost);
  }

  Eigen::VectorXd channel_norms(const Refit& now, std::size_t candidate) const {
    const Eigen::Index width = data_.test.measured.cols();
    const Eigen::VectorXd z = now.tangent->evidence().response(candidate);
    return Eigen::Map<const Eigen::MatrixXd>(z.data(), width, z.size() / width).rowwise().norm();
  }

  /// The last one's magnitude.
  bool plausible(const Refit& at) const {
    return candidate(at.chosen.back()).at.effect->plausible(refitter_.magnitude(at.chosen.back()));
  }

  bool already(const Refit& now, std::size_t candidate) const {
    return std::any_of(now.chosen.begin(), now.chosen.end(), [&](const Chosen& c) {
      return responses_.test.candidates[c.candidate].at.id() == responses_.test.candidates[candidate].at.id();
    });
  }

  /// The chosen effects' magnitudes are free, but for number `left_out`.
  Selection beside(const Refit& now, std::size_t left_out) const {
    std::vector<std::size_t> others;
    for (std::size_t i = 0; i < now.chosen.size(); ++i) {
      if (i != left_out) others.push_back(now.chosen[i].candidate);
    }
    return Selection(now.tangent->evidence(), others);
  }

  Finding finding(const Refit& now, std::size_t i) const {
    const Chosen& c = now.chosen[i];
    const Candidate& chosen = candidate(c);
    const Selection selection = beside(now, i);
    Finding f;
    f.at = chosen.at;
    f.magnitude = refitter_.magnitude(c);
    const double norm = selection.dot(c.candidate, c.candidate);
    const double step = chosen.probe - chosen.at.effect->null_value;
    f.sd = std::hypot(step / std::sqrt(std::max(1e-12, norm)),
                      rules_.magnitude_share * (f.magnitude - chosen.at.effect->null_value));
    const Refit& others = without(now, i);
    f.gain = others.cost - now.cost;
    f.same_sign = same_sign(others.chosen, c.candidate);
    const double rival = add_rivals(f, now, others, selection, c.candidate);
    f.margin = rival > 0 ? f.gain / rival : 1e9;
    f.gain_limit = limit(c.candidate);
    if (f.gain < f.gain_limit)
      f.why_not = "its gain is within the noise";
    else if (f.gain < rival + rules_.margin_gain)
      f.why_not = "another effect explains nearly as much";
    else if (!f.cannot_tell_from.empty())
      f.why_not = "effects of one class: the data cannot tell them apart";
    else if (f.same_sign < rules_.same_sign_share)
      f.why_not = "its sign changes from day to day";
    return f;
  }

  /// Every other effect in its stead, the likely ones by real simulation: who does nearly as well joins the class.
  /// Returns the gain of the best that does not look the same.
  double add_rivals(Finding& f, const Refit& now, const Refit& others, const Selection& selection,
                    std::size_t found) const {
    const auto scores = selection.scores(refitter_.effective(others));
    double best = 0;
    int tried = 0;
    std::vector<sim::EffectAt> nearly;
    for (const Score& s : scores) {
      const Candidate& other = responses_.test.candidates[s.candidate];
      if (other.at.id() == f.at.id() || already(others, s.candidate)) continue;
      if (++tried > rules_.rivals) break;
      const Refit in_its_stead = refitter_.add(others, s, now.tangent);
      if (!plausible(in_its_stead)) continue;
      const double gain = others.cost - in_its_stead.cost;
      const Rival rival{other.at, gain, selection.cosine(found, s.candidate)};
      f.rivals.push_back(rival);
      const bool alike = std::abs(rival.cosine) > rules_.class_cosine;
      if (!alike) best = std::max(best, rival.gain);
      if (rival.gain < 0.2 * f.gain) continue;
      if (alike || f.gain - rival.gain < least_excess(rules_, f.gain, rival)) f.cannot_tell_from.push_back(other.at);
      if (f.gain < rules_.class_ratio * rival.gain) nearly.push_back(other.at);
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
    const Selection selection(refitter_.tangent()->evidence(), places);
    const Eigen::VectorXd r = refitter_.whiten(refitter_.unmoved_residual(others));
    const auto z = refitter_.tangent()->evidence().response(candidate);
    const Eigen::Index block = 2 * bins_per_day * data_.test.measured.cols();
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
      const double told = 1 / covariance(b, b);
      all += told;
      if (steps(b) > 0) agree += told;
    }
    return all > 0 ? agree / all : 1;
  }

  void judge(Verdict& v, const Refit& now) const {
    const bool rest = v.leftover > v.leftover_limit;
    if (v.findings.empty()) {
      v.kind = rest ? VerdictKind::unknown : VerdictKind::none;
      v.reason = rest
                     ? fmt::format("the model is wrong by {:.2f} times its noise and no effect explains it", v.leftover)
                     : "no gap above the floor";
      return;
    }
    const bool sure =
        std::all_of(v.findings.begin(), v.findings.end(), [](const Finding& f) { return f.why_not.empty(); });
    compare_locked(v);
    const Foretold predicted = refitter_.predicted(now, unpatched());
    v.locked.gain = predicted.gain;
    v.locked.predicted_gain = predicted.expected;
    const bool helps = locked_days_agree(v.locked);
    if (more_needed_) {
      v.kind = VerdictKind::unknown;
      v.reason =
          fmt::format("after {} effects another would still gain: something else is missing", rules_.most_effects);
    } else if (rest) {
      v.kind = VerdictKind::unknown;
      v.reason = fmt::format("the best effects leave {:.2f} times the noise: something else is missing", v.leftover);
    } else if (sure && helps) {
      v.kind = VerdictKind::named;
      v.reason = "the locked days agree";
    } else {
      v.kind = VerdictKind::ambiguous;
      for (const Finding& f : v.findings) {
        if (v.reason.empty()) v.reason = f.why_not;
      }
      const bool silent =
          predicted.expected < rules_.locked_gain && predicted.gain >= contradiction(predicted.expected);
      if (v.reason.empty()) v.reason = silent ? "the locked days cannot tell" : "the locked days do not agree";
    }
  }

  /// A gain below this is not what was predicted, nor nothing: N(e, 4 e) were the findings right.
  static double contradiction(double expected) {
    return std::min(0.0, expected - 4 * std::sqrt(std::max(0.0, expected)));
  }

  /// A small effect lowers the error by little, even where what it predicted has come true; a large one may be what
  /// moved parameters would explain there as well, but must not be contradicted.
  bool locked_days_agree(const LockedDays& locked) const {
    const double fell = 1 - locked.score_after / locked.score_before;
    const double enough = std::max(rules_.locked_gain, rules_.locked_gain_share * locked.predicted_gain);
    return (fell >= rules_.locked_share_gained && locked.gain >= contradiction(locked.predicted_gain)) ||
           (fell >= -rules_.locked_share_lost && locked.gain >= enough);
  }

  void compare_locked(Verdict& v) const {
    const sim::Channels channels = engine_.channels();
    const Eigen::Index first = locked_from(), n = bins() - first, width = v.residual_before.cols();
    LockedDays& locked = v.locked;
    const auto figures = [&](const Eigen::MatrixXd& residual, Eigen::VectorXd& rmse, Eigen::VectorXd& mean) {
      rmse = mean = Eigen::VectorXd::Zero(width);
      for (Eigen::Index c = 0; c < width; ++c) {
        int count = 0;
        for (Eigen::Index t = first; t < first + n; ++t) {
          const double x = residual(t, c);
          if (!std::isfinite(x)) continue;
          rmse(c) += x * x;
          mean(c) += x;
          ++count;
        }
        rmse(c) = std::sqrt(rmse(c) / std::max(1, count));
        mean(c) /= std::max(1, count);
      }
    };
    figures(v.residual_before, locked.rmse_before, locked.mean_before);
    figures(v.residual_after, locked.rmse_after, locked.mean_after);
    const auto group = [](const Eigen::VectorXd& rmse, int from, int to) {
      return to > from ? std::sqrt(rmse.segment(from, to - from).squaredNorm() / (to - from)) : 0.0;
    };
    locked.temp_rmse_before_k = group(locked.rmse_before, 0, channels.mau_temp() + 1);
    locked.temp_rmse_after_k = group(locked.rmse_after, 0, channels.mau_temp() + 1);
    locked.power_rmse_before_kw = group(locked.rmse_before, channels.power(), channels.fcu_duty());
    locked.power_rmse_after_kw = group(locked.rmse_after, channels.power(), channels.fcu_duty());
    // Where the findings act: the channel that they move most, in units of its noise, and those moved half as much.
    const Eigen::MatrixXd moved = (v.residual_before - v.residual_after).middleRows(first, n);
    Eigen::VectorXd share = Eigen::VectorXd::Zero(width);
    for (Eigen::Index c = 0; c < width; ++c) {
      double square = 0;
      for (Eigen::Index t = 0; t < n; ++t) square += std::isfinite(moved(t, c)) ? moved(t, c) * moved(t, c) : 0;
      share(c) = std::sqrt(square / static_cast<double>(n)) / fit_.noise.spread()(c);
    }
    double before = 0, after = 0, affected = 0;
    for (Eigen::Index c = 0; c < width; ++c) {
      if (share(c) < 0.5 * share.maxCoeff()) continue;
      const double noise = fit_.noise.spread()(c);
      before += std::pow(locked.rmse_before(c) / noise, 2);
      after += std::pow(locked.rmse_after(c) / noise, 2);
      affected += 1;
    }
    locked.score_before = std::sqrt(before);
    locked.score_after = std::sqrt(after);
    locked.score_floor = std::sqrt(affected);
  }

  const Engine& engine_;
  CaseData data_;
  const WindowResponses& responses_;
  const Rules& rules_;
  ReferenceFit fit_;
  std::vector<bool> kept_;
  NullBlocks nulls_;
  Refitter refitter_;
  mutable std::map<std::vector<std::size_t>, Refit> refits_;  // by candidates, in the order in which they were found
  double unexplained_ = 0;                                    // cost of the model without effects
  bool more_needed_ = false;
};

}  // namespace

double gain_limit(const Rules& rules, const NullBlocks& nulls, std::size_t candidate) {
  return rules.gain_limit + rules.null_share * nulls.gain[candidate];
}

double least_excess(const Rules& rules, double gain, const Rival& rival) {
  return std::max(rules.margin_gain, rules.margin_share * gain * (1 - rival.cosine * rival.cosine));
}

const char* text_of(VerdictKind kind) {
  constexpr const char* names[] = {"none", "named", "ambiguous", "unknown"};
  return names[static_cast<int>(kind)];
}

Verdict analyse(const Engine& engine, const CaseData& data, const WindowResponses& responses, const Rules& rules,
                int jobs) {
  return Analysis(engine, data, responses, rules, jobs).run();
}

}  // namespace airside::tools::gap
