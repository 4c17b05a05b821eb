#pragma once
// Which effects explain a residual: likelihood gains in a metric in which uncertain parameters are marginalised,
// forward selection with joint refit and backward deletion, classes of effects that the data cannot tell apart.

#include "tools/gap/reference_fit.hpp"

namespace airside::tools::gap {

/// M = (I + J L J')^-1 for whitened vectors, L the parameters' covariance.
class Metric {
 public:
  /// `j`: whitened responses, one column a direction, already times the square root of L.
  explicit Metric(Eigen::MatrixXd j);
  double dot(const Eigen::VectorXd& a, const Eigen::VectorXd& b) const;
  /// M v.
  Eigen::VectorXd times(const Eigen::VectorXd& v) const;
  /// ln det(I + J L J').
  double log_det() const { return inner_.vectorD().array().log().sum(); }

 private:
  Eigen::MatrixXd j_;
  Eigen::LDLT<Eigen::MatrixXd> inner_;  // I + J'J
};

/// Parameter directions of a window: the reference's posterior, inflated, and whole days of more or fewer people.
struct Nuisance {
  double inflation = 3;         ///< of the posterior covariance: residuals are autocorrelated
  double structural_sd = 0.15;  ///< in prior sd: what even a fitted parameter may be off in another window
  double day_gain_sd = 0.1;     ///< of the occupied gain, each day anew
  double day_shift_h = 0.17;    ///< by which people come later or earlier, each day anew
};

/// What nuisances do to the sensors, whitened; sizes are put in by scaled().
struct NuisanceResponses {
  Eigen::MatrixXd directions;  ///< of one prior sd each
  Eigen::MatrixXd day_gain;    ///< of 1 a day
  Eigen::MatrixXd day_shift;   ///< of 1 h a day

  /// J of Metric.  Shape: as directions; covariance: of those, in prior units.
  Eigen::MatrixXd scaled(const Eigen::MatrixXd& covariance, const Nuisance& settings) const;
  /// The same of some rows; days that have nothing there are left out.
  NuisanceResponses rows(Eigen::Index first, Eigen::Index count) const;
};
NuisanceResponses nuisance_responses(const ReferenceFit& fit, const Responses& responses, const std::vector<bool>& kept,
                                     const Eigen::MatrixXd& missing);
Eigen::MatrixXd nuisance_directions(const ReferenceFit& fit, const Responses& responses, const std::vector<bool>& kept,
                                    const Eigen::MatrixXd& missing, const Nuisance& settings = {});

/// One candidate against a residual.
struct Score {
  std::size_t candidate = 0;  ///< index in Responses::candidates
  double gain = 0;            ///< 2 ln likelihood gained; 0 if it would have to go the other way
  double steps = 0;           ///< of the way from null to probe
  double steps_sd = 0;
};

/// Scores of all candidates, best first; of the two directions of each place only the better.
///   g_k = (z' M r)^2 / z' M z, one-sided.
/// Source: GAP.md, step 5.
std::vector<Score> score_candidates(const std::vector<Candidate>& candidates,
                                    const std::vector<Eigen::VectorXd>& whitened, const Metric& metric,
                                    const Eigen::VectorXd& residual);

/// cos(a, b) in the metric.
double cosine(const Metric& metric, const Eigen::VectorXd& a, const Eigen::VectorXd& b);

}  // namespace airside::tools::gap
