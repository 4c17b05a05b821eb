#pragma once
// Parameters of a model fitted to a log: least squares with priors on whitened residuals, how sure each parameter is
// afterwards, and how much of that is from the log.

#include <functional>
#include <string>
#include <vector>

#include "tools/gap/model/residual.hpp"

namespace airside::tools::gap {

/// A number that a log may tell, as it is known before.
struct FitParameter {
  std::string name, unit;
  double start = 0;          ///< mean of the prior; logarithmic: median
  double prior_sd = 1;       ///< in `unit`; logarithmic: of the natural logarithm
  bool logarithmic = false;  ///< then start > 0
  double low = 0, high = 0;  ///< bounds of the value

  /// value = start + sd z, logarithmic: start exp(sd z).
  double value(double z) const;
  /// d value / d z.
  double slope(double z) const;
  double z_of(double value) const;
};

/// What the sensors would have shown with these values, in the order of the parameters. Must be thread-safe, and exact:
/// differences of two runs must not drown in a sensor's rounding.
/// Shape: as sim::ChannelTable.
using FitModel = std::function<sim::ChannelTable(const Eigen::VectorXd& values)>;

struct FitSettings {
  int rounds = 4;                        ///< each with a noise model of what the last one left
  int plain_rounds = 2;                  ///< of them, the first: residuals by their spread, not whitened
  double plain_values_per_day = 4;       ///< a plain day's residuals count as this number of independent ones
  int iterations = 5;                    ///< of Levenberg-Marquardt a round, at most
  double huber = 2.5;                    ///< whitened residuals beyond count linearly
  double step = 0.15;                    ///< of the numerical Jacobian, in prior standard deviations
  int jobs = 1;                          ///< simulations at a time
  std::function<void(double)> progress;  ///< share of the work that is done, 0..1
};

struct ParameterFit {
  Eigen::VectorXd z;            ///< estimate, in prior standard deviations from the start
  Eigen::MatrixXd covariance;   ///< of z; the prior's is one
  NoiseModel noise;             ///< of what the fitted model leaves
  Eigen::MatrixXd start, best;  ///< bins x channels; of the model at its start and fitted
  double inflation = 1;         ///< by which the residuals tell less than independent ones would
  int runs = 0;                 ///< simulations

  /// Standard deviation of parameter i in its own unit, to first order.
  double sd(const FitParameter& parameter, Eigen::Index i) const;
  /// 1 - posterior variance / prior variance: 0 nothing learned, 1 everything.
  double learned(Eigen::Index i) const { return 1 - covariance(i, i); }
};

/// Most probable values under the prior and the log.
///   min over z of  |z|^2 + sum_t rho(w_t(measured - model(z))^2),  w whitening, rho Huber's
///   covariance = H^-1 (kappa J'WJ + I) H^-1,  H = J'WJ + I
/// kappa, at least 1, is what the sums of gradients over a day vary more than whitened residuals should.
/// Shape: measured: bins x channels, NaN missing; kept: bins.
/// Errors: whatever the model throws at the start values.
/// Cost: rounds * iterations * (parameters + 2) simulations, in `jobs` threads. Solver: Ceres.
ParameterFit fit_parameters(const std::vector<FitParameter>& parameters, const FitModel& model,
                            const Eigen::MatrixXd& measured, const std::vector<bool>& kept,
                            const sim::Channels& channels, const FitSettings& settings = {});

}  // namespace airside::tools::gap
