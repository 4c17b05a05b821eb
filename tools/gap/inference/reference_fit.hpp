#pragma once
// The model's uncertain parameters, fitted to a period in which nothing was missing; and how noise behaves there.

#include "tools/gap/model/responses.hpp"

namespace airside::tools::gap {

/// Directions of a window: first the parameters, then one a candidate's place, for what no parameter explains. No model
/// has the structure of its building; what looks a little like an effect in the reference period is not that effect,
/// and only a change since then is news.
std::vector<Eigen::MatrixXd> directions_of(const std::vector<Parameter>& parameters,
                                           const std::vector<Candidate>& candidates,
                                           const Eigen::VectorXd& structural_scale);
inline std::vector<Eigen::MatrixXd> directions_of(const Responses& responses, const Eigen::VectorXd& structural_scale) {
  return directions_of(responses.parameters, responses.candidates, structural_scale);
}

/// The parameters with their responses about another model than the twin itself: parameters at `estimate` (prior sd),
/// `besides` in it, which shows `shown`.  To the side on which the estimate is, unless a bound stands there.
/// Shape: estimate: one a parameter, more is ignored; shown: bins x channels.
/// Errors: as Engine::simulate.  Cost: one simulation a parameter, on `jobs` threads.
std::vector<Parameter> parameters_about(const Engine& engine, const sim::Recording& recording,
                                        std::vector<Parameter> parameters, const Eigen::VectorXd& estimate,
                                        const Changes& besides, const Eigen::MatrixXd& shown, int jobs);

struct ReferenceFit {
  Eigen::VectorXd estimate;          ///< in prior standard deviations, one a direction
  Eigen::MatrixXd covariance;        ///< in prior units; the prior's is one
  Eigen::VectorXd structural_scale;  ///< prior sd of each structural direction, in steps to the first probe
  NoiseModel noise;
  Eigen::MatrixXd residual;           ///< bins x channels; of the fitted model
  std::vector<Parameter> parameters;  ///< responses about the fitted model, in the reference period
  double residual_ratio = 1;          ///< mean square of the whitened residual; about 1

  /// The fitted parameters as changes to the model; `moved`: number of prior standard deviations beyond, one a
  /// parameter.
  Changes changes(const Eigen::VectorXd& moved = {}) const;
  /// What the structural directions add, linearly.  Shape: bins x channels of that window.
  Eigen::MatrixXd structural(const Responses& responses) const;
};

/// Gauss-Newton with the prior, six times, each followed by a real simulation; the noise model is fitted to what
/// remains. Half-way the parameters' responses are simulated anew: what the data hardly tell apart about the twin (a
/// fan's power and its flow) must be the same combination in the reference and in the measured period. An engine that
/// spares runs keeps the responses about the twin itself, in both periods.
///   d = (J'J + I)^-1 J' r, J and r whitened.
/// Errors: as simulate.  Cost: six simulations and one a parameter, beside the responses.
/// Source: docs/gap-workflow.md, "3. Reference period".
ReferenceFit fit_reference(const Engine& engine, const Responses& responses, const Window& window, int jobs = 1);

/// Where there is no reference period: parameters as their priors have them, no structure, and the noise of what
/// neither parameters nor effects of the library explain in the bins of the measured window that are `kept`.
/// Errors: as simulate.  Cost: as fit_reference().  Source: docs/gap-workflow.md, "Without a reference period".
ReferenceFit prior_fit(const Engine& engine, const Responses& responses, const Window& window,
                       const std::vector<bool>& kept, int jobs = 1);

/// Bins that count: not the first day, which remembers an unknown start.
std::vector<bool> counted_bins(Eigen::Index bins);

}  // namespace airside::tools::gap
