#pragma once
// Which effects explain a residual: likelihood gains in a metric in which uncertain parameters are marginalised,
// forward selection with joint refit and backward deletion, classes of effects that the data cannot tell apart.

#include <memory>

#include "tools/gap/inference/metric.hpp"
#include "tools/gap/inference/reference_fit.hpp"

namespace airside::tools::gap {

/// Parameter directions of a window: the reference's posterior, inflated, and whole days of more or fewer people.
struct Nuisance {
  double inflation = 3;         ///< of the posterior covariance: residuals are autocorrelated
  double structural_sd = 0.15;  ///< in prior sd: what even a fitted parameter may be off in another window
  double day_gain_sd = 0.1;     ///< of the occupied gain, each day anew
  double day_shift_h = 0.17;    ///< by which people come later or earlier, each day anew
};

/// The square root of the directions' covariance in another window, lower triangular.
///   C C' = inflation covariance + structural_sd^2 I
Eigen::MatrixXd mixing_of(const Eigen::MatrixXd& covariance, const Nuisance& settings);

/// What nuisances do to the sensors, whitened; sizes are put in by scaled().
struct NuisanceResponses {
  Eigen::MatrixXd directions;      ///< of one prior sd each
  Eigen::MatrixXd day_gain;        ///< of 1 a day
  Eigen::MatrixXd day_shift;       ///< of 1 h a day
  Eigen::MatrixXd structure = {};  ///< of one standard deviation of how buildings differ from their twins

  /// All, as they stand, side by side.
  Eigen::MatrixXd joined() const;
  /// J of Metric, joined() times mixing().  covariance: of directions, in prior units.
  Eigen::MatrixXd scaled(const Eigen::MatrixXd& covariance, const Nuisance& settings) const;
  /// The same, by the square root of L.
  Eigen::MatrixXd mixed(const Eigen::MatrixXd& mixing) const;
  /// The square root of L: of the directions mixing_of(), of the others a diagonal.
  Eigen::MatrixXd mixing(const Eigen::MatrixXd& covariance, const Nuisance& settings) const;
  /// The same of some rows; days that have nothing there are left out.
  NuisanceResponses rows(Eigen::Index first, Eigen::Index count) const;
};
/// `structure`: bins x channels each, as of StructureEnsemble. Without `candidates` directions are the parameters'.
NuisanceResponses nuisance_responses(const ReferenceFit& fit, const std::vector<Parameter>& parameters,
                                     const std::vector<Candidate>& candidates, const std::vector<bool>& kept,
                                     const Eigen::MatrixXd& missing,
                                     const std::vector<Eigen::MatrixXd>& structure = {});
Eigen::MatrixXd nuisance_directions(const ReferenceFit& fit, const Responses& responses, const std::vector<bool>& kept,
                                    const Eigen::MatrixXd& missing, const Nuisance& settings = {});

/// One candidate against a residual.
struct Score {
  std::size_t candidate = 0;        ///< index in Responses::candidates
  double log_likelihood_ratio = 0;  ///< 2 ln likelihood gained; 0 if it would have to go the other way
  double steps = 0;                 ///< of the way from null to probe
  double steps_sd = 0;
};

/// The candidates' whitened responses, and what the metric makes of them.
class CandidateEvidence {
 public:
  /// Shape: z: one column a candidate; shared by what is seen from several models.
  /// Cost: (columns of J) rows candidates multiplications, once.
  CandidateEvidence(const std::vector<Candidate>& candidates, std::shared_ptr<const Eigen::MatrixXd> z, Metric metric);

  const Metric& metric() const { return metric_; }
  auto response(std::size_t candidate) const { return z_->col(static_cast<Eigen::Index>(candidate)); }

 private:
  friend class Selection;
  const std::vector<Candidate>& candidates_;
  std::shared_ptr<const Eigen::MatrixXd> z_;
  Metric metric_;
  Eigen::VectorXd norm_;  // z' M z
};

/// CandidateEvidence while some candidates are in the model already, each with a magnitude that is free.
///   M_s = M - M Z_s (Z_s' M Z_s)^-1 Z_s' M
class Selection {
 public:
  explicit Selection(const CandidateEvidence& evidence, const std::vector<std::size_t>& chosen = {});

  /// All candidates, best first; of the two directions of each place only the better.
  ///   g_k = (z' M_s r)^2 / z' M_s z, one-sided.
  /// Source: docs/gap-workflow.md, "4. Score of an effect".
  std::vector<Score> scores(const Eigen::VectorXd& residual) const;
  /// M_s v.
  Eigen::VectorXd times(const Eigen::VectorXd& v) const;
  /// z_a' M_s z_b.
  double dot(std::size_t a, std::size_t b) const;
  /// Of z_a and z_b in M_s.
  double cosine(std::size_t a, std::size_t b) const;

 private:
  double norm(std::size_t candidate) const;

  const CandidateEvidence& evidence_;
  Eigen::MatrixXd m_z_;    // M Z_s
  Eigen::MatrixXd cross_;  // Z' M Z_s
  Eigen::LDLT<Eigen::MatrixXd> inner_;
};

}  // namespace airside::tools::gap
