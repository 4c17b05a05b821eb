#include "tools/gap/inference/structure_ensemble.hpp"

#include <algorithm>
#include <cmath>
#include <mutex>

#include "tools/gap/inference/selection.hpp"
#include "tools/gap/model/parallel.hpp"

namespace airside::tools::gap {

namespace {

constexpr std::uint64_t first_seed = 0x5eed0000;  // no case has one of these
constexpr double least_variance = 1;              // whitened: a direction below is less than the noise of one value

/// Buildings of a window: those that are known, else about the fitted model.
std::vector<Eigen::MatrixXd> buildings_of(const Engine& engine, const ReferenceFit& fit, const Responses& responses,
                                          const sim::Recording& recording, int rooms, int jobs) {
  if (std::ssize(responses.buildings) == rooms) return responses.buildings;
  const Changes at = fit.changes();
  return drawn_buildings(engine, at, binned(engine.simulate(at, recording), engine.channels()), recording, rooms, jobs);
}

/// e_i' (I + C_-i)^-1 e_i of each building, the mean; C_-i of all others. By their inner products alone:
///   e_i' e_i - g' ((n - 1) I + G)^-1 g
double mean_left_by_others(const Eigen::MatrixXd& inner) {
  const Eigen::Index n = inner.rows(), last = n - 1;
  if (n < 2) return inner.trace();
  double sum = 0;
  for (Eigen::Index i = 0; i < n; ++i) {
    Eigen::MatrixXd g = inner;
    g.row(i).swap(g.row(last));
    g.col(i).swap(g.col(last));
    Eigen::MatrixXd others = g.topLeftCorner(last, last);
    others.diagonal().array() += static_cast<double>(last);
    sum += g(last, last) - g.col(last).head(last).dot(others.ldlt().solve(g.col(last).head(last)));
  }
  return sum / static_cast<double>(n);
}

/// What the fit of the model's parameters to each building's reference days takes off its measured days.
void take_off_fitted(std::vector<Eigen::MatrixXd>& of_test, const std::vector<Eigen::MatrixXd>& of_reference,
                     const ReferenceFit& fit, const Window& reference, const WindowResponses& responses,
                     const std::vector<Parameter>& about) {
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
}

}  // namespace

std::vector<Eigen::MatrixXd> drawn_buildings(const Engine& engine, const Changes& at, const Eigen::MatrixXd& shown,
                                             const sim::Recording& recording, int rooms, int jobs,
                                             const std::function<void()>& done) {
  if (!engine.draws_buildings()) return {};
  std::vector<Eigen::MatrixXd> buildings(static_cast<std::size_t>(rooms));
  std::mutex mutex;
  in_parallel(buildings.size(), jobs, [&](std::size_t i) {
    buildings[i] = binned(engine.simulate_differing(first_seed + i, at, recording), engine.channels()) - shown;
    const std::lock_guard lock(mutex);
    if (done) done();
  });
  return buildings;
}

StructureEnsemble structure_ensemble(const Engine& engine, const ReferenceFit& fit, const Window& reference,
                                     const Window& test, const WindowResponses& responses,
                                     const std::vector<Parameter>& about, int rooms, int jobs) {
  StructureEnsemble out;
  auto of_test = buildings_of(engine, fit, responses.test, test.recording, rooms, jobs);
  if (of_test.empty()) return out;
  if (reference.measured.rows() > 0) {
    const auto of_reference = buildings_of(engine, fit, responses.reference, reference.recording, rooms, jobs);
    take_off_fitted(of_test, of_reference, fit, reference, responses, about);
  }

  out.mean = Eigen::MatrixXd::Zero(test.measured.rows(), test.measured.cols());
  for (const Eigen::MatrixXd& one : of_test) out.mean += one / rooms;
  for (Eigen::MatrixXd& one : of_test) one -= out.mean;

  // Principal directions in the measured window's own whitened metric.
  const auto all = counted_bins(test.measured.rows());
  Eigen::MatrixXd e((test.measured.rows() - NoiseModel::order) * test.measured.cols(), std::ssize(of_test));
  for (Eigen::Index i = 0; i < e.cols(); ++i) {
    e.col(i) = fit.noise.whiten(of_test[static_cast<std::size_t>(i)], all, test.measured);
  }
  const Eigen::MatrixXd products = e.transpose() * e;
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(products / rooms);
  for (Eigen::Index k = e.cols() - 1; k >= 0 && eigen.eigenvalues()(k) > least_variance; --k) {
    Eigen::MatrixXd direction = Eigen::MatrixXd::Zero(test.measured.rows(), test.measured.cols());
    for (std::size_t i = 0; i < of_test.size(); ++i) {
      direction += eigen.eigenvectors()(static_cast<Eigen::Index>(i), k) / std::sqrt(rooms) * of_test[i];
    }
    out.directions.push_back(std::move(direction));
  }
  out.rooms = rooms;
  const double values = std::max(1.0, static_cast<double>((e.array() != 0).rowwise().any().count()));
  out.adds_alone = products.trace() / rooms / values;
  out.adds = mean_left_by_others(products) / values;
  return out;
}

}  // namespace airside::tools::gap
