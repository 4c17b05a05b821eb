#include "tools/gap/inference/reference_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace airside::tools::gap {

namespace {

Eigen::MatrixXd whitened(const NoiseModel& noise, const std::vector<Eigen::MatrixXd>& directions,
                         const std::vector<bool>& kept, const Eigen::MatrixXd& missing) {
  Eigen::MatrixXd j;
  for (std::size_t i = 0; i < directions.size(); ++i) {
    const Eigen::VectorXd column = noise.whiten(directions[i], kept, missing);
    if (i == 0) j.resize(column.size(), static_cast<Eigen::Index>(directions.size()));
    j.col(static_cast<Eigen::Index>(i)) = column;
  }
  return j;
}

/// Steps to the first probe that move the channel which shows them most by one noise standard deviation.
Eigen::VectorXd scale_of(const Responses& responses, const Eigen::VectorXd& spread) {
  Eigen::VectorXd scale(std::ssize(responses.candidates) / 2);
  for (Eigen::Index i = 0; i < scale.size(); ++i) {
    const Eigen::MatrixXd& z = responses.candidates[static_cast<std::size_t>(2 * i)].response;
    double most = 0;
    for (Eigen::Index c = 0; c < z.cols(); ++c) {
      const double rms = std::sqrt(z.col(c).squaredNorm() / static_cast<double>(z.rows()));
      if (std::isfinite(rms)) most = std::max(most, rms / spread(c));
    }
    scale(i) = most > 1e-3 ? 1 / most : 0;
  }
  return scale;
}

Changes changes_of(const std::vector<Parameter>& parameters, const Eigen::VectorXd& estimate) {
  Changes changes;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const sim::Effect& effect = *parameters[i].at.effect;
    const double m = effect.null_value + estimate(static_cast<Eigen::Index>(i)) * parameters[i].prior_sd;
    changes.push_back({parameters[i].at, std::clamp(m, effect.low, effect.high)});
  }
  return changes;
}

}  // namespace

std::vector<bool> counted_bins(Eigen::Index bins) {
  std::vector<bool> kept(static_cast<std::size_t>(bins), true);
  std::fill_n(kept.begin(), std::min<Eigen::Index>(bins, bins_per_day), false);
  return kept;
}

std::vector<Eigen::MatrixXd> directions_of(const std::vector<Parameter>& parameters,
                                           const std::vector<Candidate>& candidates,
                                           const Eigen::VectorXd& structural_scale) {
  std::vector<Eigen::MatrixXd> directions;
  for (const Parameter& parameter : parameters) directions.push_back(parameter.response);
  for (Eigen::Index i = 0; i < structural_scale.size(); ++i) {
    directions.push_back(structural_scale(i) * candidates[static_cast<std::size_t>(2 * i)].response);
  }
  return directions;
}

std::vector<Parameter> parameters_about(const Engine& engine, const sim::Recording& recording,
                                        std::vector<Parameter> parameters, const Eigen::VectorXd& estimate,
                                        const Changes& besides, const Eigen::MatrixXd& shown, int jobs) {
  Changes at = changes_of(parameters, estimate);
  at.insert(at.end(), besides.begin(), besides.end());
  std::vector<Task> tasks;
  std::vector<double> steps;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const sim::Effect& effect = *parameters[i].at.effect;
    const double sd = parameters[i].prior_sd, from = at[i].magnitude;
    const double side = estimate(static_cast<Eigen::Index>(i)) < 0 ? -sd : sd;
    const double onward = std::clamp(from + side, effect.low, effect.high);
    const double to = std::abs(onward - from) >= sd / 2 ? onward : std::clamp(from - side, effect.low, effect.high);
    tasks.push_back({at, &recording});
    tasks.back().changes[i].magnitude = to;
    steps.push_back((to - from) / sd);
  }
  const std::vector<sim::ChannelTable> tables = simulate_all(engine, tasks, jobs);
  for (std::size_t i = 0; i < parameters.size(); ++i)
    parameters[i].response = (binned(tables[i], engine.channels()) - shown) / steps[i];
  return parameters;
}

Eigen::MatrixXd ReferenceFit::structural(const Responses& responses) const {
  Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(responses.base.rows(), responses.base.cols());
  const Eigen::Index first = std::ssize(responses.parameters);
  for (Eigen::Index i = 0; i < structural_scale.size(); ++i) {
    sum += estimate(first + i) * structural_scale(i) * responses.candidates[static_cast<std::size_t>(2 * i)].response;
  }
  return sum;
}

Changes ReferenceFit::changes(const Eigen::VectorXd& moved) const {
  Eigen::VectorXd at = estimate;
  if (moved.size() > 0) at.head(moved.size()) += moved;
  return changes_of(parameters, at);
}

ReferenceFit fit_reference(const Engine& engine, const Responses& responses, const Window& all, int jobs) {
  const Window window = evidence_of(all, engine.channels());
  const auto kept = counted_bins(window.measured.rows());
  ReferenceFit fit;
  fit.parameters = responses.parameters;
  Eigen::MatrixXd shown = responses.base, residual = window.measured - shown;
  const auto noise_of = [&](const Eigen::MatrixXd& x) {
    return NoiseModel::fit(x.bottomRows(x.rows() - bins_per_day), engine.channels());
  };
  // The first noise model is of an unfitted model: too wide and too slow. What it fits is fitted again with a better
  // one.
  for (int iteration = 0; iteration < 6; ++iteration) {
    fit.noise = noise_of(residual);
    if (iteration == 1) fit.structural_scale = scale_of(responses, fit.noise.spread());
    if (iteration == 3 && !engine.spares_runs()) {
      fit.parameters =
          parameters_about(engine, window.recording, std::move(fit.parameters), fit.estimate, {}, shown, jobs);
    }
    const auto directions = directions_of(fit.parameters, responses.candidates, fit.structural_scale);
    const Eigen::Index count = std::ssize(directions);
    fit.estimate.conservativeResizeLike(Eigen::VectorXd::Zero(count));
    const Eigen::MatrixXd j = whitened(fit.noise, directions, kept, window.measured);
    const Eigen::VectorXd r = fit.noise.whiten(residual, kept, window.measured);
    Eigen::MatrixXd inner = Eigen::MatrixXd::Identity(count, count);
    inner.selfadjointView<Eigen::Lower>().rankUpdate(j.transpose());
    const Eigen::LDLT<Eigen::MatrixXd> normal(inner.selfadjointView<Eigen::Lower>());
    // The step from where the residual stands, drawn to the prior's mean, not to the last estimate.
    fit.estimate = (fit.estimate + normal.solve(j.transpose() * r - fit.estimate)).cwiseMax(-8.0).cwiseMin(8.0);
    fit.covariance = normal.solve(Eigen::MatrixXd::Identity(count, count));
    shown =
        binned(engine.simulate(changes_of(responses.parameters, fit.estimate), window.recording), engine.channels());
    residual = window.measured - shown - fit.structural(responses);
  }
  fit.noise = noise_of(residual);
  fit.residual = residual;
  const Eigen::VectorXd r = fit.noise.whiten(residual, kept, window.measured);
  const double samples = static_cast<double>((r.array() != 0).count());
  fit.residual_ratio = samples > 0 ? r.squaredNorm() / samples : 1;
  return fit;
}

ReferenceFit prior_fit(const Engine& engine, const Responses& responses, const Window& window,
                       const std::vector<bool>& kept, int jobs) {
  Window seen = window;
  for (std::size_t b = 0; b < kept.size(); ++b) {
    if (!kept[b]) seen.measured.row(static_cast<Eigen::Index>(b)).setConstant(std::numeric_limits<double>::quiet_NaN());
  }
  ReferenceFit fit = fit_reference(engine, responses, seen, jobs);
  fit.parameters = responses.parameters;
  fit.estimate.setZero();
  fit.covariance.setIdentity();
  fit.structural_scale.setZero();
  fit.residual = window.measured - responses.base;
  return fit;
}

}  // namespace airside::tools::gap
