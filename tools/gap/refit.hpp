#pragma once
// A model with some effects in it, fitted to the measured period by real simulations: magnitudes freely, parameters
// as far as the reference period leaves them free.

#include <memory>
#include <vector>

#include "tools/gap/null_blocks.hpp"

namespace airside::tools::gap {

/// A candidate with a magnitude.
struct Chosen {
  std::size_t candidate = 0;
  double steps = 1;  ///< of the way from null to probe
};

/// What parameters and candidates do to the sensors about one model.
class Tangent {
 public:
  /// Whitened.
  Tangent(const std::vector<Candidate>& candidates, NuisanceResponses nuisance, Eigen::MatrixXd mixing,
          std::shared_ptr<const Eigen::MatrixXd> z, Eigen::Index parameters);

  const CandidateEvidence& evidence() const { return evidence_; }
  const Metric& metric() const { return evidence_.metric(); }
  /// Whitened responses to one prior standard deviation of each parameter.
  auto parameters() const { return nuisance_.directions.leftCols(parameters_); }
  /// The parameters' mean given r, in prior standard deviations: (L J'M r), first rows.
  Eigen::VectorXd mean(const Eigen::VectorXd& r) const;
  /// What a simulation at parameters `moved` leaves and costs: -2 ln of its probability, the other nuisances at their
  /// best.  With L = C C', C lower triangular, parameters first, p = C_pp u:
  ///   u'u + s' M_o s,  s = r - J_o C_op u
  double distance(const Eigen::VectorXd& r, const Eigen::VectorXd& moved) const;

 private:
  Eigen::Index parameters_;
  NuisanceResponses nuisance_;
  Eigen::MatrixXd mixing_;
  CandidateEvidence evidence_;
  Metric others_;  // structure and days
};

struct Refit {
  std::vector<Chosen> chosen;
  Eigen::VectorXd moved;     ///< parameters beyond the reference's estimate, prior standard deviations
  Eigen::MatrixXd residual;  ///< bins x channels; of the model with both
  double distance = 0;       ///< what is left, and what the parameters' move costs
  double cost = 0;           ///< -2 ln evidence, up to a constant of the window: distance + ln det M^-1
  std::shared_ptr<const Tangent> tangent;
};

/// Cost of each fit: up to 5 simulations; of a tangent, the first included: one a parameter, but none on an engine that
/// spares runs: there responses about the twin itself do for all models.
class Refitter {
 public:
  /// `kept`: bins that are fitted.  The references are kept.
  Refitter(const Engine& engine, const Window& window, const Responses& responses, const ReferenceFit& fit,
           const Nuisance& sizes, std::vector<bool> kept, int jobs);

  /// About the reference's fit.
  const std::shared_ptr<const Tangent>& tangent() const { return tangent_; }
  /// Gauss-Newton on magnitudes and parameters with real simulations; r = d - y(s, p) + D p.  What each simulation is
  /// worth does not depend on its tangent, which only shows the way.
  /// Responses of magnitudes begin as those of the probes; what each simulation shows of how they bend is put into
  /// them (Broyden's update), so that an effect that saturates is met all the same.
  Refit refit(const std::vector<Chosen>& chosen, const std::shared_ptr<const Tangent>& tangent,
              const Eigen::VectorXd& moved) const;
  /// The same about the model itself: what saturates there answers to other parameters than the twin does.
  Refit about_itself(const Refit& at) const;

  /// Of the reference's model with these effects.  Shape: bins x channels.
  Eigen::MatrixXd unmoved_residual(const std::vector<Chosen>& chosen) const;
  Eigen::VectorXd whiten(const Eigen::MatrixXd& x) const;
  /// Of r at the reference's parameters.
  Eigen::VectorXd effective(const Refit& at) const;
  double magnitude(const Chosen& chosen) const;
  /// The model's changes.
  Changes changes(const std::vector<Chosen>& chosen, const Eigen::VectorXd& moved) const;

 private:
  Eigen::MatrixXd residual_of(const std::vector<Chosen>& chosen, const Eigen::VectorXd& moved) const;
  std::shared_ptr<const Tangent> tangent_with(const std::vector<Parameter>& parameters) const;
  std::shared_ptr<const Tangent> tangent_at(const std::vector<Chosen>& chosen, const Eigen::VectorXd& moved) const;
  Changes changes_of(const std::vector<Chosen>& chosen) const;
  void judge(Refit& at) const;

  const Engine& engine_;
  const Window& window_;
  const Responses& responses_;
  const ReferenceFit& fit_;
  std::vector<bool> kept_;
  int jobs_;
  const Nuisance sizes_;
  Eigen::MatrixXd structural_;
  std::shared_ptr<const Eigen::MatrixXd> z_;  // whitened candidates
  std::shared_ptr<const Tangent> tangent_;
};

}  // namespace airside::tools::gap
