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

namespace {

/// A fit on its way, from the twin itself on.
class ReferenceFitter {
 public:
  ReferenceFitter(const Engine& engine, const Responses& responses, const Window& all, int jobs)
      : engine_(engine),
        responses_(responses),
        window_(evidence_of(all, engine.channels())),
        kept_(counted_bins(window_.measured.rows())),
        jobs_(jobs),
        always_steps_(engine.stand_in().has_value()),
        shown_(responses.base) {
    fit_.parameters = responses.parameters;
    fit_.residual = window_.measured - shown_;
    fit_noise();
  }

  /// What it gained of r'r + d'd, r whitened by the noise before it; 0 where nothing gains, and nothing has moved.
  double step() {
    const auto directions = directions_of(fit_.parameters, responses_.candidates, fit_.structural_scale);
    const Eigen::Index count = std::ssize(directions);
    fit_.estimate.conservativeResizeLike(Eigen::VectorXd::Zero(count));
    const Eigen::MatrixXd j = whitened(fit_.noise, directions, kept_, window_.measured);
    Eigen::MatrixXd inner = Eigen::MatrixXd::Identity(count, count);
    inner.selfadjointView<Eigen::Lower>().rankUpdate(j.transpose());
    const Eigen::LDLT<Eigen::MatrixXd> normal(inner.selfadjointView<Eigen::Lower>());
    fit_.covariance = normal.solve(Eigen::MatrixXd::Identity(count, count));
    const Eigen::VectorXd from = fit_.estimate, r = whitened_residual();
    // Drawn to the prior's mean, not to the last estimate.
    const Eigen::VectorXd move = normal.solve(j.transpose() * r - from);
    const Eigen::MatrixXd shown = shown_, residual = fit_.residual;
    const double before = r.squaredNorm() + from.squaredNorm();
    for (const double share : {1.0, 0.5, 0.2}) {
      go_to((from + share * move).cwiseMax(-8.0).cwiseMin(8.0));
      const double gained = before - whitened_residual().squaredNorm() - fit_.estimate.squaredNorm();
      if (!(gained > 0) && !always_steps_) continue;
      fit_noise();
      return gained;
    }
    fit_.estimate = from;
    shown_ = shown;
    fit_.residual = residual;
    return 0;
  }

  void scale_structure() { fit_.structural_scale = scale_of(responses_, fit_.noise.spread()); }
  void look_about() {
    if (engine_.spares_runs()) return;
    fit_.parameters =
        parameters_about(engine_, window_.recording, std::move(fit_.parameters), fit_.estimate, {}, shown_, jobs_);
  }

  ReferenceFit done() {
    const Eigen::VectorXd r = whitened_residual();
    const double samples = static_cast<double>((r.array() != 0).count());
    fit_.residual_ratio = samples > 0 ? r.squaredNorm() / samples : 1;
    return std::move(fit_);
  }

 private:
  void go_to(const Eigen::VectorXd& estimate) {
    fit_.estimate = estimate;
    shown_ =
        binned(engine_.simulate(changes_of(responses_.parameters, estimate), window_.recording), engine_.channels());
    fit_.residual = window_.measured - shown_ - fit_.structural(responses_);
  }
  void fit_noise() {
    fit_.noise = NoiseModel::fit(fit_.residual.bottomRows(fit_.residual.rows() - bins_per_day), engine_.channels());
  }
  Eigen::VectorXd whitened_residual() const { return fit_.noise.whiten(fit_.residual, kept_, window_.measured); }

  const Engine& engine_;
  const Responses& responses_;
  const Window window_;
  const std::vector<bool> kept_;
  const int jobs_;
  const bool always_steps_;  // the model itself is run at the estimate afterwards, until it rests
  ReferenceFit fit_;
  Eigen::MatrixXd shown_;
};

}  // namespace

ReferenceFit fit_reference(const Engine& engine, const Responses& responses, const Window& window, int jobs) {
  constexpr int most_steps = 6, half_way = 3;
  constexpr double still = 1;
  ReferenceFitter fitter(engine, responses, window, jobs);
  // The first noise model is of an unfitted model: too wide and too slow. What it fits is fitted again with a better
  // one.
  fitter.step();
  fitter.scale_structure();
  for (int step = 1; step < half_way; ++step) fitter.step();
  fitter.look_about();
  for (int step = half_way; step < most_steps && (fitter.step() > still || engine.stand_in()); ++step) {
  }
  return fitter.done();
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
