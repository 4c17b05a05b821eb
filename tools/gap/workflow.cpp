#include "tools/gap/workflow.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

namespace airside::tools::gap {

namespace {

/// A candidate with a magnitude, and its response there, by real simulation.
struct Chosen {
  std::size_t candidate = 0;
  double steps = 1;  ///< of the way from null to probe
};

struct Refit {
  std::vector<Chosen> chosen;
  Eigen::MatrixXd residual;  ///< bins x channels
  double distance = 0;       ///< r' M r
};

class Analysis {
 public:
  Analysis(const Engine& engine, const CaseData& data, const WindowResponses& responses, const Rules& rules)
      : engine_(engine),
        data_(data),
        responses_(responses),
        rules_(rules),
        fit_(fit_reference(engine, responses.reference, data.reference)),
        kept_(train_bins()),
        nulls_(null_blocks(fit_, responses.reference, data.reference)),
        nuisance_(nuisance_directions(fit_, responses.test, kept_, data.test.measured, nulls_.nuisance)),
        metric_(nuisance_),
        structural_(fit_.structural(responses.test)),
        parameters_(fit_.changes(responses.test.parameters)) {
    for (const Candidate& c : responses.test.candidates) whitened_.push_back(whiten(c.response));
  }

  Verdict run() {
    Verdict verdict;
    verdict.gain_limit = limit();
    verdict.nulls = nulls_;
    Refit now{{}, residual_of({}), 0};
    now.distance = distance(now.residual);
    verdict.residual_before = now.residual;
    verdict.ranking = score_candidates(responses_.test.candidates, whitened_, metric_, whiten(now.residual));
    verdict.best_gain = verdict.ranking.empty() ? 0 : verdict.ranking.front().gain;
    while (std::ssize(now.chosen) < rules_.most_effects) {
      const auto next = better(now);
      if (!next) break;
      now = *next;
    }
    verdict.residual_after = now.residual;
    verdict.leftover = now.distance / samples() / fit_.leftover;
    const double explained = (distance(verdict.residual_before) - now.distance) / samples() / fit_.leftover;
    verdict.leftover_limit = rules_.leftover_limit + rules_.shape_share * explained;
    for (std::size_t i = 0; i < now.chosen.size(); ++i) verdict.findings.push_back(finding(now, i));
    judge(verdict);
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
  double samples() const {
    const auto r = whiten(data_.test.measured - responses_.test.base);
    return std::max(1.0, static_cast<double>((r.array() != 0).count()));
  }
  Eigen::VectorXd whiten(const Eigen::MatrixXd& x) const { return fit_.noise.whiten(x, kept_, data_.test.measured); }
  double distance(const Eigen::MatrixXd& residual) const {
    const Eigen::VectorXd r = whiten(residual);
    return metric_.dot(r, r);
  }
  const Candidate& candidate(const Chosen& c) const { return responses_.test.candidates[c.candidate]; }
  double magnitude(const Chosen& c) const {
    const sim::Effect& effect = *candidate(c).at.effect;
    const double m = effect.null_value + c.steps * (candidate(c).probe - effect.null_value);
    return std::clamp(m, effect.low, effect.high);
  }

  Eigen::MatrixXd residual_of(const std::vector<Chosen>& chosen) const {
    Changes changes = parameters_;
    for (const Chosen& c : chosen) changes.push_back({candidate(c).at, magnitude(c)});
    return data_.test.measured - binned(engine_.simulate(changes, data_.test.recording)) - structural_;
  }

  /// Gauss-Newton on the magnitudes with real simulations; responses are those of the probes, scaled.
  Refit refit(const std::vector<Chosen>& chosen) const {
    Refit best{chosen, residual_of(chosen), 0};
    best.distance = distance(best.residual);
    Refit now = best;
    for (int iteration = 0; iteration < 3; ++iteration) {
      const Eigen::Index n = std::ssize(now.chosen);
      Eigen::MatrixXd normal(n, n);
      Eigen::VectorXd right(n);
      const Eigen::VectorXd r = metric_.times(whiten(now.residual));
      for (Eigen::Index i = 0; i < n; ++i) {
        const auto& zi = whitened_[now.chosen[static_cast<std::size_t>(i)].candidate];
        right(i) = zi.dot(r);
        for (Eigen::Index k = 0; k <= i; ++k) {
          normal(i, k) = normal(k, i) = metric_.dot(zi, whitened_[now.chosen[static_cast<std::size_t>(k)].candidate]);
        }
      }
      const Eigen::VectorXd step = (normal + 1e-9 * Eigen::MatrixXd::Identity(n, n)).ldlt().solve(right);
      double largest = 0;
      for (Eigen::Index i = 0; i < n; ++i) {
        Chosen& c = now.chosen[static_cast<std::size_t>(i)];
        c.steps = std::max(0.0, c.steps + std::clamp(step(i), -2.0, 2.0));
        largest = std::max(largest, std::abs(step(i)) / std::max(0.3, c.steps));
      }
      now.residual = residual_of(now.chosen);
      now.distance = distance(now.residual);
      if (now.distance < best.distance) best = now;
      if (largest < 0.03) break;
    }
    return best;
  }

  /// The model with one more effect, the best of the few most likely ones by real simulation.
  std::optional<Refit> better(const Refit& now) const {
    const auto scores = scores_beside(now);
    if (scores.empty() || scores.front().gain < limit()) return std::nullopt;
    std::optional<Refit> best;
    std::size_t tried = 0;
    for (const Score& score : scores) {
      if (tried >= 4 || score.gain < 0.5 * scores.front().gain) break;
      if (already(now, score.candidate)) continue;
      ++tried;
      auto chosen = now.chosen;
      chosen.push_back({score.candidate, score.steps});
      Refit trial = refit(chosen);
      if (!best || trial.distance < best->distance) best = std::move(trial);
    }
    if (!best || now.distance - best->distance < limit()) return std::nullopt;
    // Backward: an effect that the others have made superfluous goes.
    for (std::size_t i = 0; best->chosen.size() > 1 && i + 1 < best->chosen.size(); ++i) {
      auto fewer = best->chosen;
      fewer.erase(fewer.begin() + static_cast<std::ptrdiff_t>(i));
      Refit trial = refit(fewer);
      if (trial.distance - best->distance < limit()) return trial;
    }
    return best;
  }

  double limit() const { return rules_.gain_limit + rules_.null_share * nulls_.best_gain; }

  bool already(const Refit& now, std::size_t candidate) const {
    return std::any_of(now.chosen.begin(), now.chosen.end(), [&](const Chosen& c) {
      return responses_.test.candidates[c.candidate].at.id() == responses_.test.candidates[candidate].at.id();
    });
  }

  std::vector<Score> scores_beside(const Refit& now) const {
    return score_candidates(responses_.test.candidates, whitened_, beside(now, now.chosen.size()),
                            whiten(now.residual));
  }

  /// The metric in which the chosen effects' magnitudes are free, but for number `left_out`.
  Metric beside(const Refit& now, std::size_t left_out) const {
    Eigen::MatrixXd j = nuisance_;
    for (std::size_t i = 0; i < now.chosen.size(); ++i) {
      if (i == left_out) continue;
      j.conservativeResize(Eigen::NoChange, j.cols() + 1);
      j.col(j.cols() - 1) = 1e3 * whitened_[now.chosen[i].candidate];
    }
    return Metric(std::move(j));
  }

  Finding finding(const Refit& now, std::size_t i) const {
    const Chosen& c = now.chosen[i];
    const Candidate& chosen = candidate(c);
    const Metric metric = beside(now, i);
    const Eigen::VectorXd& z = whitened_[c.candidate];
    Finding f;
    f.at = chosen.at;
    f.magnitude = magnitude(c);
    const double norm = metric.dot(z, z);
    f.sd = std::abs(chosen.probe - chosen.at.effect->null_value) / std::sqrt(std::max(1e-12, norm));
    auto others = now.chosen;
    others.erase(others.begin() + static_cast<std::ptrdiff_t>(i));
    const Refit without = refit(others);
    f.gain = without.distance - now.distance;
    f.same_sign = same_sign(metric, z, whiten(without.residual));
    const double rival = add_rivals(f, without, metric, z);
    f.margin = rival > 0 ? f.gain / rival : 1e9;
    if (f.gain < limit())
      f.why_not = "its gain is within the noise";
    else if (f.margin < rules_.margin_ratio || f.gain - rival < rules_.margin_gain)
      f.why_not = "another effect explains nearly as much";
    else if (!f.cannot_tell_from.empty())
      f.why_not = "effects of one class: the data cannot tell them apart";
    else if (f.same_sign < rules_.same_sign_share)
      f.why_not = "its sign changes from day to day";
    return f;
  }

  /// Every other effect in its stead, the likely ones by real simulation: who does nearly as well joins the class.
  /// Returns the gain of the best that does not look the same.
  double add_rivals(Finding& f, const Refit& without, const Metric& metric, const Eigen::VectorXd& z) const {
    const auto scores = score_candidates(responses_.test.candidates, whitened_, metric, whiten(without.residual));
    double best = 0;
    int tried = 0;
    for (const Score& s : scores) {
      const Candidate& other = responses_.test.candidates[s.candidate];
      if (other.at.id() == f.at.id() || already(without, s.candidate)) continue;
      if (++tried > rules_.rivals) break;
      auto chosen = without.chosen;
      chosen.push_back({s.candidate, s.steps});
      const double gain = without.distance - refit(chosen).distance;
      const bool alike = std::abs(cosine(metric, z, whitened_[s.candidate])) > rules_.class_cosine;
      const bool near = f.gain < rules_.margin_ratio * gain || f.gain - gain < rules_.margin_gain;
      if ((alike || near) && gain > 0.2 * f.gain) f.cannot_tell_from.push_back(other.at);
      if (!alike) best = std::max(best, gain);
    }
    return best;
  }

  double same_sign(const Metric& metric, const Eigen::VectorXd& z, const Eigen::VectorXd& r) const {
    const Eigen::VectorXd m = metric.times(r);
    const Eigen::Index width = data_.test.measured.cols(), block = 2 * bins_per_day * width;
    const double all = z.squaredNorm();
    int blocks = 0, agree = 0;
    for (Eigen::Index at = 0; at < z.size(); at += block) {
      const Eigen::Index n = std::min(block, z.size() - at);
      if (z.segment(at, n).squaredNorm() < 0.03 * all) continue;
      ++blocks;
      if (z.segment(at, n).dot(m.segment(at, n)) > 0) ++agree;
    }
    return blocks > 0 ? static_cast<double>(agree) / blocks : 1;
  }

  void judge(Verdict& v) const {
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
    const bool helps = v.locked.score_after <= (1 - rules_.locked_gain) * v.locked.score_before;
    if (rest) {
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
      if (v.reason.empty()) v.reason = "the locked days do not agree";
    }
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
    // Where the findings act: channels that they move by more than a third of the noise.
    const Eigen::MatrixXd moved = (v.residual_before - v.residual_after).middleRows(first, n);
    double before = 0, after = 0, affected = 0;
    for (Eigen::Index c = 0; c < width; ++c) {
      const double noise = fit_.noise.spread()(c);
      double square = 0;
      for (Eigen::Index t = 0; t < n; ++t) square += std::isfinite(moved(t, c)) ? moved(t, c) * moved(t, c) : 0;
      if (std::sqrt(square / static_cast<double>(n)) < 0.33 * noise) continue;
      before += std::pow(locked.rmse_before(c) / noise, 2);
      after += std::pow(locked.rmse_after(c) / noise, 2);
      affected += 1;
    }
    locked.score_before = std::sqrt(before);
    locked.score_after = std::sqrt(after);
    locked.score_floor = std::sqrt(affected);
  }

  const Engine& engine_;
  const CaseData& data_;
  const WindowResponses& responses_;
  const Rules& rules_;
  ReferenceFit fit_;
  std::vector<bool> kept_;
  NullBlocks nulls_;
  Eigen::MatrixXd nuisance_;
  Metric metric_;
  Eigen::MatrixXd structural_;
  Changes parameters_;
  std::vector<Eigen::VectorXd> whitened_;
};

}  // namespace

const char* text_of(VerdictKind kind) {
  constexpr const char* names[] = {"none", "named", "ambiguous", "unknown"};
  return names[static_cast<int>(kind)];
}

Verdict analyse(const Engine& engine, const CaseData& data, const WindowResponses& responses, const Rules& rules) {
  return Analysis(engine, data, responses, rules).run();
}

}  // namespace airside::tools::gap
