#include "tools/gap/null_blocks.hpp"

#include <algorithm>

namespace airside::tools::gap {

NullBlocks null_blocks(const ReferenceFit& fit, const Responses& responses, const Window& window, int block_days,
                       const Nuisance& settings) {
  const Eigen::Index bins = window.measured.rows();
  const auto counted = counted_bins(bins);
  const auto directions = directions_of(responses, fit.structural_scale);
  const Eigen::Index count = std::ssize(directions);
  const auto whitened = [&](const Eigen::MatrixXd& x, const std::vector<bool>& kept) {
    return fit.noise.whiten(x, kept, window.measured);
  };
  const auto stacked = [&](const std::vector<bool>& kept) {
    Eigen::MatrixXd j;
    for (Eigen::Index i = 0; i < count; ++i) {
      const Eigen::VectorXd column = whitened(directions[static_cast<std::size_t>(i)], kept);
      if (i == 0) j.resize(column.size(), count);
      j.col(i) = column;
    }
    return j;
  };

  NullBlocks out;
  out.block_days = block_days;
  out.gain.assign(responses.candidates.size(), 0.0);
  // The remainder of the days stays with the first, which is not counted.
  const Eigen::Index days = bins / bins_per_day - 1;
  for (Eigen::Index b = 0; (b + 1) * block_days <= days; ++b) {
    const Eigen::Index end = bins - b * block_days * bins_per_day, begin = end - block_days * bins_per_day;
    std::vector<bool> block(static_cast<std::size_t>(bins), false), others = counted;
    std::fill(block.begin() + begin, block.begin() + end, true);
    std::fill(others.begin() + begin, others.begin() + end, false);

    const Eigen::MatrixXd j_others = stacked(others), j_block = stacked(block);
    const auto normal = (j_others.transpose() * j_others + Eigen::MatrixXd::Identity(count, count)).eval().ldlt();
    const Eigen::VectorXd change = normal.solve(j_others.transpose() * whitened(fit.residual, others) - fit.estimate);
    ReferenceFit without = fit;
    without.covariance = normal.solve(Eigen::MatrixXd::Identity(count, count));
    const Metric metric(nuisance_directions(without, responses, block, window.measured, settings));
    const Eigen::VectorXd r = whitened(fit.residual, block) - j_block * change;

    std::vector<Eigen::VectorXd> z;
    for (const Candidate& c : responses.candidates) z.push_back(whitened(c.response, block));
    for (const Score& score : score_candidates(responses.candidates, z, metric, r)) {
      // The two directions of one place stand beside each other; only the better has a score.
      for (const std::size_t i : {score.candidate & ~std::size_t{1}, score.candidate | 1}) {
        out.gain[i] = std::max(out.gain[i], score.gain);
      }
      out.best_gain = std::max(out.best_gain, score.gain);
    }
    const double samples = std::max(1.0, static_cast<double>((r.array() != 0).count()));
    out.leftover = std::max(out.leftover, metric.dot(r, r) / samples / fit.leftover);
    ++out.blocks;
  }
  return out;
}

}  // namespace airside::tools::gap
