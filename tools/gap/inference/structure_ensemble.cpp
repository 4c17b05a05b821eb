#include "tools/gap/inference/structure_ensemble.hpp"

#include <algorithm>
#include <cmath>

#include "tools/gap/inference/selection.hpp"
#include "tools/gap/model/parallel.hpp"

namespace airside::tools::gap {

namespace {

constexpr std::uint64_t first_seed = 0x5eed0000;  // no case has one of these
constexpr double least_variance = 1;              // whitened: a direction below is less than the noise of one value

}  // namespace

StructureEnsemble structure_ensemble(const Engine& engine, const ReferenceFit& fit, const Window& reference,
                                     const Window& test, const WindowResponses& responses,
                                     const std::vector<Parameter>& about, int rooms, int jobs) {
  StructureEnsemble out;
  const Changes at = fit.changes();
  const Eigen::MatrixXd shown_reference = binned(engine.simulate(at, reference.recording)),
                        shown_test = binned(engine.simulate(at, test.recording));
  std::vector<Eigen::MatrixXd> of_reference(static_cast<std::size_t>(rooms)), of_test(of_reference.size());
  in_parallel(2 * of_test.size(), jobs, [&](std::size_t n) {
    const std::size_t i = n / 2;
    const Window& window = n % 2 == 0 ? reference : test;
    const sim::ChannelTable table = engine.simulate_differing(first_seed + i, at, window.recording);
    if (table.size() == 0) return;
    if (n % 2 == 0)
      of_reference[i] = binned(table) - shown_reference;
    else
      of_test[i] = binned(table) - shown_test;
  });
  if (of_test.empty() || of_test.front().size() == 0) return out;

  const auto kept = counted_bins(reference.measured.rows());
  const NuisanceResponses j_r =
      nuisance_responses(fit, fit.parameters, responses.reference.candidates, kept, reference.measured);
  const Eigen::MatrixXd& j = j_r.directions;
  Eigen::MatrixXd inner = Eigen::MatrixXd::Identity(j.cols(), j.cols());
  inner.selfadjointView<Eigen::Lower>().rankUpdate(j.transpose());
  const Eigen::LDLT<Eigen::MatrixXd> normal(inner.selfadjointView<Eigen::Lower>());
  const auto along = directions_of(about, responses.test.candidates, fit.structural_scale);
  for (std::size_t i = 0; i < of_test.size(); ++i) {
    const Eigen::VectorXd d = normal.solve(j.transpose() * fit.noise.whiten(of_reference[i], kept, reference.measured));
    for (std::size_t k = 0; k < along.size(); ++k) of_test[i] -= d(static_cast<Eigen::Index>(k)) * along[k];
  }

  // Principal directions in the measured window's own whitened metric.
  const auto all = counted_bins(test.measured.rows());
  Eigen::MatrixXd e((test.measured.rows() - NoiseModel::order) * test.measured.cols(), std::ssize(of_test));
  for (Eigen::Index i = 0; i < e.cols(); ++i) {
    e.col(i) = fit.noise.whiten(of_test[static_cast<std::size_t>(i)], all, test.measured);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(e.transpose() * e / rooms);
  for (Eigen::Index k = e.cols() - 1; k >= 0 && eigen.eigenvalues()(k) > least_variance; --k) {
    Eigen::MatrixXd direction = Eigen::MatrixXd::Zero(test.measured.rows(), test.measured.cols());
    for (std::size_t i = 0; i < of_test.size(); ++i) {
      direction += eigen.eigenvectors()(static_cast<Eigen::Index>(i), k) / std::sqrt(rooms) * of_test[i];
    }
    out.directions.push_back(std::move(direction));
  }
  out.rooms = rooms;
  return out;
}

}  // namespace airside::tools::gap
