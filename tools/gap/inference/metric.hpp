#pragma once
// What residuals and responses are measured by: distances in which uncertain directions are marginalised.

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <memory>

namespace airside::tools::gap {

/// Columns of J that many metrics have, with what is made of them once.
struct SharedColumns {
  /// Shape: j: rows x columns; z, if any: what Metric::squares() is asked for again and again, rows x candidates.
  SharedColumns(Eigen::MatrixXd j, std::shared_ptr<const Eigen::MatrixXd> z);

  Eigen::MatrixXd j;
  std::shared_ptr<const Eigen::MatrixXd> z;
  Eigen::MatrixXd gram;     ///< J'J, lower part
  Eigen::MatrixXd along_z;  ///< J'Z
};

/// M = (I + J L J')^-1 for whitened vectors, L the directions' covariance.
class Metric {
 public:
  /// `j`: whitened responses, one column a direction, already times the square root of L.
  /// Cost: (columns of `j`)^2 rows and (columns of `j`) rows (columns shared) multiplications.
  explicit Metric(Eigen::MatrixXd j, std::shared_ptr<const SharedColumns> shared = {});
  /// The same without the first columns of J.  Cost: no copy of J.
  Metric without_first(Eigen::Index columns) const;
  double dot(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const;
  /// M v.
  Eigen::VectorXd times(const Eigen::VectorXd& v) const;
  /// z' M z of each column.
  Eigen::VectorXd squares(const Eigen::MatrixXd& z) const;
  /// ln det(I + J L J').
  double log_det() const { return inner_.vectorD().array().log().sum(); }
  /// J'v, shared columns last.
  Eigen::VectorXd along(const Eigen::VectorXd& v) const;
  /// J u, u of J's first columns alone.
  Eigen::VectorXd first(const Eigen::VectorXd& u) const;

 private:
  Metric(std::shared_ptr<const Eigen::MatrixXd> own, Eigen::Index from, std::shared_ptr<const SharedColumns> shared,
         Eigen::MatrixXd gram)
      : own_(std::move(own)),
        from_(from),
        shared_(std::move(shared)),
        gram_(std::move(gram)),
        inner_(gram_.selfadjointView<Eigen::Lower>()) {}
  auto own() const { return own_->rightCols(own_->cols() - from_); }

  std::shared_ptr<const Eigen::MatrixXd> own_;
  Eigen::Index from_ = 0;  // columns of `own_` before J
  std::shared_ptr<const SharedColumns> shared_;
  Eigen::MatrixXd gram_;  // I + J'J, lower part
  Eigen::LDLT<Eigen::MatrixXd> inner_;
};

}  // namespace airside::tools::gap
