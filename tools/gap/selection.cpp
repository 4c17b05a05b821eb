#include "tools/gap/selection.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace airside::tools::gap {

Metric::Metric(Eigen::MatrixXd j)
    : j_(std::move(j)), inner_(j_.transpose() * j_ + Eigen::MatrixXd::Identity(j_.cols(), j_.cols())) {}

Eigen::VectorXd Metric::times(const Eigen::VectorXd& v) const { return v - j_ * inner_.solve(j_.transpose() * v); }

double Metric::dot(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
  const Eigen::VectorXd ja = j_.transpose() * a, jb = j_.transpose() * b;
  return a.dot(b) - ja.dot(inner_.solve(jb));
}

Eigen::MatrixXd NuisanceResponses::scaled(const Eigen::MatrixXd& covariance, const Nuisance& settings) const {
  const Eigen::Index count = directions.cols();
  Eigen::MatrixXd wide = settings.inflation * covariance;
  wide += settings.structural_sd * settings.structural_sd * Eigen::MatrixXd::Identity(count, count);
  Eigen::MatrixXd j(directions.rows(), count + day_gain.cols() + day_shift.cols());
  j << directions * Eigen::MatrixXd(wide.llt().matrixL()), settings.day_gain_sd * day_gain,
      settings.day_shift_h * day_shift;
  return j;
}

NuisanceResponses NuisanceResponses::rows(Eigen::Index first, Eigen::Index count) const {
  const auto days_of = [&](const Eigen::MatrixXd& all) {
    std::vector<Eigen::Index> kept;
    for (Eigen::Index d = 0; d < all.cols(); ++d) {
      if (all.col(d).segment(first, count).squaredNorm() > 0) kept.push_back(d);
    }
    return Eigen::MatrixXd(all(Eigen::seqN(first, count), kept));
  };
  return {directions.middleRows(first, count), days_of(day_gain), days_of(day_shift)};
}

NuisanceResponses nuisance_responses(const ReferenceFit& fit, const Responses& responses, const std::vector<bool>& kept,
                                     const Eigen::MatrixXd& missing) {
  const Eigen::Index bins = missing.rows(), days = bins / bins_per_day;
  const auto stacked = [&](const std::vector<Eigen::MatrixXd>& list) {
    Eigen::MatrixXd out(std::max<Eigen::Index>(0, bins - NoiseModel::order) * missing.cols(), std::ssize(list));
    for (Eigen::Index i = 0; i < out.cols(); ++i) {
      out.col(i) = fit.noise.whiten(list[static_cast<std::size_t>(i)], kept, missing);
    }
    return out;
  };
  const auto each_day = [&](const char* name) {
    std::vector<Eigen::MatrixXd> list;
    for (const Parameter& parameter : responses.parameters) {
      if (parameter.at.effect->name != name) continue;
      for (Eigen::Index d = 0; d < days; ++d) {
        Eigen::MatrixXd day = Eigen::MatrixXd::Zero(bins, parameter.response.cols());
        const Eigen::Index from = d * bins_per_day;
        day.middleRows(from, bins_per_day) = parameter.response.middleRows(from, bins_per_day) / parameter.prior_sd;
        list.push_back(std::move(day));
      }
    }
    return stacked(list);
  };
  return {stacked(directions_of(responses, fit.structural_scale)), each_day("gain_occupied"),
          each_day("occupancy_shift")};
}

Eigen::MatrixXd nuisance_directions(const ReferenceFit& fit, const Responses& responses, const std::vector<bool>& kept,
                                    const Eigen::MatrixXd& missing, const Nuisance& settings) {
  return nuisance_responses(fit, responses, kept, missing).scaled(fit.covariance, settings);
}

std::vector<Score> score_candidates(const std::vector<Candidate>& candidates,
                                    const std::vector<Eigen::VectorXd>& whitened, const Metric& metric,
                                    const Eigen::VectorXd& residual) {
  const Eigen::VectorXd m_residual = metric.times(residual);
  std::map<std::string, Score> best;
  for (std::size_t i = 0; i < candidates.size(); ++i) {
    const double norm = metric.dot(whitened[i], whitened[i]);
    if (!(norm > 1e-6)) continue;
    const double steps = whitened[i].dot(m_residual) / norm;
    const Score score{i, steps > 0 ? steps * steps * norm : 0, steps, 1 / std::sqrt(norm)};
    const auto [at, added] = best.try_emplace(candidates[i].at.id(), score);
    if (!added && score.gain > at->second.gain) at->second = score;
  }
  std::vector<Score> scores;
  for (const auto& [id, score] : best) scores.push_back(score);
  std::sort(scores.begin(), scores.end(), [](const Score& a, const Score& b) { return a.gain > b.gain; });
  return scores;
}

double cosine(const Metric& metric, const Eigen::VectorXd& a, const Eigen::VectorXd& b) {
  const double norm = std::sqrt(metric.dot(a, a) * metric.dot(b, b));
  return norm > 0 ? metric.dot(a, b) / norm : 0;
}

}  // namespace airside::tools::gap
