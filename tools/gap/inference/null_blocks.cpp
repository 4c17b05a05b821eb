#include "tools/gap/inference/null_blocks.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace airside::tools::gap {

namespace {

/// One block as the measured period, the others as the reference.
struct LeftOut {
  Eigen::Index first = 0, count = 0;  // rows of whitened vectors
  std::vector<bool> kept;
  NuisanceResponses nuisance;
  Eigen::MatrixXd covariance;
  Eigen::VectorXd residual;

  Eigen::MatrixXd products;  // N'N of the nuisances as they stand
  Eigen::VectorXd along;     // N'r
};

/// As by a Metric of each block, from products that do not depend on the sizes.
double log_probability(const std::vector<LeftOut>& blocks, const Nuisance& settings) {
  double sum = 0;
  for (const LeftOut& block : blocks) {
    const Eigen::MatrixXd root = block.nuisance.mixing(block.covariance, settings);
    const auto lower = root.triangularView<Eigen::Lower>();
    const Eigen::MatrixXd right = block.products * lower;
    Eigen::MatrixXd inner = root.transpose().triangularView<Eigen::Upper>() * right;
    inner.diagonal().array() += 1;
    const Eigen::LLT<Eigen::MatrixXd> factor(inner);
    const Eigen::VectorXd along = root.transpose().triangularView<Eigen::Upper>() * block.along;
    const double log_det = 2 * factor.matrixLLT().diagonal().array().log().sum();
    sum -= 0.5 * (block.residual.squaredNorm() - along.dot(factor.solve(along)) + log_det);
  }
  return sum;
}

Nuisance most_probable(const std::vector<LeftOut>& blocks) {
  struct Size {
    double Nuisance::*member;
    std::vector<double> values;
  };
  const std::vector<Size> sizes = {{&Nuisance::structural_sd, {0.01, 0.03, 0.1, 0.3}},
                                   {&Nuisance::day_gain_sd, {0.01, 0.03, 0.1, 0.2}},
                                   {&Nuisance::day_shift_h, {0.02, 0.06, 0.2, 0.4}},
                                   {&Nuisance::inflation, {1, 3, 9}}};
  Nuisance best;
  for (const Size& size : sizes) {
    double highest = -std::numeric_limits<double>::infinity();
    const Nuisance before = best;
    for (const double value : size.values) {
      Nuisance trial = before;
      trial.*size.member = value;
      const double log_p = log_probability(blocks, trial);
      if (log_p > highest) {
        highest = log_p;
        best = trial;
      }
    }
  }
  return best;
}

}  // namespace

NullBlocks no_null_blocks(const Responses& responses) {
  NullBlocks none;
  none.nuisance.inflation = 1;
  none.nuisance.structural_sd = 0;
  none.log_likelihood_ratio.assign(responses.candidates.size(), 0.0);
  return none;
}

NullBlocks null_blocks(const ReferenceFit& fit, const Responses& responses, const Window& window, int block_days) {
  const Eigen::Index bins = window.measured.rows(), width = window.measured.cols();
  const auto counted = counted_bins(bins);
  std::vector<LeftOut> blocks;
  // The remainder of the days stays with the first, which is not counted.
  const Eigen::Index days = bins / bins_per_day - 1;
  for (Eigen::Index b = 0; (b + 1) * block_days <= days; ++b) {
    const Eigen::Index end = bins - b * block_days * bins_per_day, begin = end - block_days * bins_per_day;
    LeftOut block;
    block.kept.assign(static_cast<std::size_t>(bins), false);
    std::vector<bool> others = counted;
    std::fill(block.kept.begin() + begin, block.kept.begin() + end, true);
    std::fill(others.begin() + begin, others.begin() + end, false);
    block.first = (begin - NoiseModel::order) * width;
    block.count = (end - begin) * width;

    const Eigen::MatrixXd j =
        nuisance_responses(fit, fit.parameters, responses.candidates, others, window.measured).directions;
    const Eigen::Index count = j.cols();
    Eigen::MatrixXd inner = Eigen::MatrixXd::Identity(count, count);
    inner.selfadjointView<Eigen::Lower>().rankUpdate(j.transpose());
    const Eigen::LDLT<Eigen::MatrixXd> normal(inner.selfadjointView<Eigen::Lower>());
    const Eigen::VectorXd change =
        normal.solve(j.transpose() * fit.noise.whiten(fit.residual, others, window.measured) - fit.estimate);
    block.covariance = normal.solve(Eigen::MatrixXd::Identity(count, count));
    block.nuisance = nuisance_responses(fit, fit.parameters, responses.candidates, block.kept, window.measured)
                         .rows(block.first, block.count);
    block.residual = fit.noise.whiten(fit.residual, block.kept, window.measured).segment(block.first, block.count) -
                     block.nuisance.directions * change;
    const Eigen::MatrixXd nuisances = block.nuisance.joined();
    block.products = nuisances.transpose() * nuisances;
    block.along = nuisances.transpose() * block.residual;
    blocks.push_back(std::move(block));
  }

  NullBlocks out;
  out.block_days = block_days;
  out.blocks = static_cast<int>(blocks.size());
  out.log_likelihood_ratio.assign(responses.candidates.size(), 0.0);
  if (blocks.empty()) return out;
  out.nuisance = most_probable(blocks);
  for (const LeftOut& block : blocks) {
    Eigen::MatrixXd z(block.count, std::ssize(responses.candidates));
    for (Eigen::Index k = 0; k < z.cols(); ++k) {
      const Candidate& c = responses.candidates[static_cast<std::size_t>(k)];
      z.col(k) = fit.noise.whiten(c.response, block.kept, window.measured).segment(block.first, block.count);
    }
    const CandidateEvidence evidence(responses.candidates, std::make_shared<const Eigen::MatrixXd>(std::move(z)),
                                     Metric(block.nuisance.scaled(block.covariance, out.nuisance)));
    for (const Score& score : Selection(evidence).scores(block.residual)) {
      // The two directions of one place stand beside each other; only the better has a score.
      for (const std::size_t i : {score.candidate & ~std::size_t{1}, score.candidate | 1}) {
        out.log_likelihood_ratio[i] = std::max(out.log_likelihood_ratio[i], score.log_likelihood_ratio);
      }
      out.best_log_likelihood_ratio = std::max(out.best_log_likelihood_ratio, score.log_likelihood_ratio);
    }
    const double samples = std::max(1.0, static_cast<double>((block.residual.array() != 0).count()));
    out.residual_ratio = std::max(out.residual_ratio,
                                  evidence.metric().dot(block.residual, block.residual) / samples / fit.residual_ratio);
  }
  return out;
}

}  // namespace airside::tools::gap
