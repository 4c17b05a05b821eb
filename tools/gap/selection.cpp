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

Eigen::MatrixXd nuisance_directions(const ReferenceFit& fit, const Responses& responses, const std::vector<bool>& kept,
                                    const Eigen::MatrixXd& missing, const Nuisance& settings) {
  const auto directions = directions_of(responses, fit.structural_scale);
  const Eigen::Index count = std::ssize(directions);
  const Eigen::Index bins = missing.rows(), days = bins / bins_per_day;
  Eigen::MatrixXd covariance = settings.inflation * fit.covariance;
  covariance += settings.structural_sd * settings.structural_sd * Eigen::MatrixXd::Identity(count, count);
  Eigen::MatrixXd responses_white;
  for (Eigen::Index i = 0; i < count; ++i) {
    const Eigen::VectorXd column = fit.noise.whiten(directions[static_cast<std::size_t>(i)], kept, missing);
    if (i == 0) responses_white.resize(column.size(), count);
    responses_white.col(i) = column;
  }
  Eigen::MatrixXd j = responses_white * Eigen::MatrixXd(covariance.llt().matrixL());
  const auto each_day = [&](const char* name, double sd) {
    for (const Parameter& parameter : responses.parameters) {
      if (parameter.at.effect->name != name) continue;
      const Eigen::Index first = j.cols();
      j.conservativeResize(Eigen::NoChange, first + days);
      for (Eigen::Index d = 0; d < days; ++d) {
        Eigen::MatrixXd day = Eigen::MatrixXd::Zero(bins, parameter.response.cols());
        day.middleRows(d * bins_per_day, bins_per_day) = parameter.response.middleRows(d * bins_per_day, bins_per_day);
        j.col(first + d) = sd / parameter.prior_sd * fit.noise.whiten(day, kept, missing);
      }
    }
  };
  each_day("gain_occupied", settings.day_gain_sd);
  each_day("occupancy_shift", settings.day_shift_h);
  return j;
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
