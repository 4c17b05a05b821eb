#pragma once
// Differenced ARX models with recursive least squares: what an adaptive-control engineer would build.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "tools/baselines/baseline.hpp"

namespace airside::tools {

/// Least squares, one observation at a time, from a Gaussian prior; a long series gives the batch (ridge)
/// fit.
///   k = P h / (r + h' P h);  theta += k (y - h' theta);  P -= k h' P
/// Forgetting divides P by lambda, but never beyond the prior's trace, so that quiet regressors cannot blow
/// up.
class RecursiveLeastSquares {
 public:
  /// Shape: mean and sd, one entry a parameter. sd is the prior's standard deviation.
  RecursiveLeastSquares(const Eigen::VectorXd& mean, const Eigen::VectorXd& sd);
  /// `noise_var` r > 0; `forgetting` lambda in (0, 1]; |innovation| is clipped at `clip`.
  void update(const Eigen::VectorXd& regressors, double target, double noise_var, double forgetting, double clip);
  const Eigen::VectorXd& parameters() const { return theta_; }

 private:
  Eigen::VectorXd theta_;
  Eigen::MatrixXd covariance_;
  double prior_trace_;
};

struct ArxSettings {
  bool exogenous = true;  ///< five exogenous differences beside the two own parameters
  double rho = 0.2;       ///< closed-loop pole: the share of the present error left after one cycle
  double gain_min = 0.2;  ///< K/K, clip of the setpoint gain
  double gain_max = 1.2;
  double gain_prior = 0.6;
  double gain_prior_sd = 0.3;
  double noise_sd_k = 0.06;
  double forgetting = 0.998;  ///< a cycle
  double clip_k = 0.5;        ///< largest innovation that is learnt from, after the batch fit
};

/// Predicts the change of the room mean over the next cycle and inverts it for the setpoint.
///   ds_{t+1} = p ds_t + b da_t + c' dx_t
///   a_t = a_{t-1} + ((1 - rho) (target - s_t) - p ds_t - c' dx_t) / clip(b)
/// x: mean FCU temperature, last power meter, MAU outlet temperature, FCUs on, VAVs on.
/// Fitted on the history rows (6 min apart, setpoint constant over both cycles), then recursive.
/// Source: docs/results.md, "Peers".
class ArxBaseline final : public BaselineController {
 public:
  ArxBaseline(const ControllerSettings& site, const ArxSettings& settings);
  std::string name() const override;
  void observe_history(std::span<const HistoryRow> rows) override;
  bool heeds_history() const override { return true; }
  double decide(const CycleObservation& now) override;

  /// [p, b, c...]
  const Eigen::VectorXd& parameters() const { return model_.parameters(); }
  double gain() const;  ///< b as used, clipped

  static constexpr int exogenous_count = 5;

 private:
  /// Room mean, exogenous values and the setpoint held from then on; one instant of the past.
  struct Instant {
    CivilTime time;
    double mean_degc = 0;
    Eigen::VectorXd x;
    double setpoint_degc = 0;
  };
  Instant instant(CivilTime time, const sim::Sensors& sensors, double setpoint_degc) const;
  Eigen::VectorXd regressors(const Instant& before, const Instant& now, double setpoint_change_k) const;

  ControllerSettings site_;
  ArxSettings settings_;
  RecursiveLeastSquares model_;
  std::vector<Instant> past_;  ///< at most the last two cycles' instants
};

}  // namespace airside::tools
