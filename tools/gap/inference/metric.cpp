#include "tools/gap/inference/metric.hpp"

namespace airside::tools::gap {

namespace {

Eigen::MatrixXd gram_of(const Eigen::MatrixXd& j) {
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(j.cols(), j.cols());
  if (j.cols() > 0) gram.selfadjointView<Eigen::Lower>().rankUpdate(j.transpose());
  return gram;
}

/// I + J'J of both kinds of columns, lower part.
Eigen::MatrixXd gram_of(const Eigen::MatrixXd& own, const SharedColumns* shared) {
  const Eigen::Index first = own.cols(), all = first + (shared != nullptr ? shared->j.cols() : 0);
  Eigen::MatrixXd gram(all, all);
  gram.topLeftCorner(first, first) = gram_of(own);
  if (shared != nullptr) {
    gram.bottomLeftCorner(all - first, first).noalias() = shared->j.transpose() * own;
    gram.bottomRightCorner(all - first, all - first) = shared->gram;
  }
  gram.diagonal().array() += 1;
  return gram;
}

}  // namespace

SharedColumns::SharedColumns(Eigen::MatrixXd columns, std::shared_ptr<const Eigen::MatrixXd> candidates)
    : j(std::move(columns)), z(std::move(candidates)), gram(gram_of(j)) {
  if (z) along_z = j.transpose() * *z;
}

Metric::Metric(Eigen::MatrixXd j, std::shared_ptr<const SharedColumns> shared)
    : own_(std::make_shared<const Eigen::MatrixXd>(std::move(j))),
      shared_(std::move(shared)),
      gram_(gram_of(*own_, shared_.get())),
      inner_(gram_.selfadjointView<Eigen::Lower>()) {}

Metric Metric::without_first(Eigen::Index columns) const {
  const Eigen::Index left = gram_.cols() - columns;
  return {own_, from_ + columns, shared_, gram_.bottomRightCorner(left, left)};
}

Eigen::VectorXd Metric::along(const Eigen::VectorXd& v) const {
  Eigen::VectorXd all(gram_.cols());
  const Eigen::Index first = own().cols();
  all.head(first) = own().transpose() * v;
  if (shared_) all.tail(all.size() - first) = shared_->j.transpose() * v;
  return all;
}

Eigen::VectorXd Metric::first(const Eigen::VectorXd& u) const { return own().leftCols(u.size()) * u; }

Eigen::VectorXd Metric::times(const Eigen::VectorXd& v) const {
  const Eigen::VectorXd u = inner_.solve(along(v));
  const Eigen::Index first = own().cols();
  Eigen::VectorXd m_v = v - own() * u.head(first);
  if (shared_) m_v -= shared_->j * u.tail(u.size() - first);
  return m_v;
}

double Metric::dot(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const {
  return a.dot(b) - along(a).dot(inner_.solve(along(b)));
}

Eigen::VectorXd Metric::squares(const Eigen::MatrixXd& z) const {
  Eigen::MatrixXd jz(gram_.cols(), z.cols());
  const Eigen::Index first = own().cols(), others = jz.rows() - first;
  jz.topRows(first).noalias() = own().transpose() * z;
  if (shared_) {
    if (shared_->z.get() == &z) {
      jz.bottomRows(others) = shared_->along_z;
    } else {
      jz.bottomRows(others).noalias() = shared_->j.transpose() * z;
    }
  }
  return z.colwise().squaredNorm().transpose() - jz.cwiseProduct(inner_.solve(jz)).colwise().sum().transpose();
}

}  // namespace airside::tools::gap
