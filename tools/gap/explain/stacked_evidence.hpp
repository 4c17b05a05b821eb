#pragma once
// What two logs say together of the same effects, one of them perhaps of a test that was only simulated.

#include <vector>

#include "tools/gap/inference/selection.hpp"

namespace airside::tools::gap {

Changes with_member(Changes changes, const sim::EffectChange& member);

/// Vectors side by side.
Eigen::MatrixXd columns_of(const std::vector<Eigen::VectorXd>& vectors, Eigen::Index rows);

/// The window's and a test's whitened columns, stacked without ever standing in one matrix: only their products do.
class StackedEvidence {
 public:
  /// Columns: `members`, `shared` directions, then directions of the window alone.
  StackedEvidence(const Eigen::MatrixXd& window, Eigen::Index members, Eigen::Index shared)
      : members_(members), common_(members + shared), window_gram_(window.transpose() * window) {}

  /// z' M z of the members in the window alone.
  Eigen::MatrixXd window_products() const;
  /// In both. `test_gram`: products of columns as the window's, then of directions of the test alone.
  Eigen::MatrixXd products_with(const Eigen::MatrixXd& test_gram) const;

 private:
  Eigen::Index members_, common_;
  Eigen::MatrixXd window_gram_;
};

/// Bins that a test's first command may have moved.
std::vector<bool> bins_from(Eigen::Index bins, std::size_t first_row);

}  // namespace airside::tools::gap
