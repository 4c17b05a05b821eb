#include "tools/gap/verdict/locked_days.hpp"

#include <algorithm>
#include <cmath>

namespace airside::tools::gap {

namespace {

using Eigen::Index;

/// Root mean square and mean of each channel from a bin on.
void figures(const Eigen::MatrixXd& residual, Index first, Eigen::VectorXd& rmse, Eigen::VectorXd& mean) {
  rmse = mean = Eigen::VectorXd::Zero(residual.cols());
  for (Index c = 0; c < residual.cols(); ++c) {
    int count = 0;
    for (Index t = first; t < residual.rows(); ++t) {
      const double x = residual(t, c);
      if (!std::isfinite(x)) continue;
      rmse(c) += x * x;
      mean(c) += x;
      ++count;
    }
    rmse(c) = std::sqrt(rmse(c) / std::max(1, count));
    mean(c) /= std::max(1, count);
  }
}

/// How far each channel was moved, in units of its noise.
Eigen::VectorXd moved_share(const Eigen::MatrixXd& moved, const Eigen::VectorXd& noise) {
  Eigen::VectorXd share = Eigen::VectorXd::Zero(moved.cols());
  for (Index c = 0; c < moved.cols(); ++c) {
    double square = 0;
    for (Index t = 0; t < moved.rows(); ++t) square += std::isfinite(moved(t, c)) ? moved(t, c) * moved(t, c) : 0;
    share(c) = std::sqrt(square / static_cast<double>(moved.rows())) / noise(c);
  }
  return share;
}

/// Mean square of how drawn buildings differ in a channel, where it was measured.
double square_of_buildings(const StructureEnsemble& ensemble, const Eigen::MatrixXd& measured, Index first,
                           Index channel) {
  double sum = 0;
  int count = 0;
  for (Index t = first; t < measured.rows(); ++t) {
    if (!std::isfinite(measured(t, channel))) continue;
    for (const Eigen::MatrixXd& one : ensemble.directions) sum += one(t, channel) * one(t, channel);
    ++count;
  }
  return sum / std::max(1, count);
}

}  // namespace

LockedDays locked_days(const FittedCase& c, const Eigen::MatrixXd& before, const Eigen::MatrixXd& after) {
  const sim::Channels channels = c.engine.channels();
  const Index first = locked_from(c.rules, before.rows());
  LockedDays locked;
  figures(before, first, locked.rmse_before, locked.mean_before);
  figures(after, first, locked.rmse_after, locked.mean_after);
  const auto group = [](const Eigen::VectorXd& rmse, int from, int to) {
    return to > from ? std::sqrt(rmse.segment(from, to - from).squaredNorm() / (to - from)) : 0.0;
  };
  locked.temp_rmse_before_k = group(locked.rmse_before, 0, channels.mau_temp() + 1);
  locked.temp_rmse_after_k = group(locked.rmse_after, 0, channels.mau_temp() + 1);
  locked.power_rmse_before_kw = group(locked.rmse_before, channels.power(), channels.fcu_duty());
  locked.power_rmse_after_kw = group(locked.rmse_after, channels.power(), channels.fcu_duty());
  // Where the findings act: the channel that they move most, and those moved nearly as much.
  const Eigen::VectorXd& noise = c.fit.noise.spread();
  const Eigen::VectorXd share = moved_share((before - after).bottomRows(before.rows() - first), noise);
  double sum_before = 0, sum_after = 0, affected = 0, buildings = 0;
  for (Index channel = 0; channel < before.cols(); ++channel) {
    if (share(channel) < c.rules.affected_share * share.maxCoeff()) continue;
    sum_before += std::pow(locked.rmse_before(channel) / noise(channel), 2);
    sum_after += std::pow(locked.rmse_after(channel) / noise(channel), 2);
    affected += 1;
    buildings += square_of_buildings(c.ensemble, before, first, channel) / std::pow(noise(channel), 2);
  }
  locked.score_before = std::sqrt(sum_before);
  locked.score_after = std::sqrt(sum_after);
  locked.score_floor = std::sqrt(affected);
  locked.score_right = std::sqrt(affected + buildings);
  return locked;
}

}  // namespace airside::tools::gap
