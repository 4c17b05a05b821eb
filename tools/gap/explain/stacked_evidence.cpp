#include "tools/gap/explain/stacked_evidence.hpp"

#include <algorithm>

namespace airside::tools::gap {

namespace {

/// z' M z of the first `count` columns when the others are directions of unit prior.
Eigen::MatrixXd marginal_products(const Eigen::MatrixXd& gram, Eigen::Index count) {
  const Eigen::Index others = gram.rows() - count;
  if (others == 0) return gram;
  const Eigen::MatrixXd inner = gram.bottomRightCorner(others, others) + Eigen::MatrixXd::Identity(others, others);
  const Eigen::MatrixXd across = gram.bottomLeftCorner(others, count);
  return gram.topLeftCorner(count, count) - across.transpose() * inner.ldlt().solve(across);
}

}  // namespace

Changes with_member(Changes changes, const sim::EffectChange& member) {
  changes.push_back(member);
  return changes;
}

Eigen::MatrixXd columns_of(const std::vector<Eigen::VectorXd>& vectors, Eigen::Index rows) {
  Eigen::MatrixXd out(rows, std::ssize(vectors));
  for (Eigen::Index i = 0; i < out.cols(); ++i) out.col(i) = vectors[static_cast<std::size_t>(i)];
  return out;
}

Eigen::MatrixXd StackedEvidence::window_products() const { return marginal_products(window_gram_, members_); }

Eigen::MatrixXd StackedEvidence::products_with(const Eigen::MatrixXd& test_gram) const {
  const Eigen::Index own = window_gram_.rows() - common_, theirs = test_gram.rows() - common_;
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(common_ + own + theirs, common_ + own + theirs);
  gram.topLeftCorner(common_ + own, common_ + own) = window_gram_;
  gram.topLeftCorner(common_, common_) += test_gram.topLeftCorner(common_, common_);
  gram.bottomLeftCorner(theirs, common_) = test_gram.bottomLeftCorner(theirs, common_);
  gram.topRightCorner(common_, theirs) = test_gram.topRightCorner(common_, theirs);
  gram.bottomRightCorner(theirs, theirs) = test_gram.bottomRightCorner(theirs, theirs);
  return marginal_products(gram, members_);
}

std::vector<bool> bins_from(Eigen::Index bins, std::size_t first_row) {
  std::vector<bool> kept(static_cast<std::size_t>(bins), true);
  const auto first = first_row / rows_per_bin;
  const auto before = first > NoiseModel::order ? first - NoiseModel::order : 0;  // whiten() looks back
  std::fill_n(kept.begin(), std::min(before, kept.size()), false);
  return kept;
}

}  // namespace airside::tools::gap
