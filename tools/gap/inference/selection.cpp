#include "tools/gap/inference/selection.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace airside::tools::gap {

Eigen::MatrixXd NuisanceResponses::joined() const {
  Eigen::MatrixXd all(directions.rows(), directions.cols() + day_gain.cols() + day_shift.cols() + structure.cols());
  all.leftCols(all.cols() - structure.cols()) << directions, day_gain, day_shift;
  if (structure.cols() > 0) all.rightCols(structure.cols()) = structure;  // an empty one has no rows either
  return all;
}

Eigen::MatrixXd mixing_of(const Eigen::MatrixXd& covariance, const Nuisance& settings) {
  Eigen::MatrixXd wide = settings.inflation * covariance;
  wide.diagonal().array() += settings.structural_sd * settings.structural_sd;
  return wide.llt().matrixL();
}

Eigen::MatrixXd NuisanceResponses::mixing(const Eigen::MatrixXd& covariance, const Nuisance& settings) const {
  const Eigen::Index count = directions.cols(), ratios = day_gain.cols(), shifts = day_shift.cols(),
                     rooms = structure.cols();
  const Eigen::Index all = count + ratios + shifts + rooms;
  Eigen::MatrixXd root = Eigen::MatrixXd::Zero(all, all);
  root.topLeftCorner(count, count) = mixing_of(covariance, settings);
  root.diagonal().segment(count, ratios).setConstant(settings.day_gain_sd);
  root.diagonal().segment(count + ratios, shifts).setConstant(settings.day_shift_h);
  root.diagonal().tail(rooms).setOnes();
  return root;
}

Eigen::MatrixXd NuisanceResponses::mixed(const Eigen::MatrixXd& mixing) const {
  const Eigen::Index count = directions.cols(), others = mixing.cols() - count;
  Eigen::MatrixXd j = joined();
  j.leftCols(count) = directions * mixing.topLeftCorner(count, count).triangularView<Eigen::Lower>();
  j.rightCols(others) *= mixing.diagonal().tail(others).asDiagonal();
  return j;
}

Eigen::MatrixXd NuisanceResponses::scaled(const Eigen::MatrixXd& covariance, const Nuisance& settings) const {
  return mixed(mixing(covariance, settings));
}

NuisanceResponses NuisanceResponses::rows(Eigen::Index first, Eigen::Index count) const {
  const auto days_of = [&](const Eigen::MatrixXd& all) {
    std::vector<Eigen::Index> kept;
    for (Eigen::Index d = 0; d < all.cols(); ++d) {
      if (all.col(d).segment(first, count).squaredNorm() > 0) kept.push_back(d);
    }
    return Eigen::MatrixXd(all(Eigen::seqN(first, count), kept));
  };
  NuisanceResponses part{directions.middleRows(first, count), days_of(day_gain), days_of(day_shift)};
  if (structure.cols() > 0) part.structure = structure.middleRows(first, count);
  return part;
}

NuisanceResponses nuisance_responses(const ReferenceFit& fit, const std::vector<Parameter>& parameters,
                                     const std::vector<Candidate>& candidates, const std::vector<bool>& kept,
                                     const Eigen::MatrixXd& missing, const std::vector<Eigen::MatrixXd>& structure) {
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
    for (const Parameter& parameter : parameters) {
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
  const Eigen::VectorXd scale = candidates.empty() ? Eigen::VectorXd() : fit.structural_scale;
  return {stacked(directions_of(parameters, candidates, scale)), each_day("gain_occupied"), each_day("occupancy_shift"),
          stacked(structure)};
}

Eigen::MatrixXd nuisance_directions(const ReferenceFit& fit, const Responses& responses, const std::vector<bool>& kept,
                                    const Eigen::MatrixXd& missing, const Nuisance& settings) {
  return nuisance_responses(fit, responses.parameters, responses.candidates, kept, missing)
      .scaled(fit.covariance, settings);
}

CandidateEvidence::CandidateEvidence(const std::vector<Candidate>& candidates, std::shared_ptr<const Eigen::MatrixXd> z,
                                     Metric metric)
    : candidates_(candidates), z_(std::move(z)), metric_(std::move(metric)), norm_(metric_.squares(*z_)) {}

Selection::Selection(const CandidateEvidence& evidence, const std::vector<std::size_t>& chosen) : evidence_(evidence) {
  const Eigen::Index count = std::ssize(chosen);
  m_z_.resize(evidence.z_->rows(), count);
  Eigen::MatrixXd inner(count, count);
  for (Eigen::Index i = 0; i < count; ++i)
    m_z_.col(i) = evidence.metric_.times(evidence.response(chosen[static_cast<std::size_t>(i)]));
  cross_ = evidence.z_->transpose() * m_z_;
  for (Eigen::Index i = 0; i < count; ++i)
    inner.row(i) = cross_.row(static_cast<Eigen::Index>(chosen[static_cast<std::size_t>(i)]));
  inner.diagonal().array() *= 1 + 1e-9;  // two that look the same are not refused
  inner_.compute(inner);
}

Eigen::VectorXd Selection::times(const Eigen::VectorXd& v) const {
  Eigen::VectorXd m_v = evidence_.metric_.times(v);
  if (m_z_.cols() > 0) m_v -= m_z_ * inner_.solve(m_z_.transpose() * v);
  return m_v;
}

double Selection::norm(std::size_t candidate) const {
  const auto k = static_cast<Eigen::Index>(candidate);
  if (m_z_.cols() == 0) return evidence_.norm_(k);
  return evidence_.norm_(k) - cross_.row(k).dot(inner_.solve(cross_.row(k).transpose()));
}

double Selection::dot(std::size_t a, std::size_t b) const {
  return a == b ? norm(a) : times(evidence_.response(a)).dot(evidence_.response(b));
}

double Selection::cosine(std::size_t a, std::size_t b) const {
  const double norms = std::sqrt(norm(a) * norm(b));
  return norms > 0 ? dot(a, b) / norms : 0;
}

std::vector<Score> Selection::scores(const Eigen::VectorXd& residual) const {
  const Eigen::VectorXd along = evidence_.z_->transpose() * times(residual);
  std::map<std::string, Score> best;
  for (std::size_t i = 0; i < evidence_.candidates_.size(); ++i) {
    const double square = norm(i);
    if (!(square > 1e-6)) continue;
    const double steps = along(static_cast<Eigen::Index>(i)) / square;
    const Score score{i, steps > 0 ? steps * steps * square : 0, steps, 1 / std::sqrt(square)};
    const auto [at, added] = best.try_emplace(evidence_.candidates_[i].at.id(), score);
    if (!added && score.log_likelihood_ratio > at->second.log_likelihood_ratio) at->second = score;
  }
  std::vector<Score> scores;
  for (const auto& [id, score] : best) scores.push_back(score);
  std::sort(scores.begin(), scores.end(),
            [](const Score& a, const Score& b) { return a.log_likelihood_ratio > b.log_likelihood_ratio; });
  return scores;
}

}  // namespace airside::tools::gap
