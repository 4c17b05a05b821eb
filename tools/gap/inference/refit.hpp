#pragma once
// A model with some effects in it, fitted to the measured period by real simulations: magnitudes freely, parameters
// as far as the reference period leaves them free.

#include <functional>
#include <memory>
#include <mutex>
#include <vector>

#include "tools/gap/inference/null_blocks.hpp"

namespace airside::tools::gap {

/// A candidate with a magnitude.
struct Chosen {
  std::size_t candidate = 0;
  double steps = 1;   ///< of the way from null to probe
  bool held = false;  ///< it stays as it is, whatever is fitted
};

/// What parameters and candidates do to the sensors about one model.
class Tangent {
 public:
  /// `parameters` and `z`: whitened responses of `responses` and of the candidates.  `mixing`: C_pp of distance().
  Tangent(const std::vector<Candidate>& candidates, std::shared_ptr<const Eigen::MatrixXd> z, Metric metric,
          Eigen::MatrixXd mixing, Eigen::MatrixXd parameters, std::vector<Parameter> responses);

  const CandidateEvidence& evidence() const { return evidence_; }
  const Metric& metric() const { return evidence_.metric(); }
  /// Whitened responses to one prior standard deviation of each parameter.
  const Eigen::MatrixXd& parameters() const { return parameters_; }
  /// The same of all bins, as they are.
  const std::vector<Parameter>& responses() const { return responses_; }
  /// The parameters' mean given r, in prior standard deviations: (L J'M r), first rows.
  Eigen::VectorXd mean(const Eigen::VectorXd& r) const;
  /// What a simulation at parameters `moved` leaves and costs: -2 ln of its probability, the other nuisances at their
  /// best.  With L = C C', C lower triangular, parameters first, p = C_pp u:
  ///   u'u + s' M_o s,  s = r - J_o C_op u
  double distance(const Eigen::VectorXd& r, const Eigen::VectorXd& moved) const;
  /// s of distance().
  Eigen::VectorXd without_moved(const Eigen::VectorXd& r, const Eigen::VectorXd& moved) const;
  /// M_o of distance().
  const Metric& others() const { return others_; }

 private:
  Eigen::Index count() const { return std::ssize(responses_); }

  std::vector<Parameter> responses_;
  Eigen::MatrixXd parameters_, mixing_;
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

/// What was not fitted, under two models.
struct Predicted {
  double log_likelihood_ratio = 0;  ///< 2 ln of how much likelier the one makes it than the other
  double expected = 0;              ///< the same, were the one right
};

/// Cost of each fit: up to 14 simulations; of a tangent, the first included: one a parameter, but none on an engine
/// that spares runs: there responses about the twin itself do for all models.
class Refitter {
 public:
  /// About the reference's fit, or, without a simulation, about the twin itself.
  enum class Start { reference, twin };

  /// `kept`: bins that are fitted.  The references are kept.
  Refitter(const Engine& engine, const Window& window, const Responses& responses, const ReferenceFit& fit,
           const Nuisance& sizes, std::vector<bool> kept, int jobs, Start start = Start::reference);
  /// What Start::twin has put off.
  void simulate_tangent();
  /// What buildings have in common and how they differ counts from now on.  Shape: bins x channels each, as of
  /// StructureEnsemble.
  void set_structure(const Eigen::MatrixXd& mean, std::vector<Eigen::MatrixXd> directions);

  /// About the reference's fit, or where it started.
  const std::shared_ptr<const Tangent>& tangent() const { return tangent_; }
  /// Simulated, not fitted.
  Refit at(const std::vector<Chosen>& chosen, const Eigen::VectorXd& moved,
           const std::shared_ptr<const Tangent>& tangent) const;
  /// Gauss-Newton on magnitudes and parameters from a simulated model on, never worse than that; r = d - y(s, p) + D p.
  /// What each simulation is worth does not depend on the tangent, which only shows the way; where the way bends, less
  /// of the step is gone (parabola), or, where that loses too, magnitudes go alone: when parameters move, fan coils
  /// switch at other times by chance, which may cost more than the effect gains.
  /// Responses of magnitudes begin as those of the probes; what each simulation shows of how they bend is put into
  /// them, as far as they moved and not the parameters (Broyden's update), so that an effect that saturates is met too.
  Refit refit(const Refit& from, const std::shared_ptr<const Tangent>& tangent) const;
  /// One effect more, in the tangent that shows `added`. One that gains much less than its response says, and whose
  /// responses to its two probes are not each other's mirror image, is tried from its probe too: what comes an hour
  /// late looks otherwise than what comes ten minutes late.
  Refit add(const Refit& to, const Score& added, const std::shared_ptr<const Tangent>& tangent) const;
  /// One effect more at a quarter, half, three quarters or all of its bound, simulated without a fit, parameters where
  /// they are: of each effect whose responses to its probes are not each other's mirror image and that `open` lets in
  /// the size of least cost, best first and `most` of them. People who come two hours late show nothing of a response
  /// to ten minutes.
  /// Which sizes are simulated is chosen by what each shows in the reference's model, added to what `now` shows.
  /// Cost: four simulations a candidate once, and `most`; empty on an engine that spares runs.
  std::vector<Refit> far(const Refit& now, std::size_t most, const std::function<bool(std::size_t)>& open) const;
  /// The same about the model itself: what saturates there answers to other parameters than the twin does.
  Refit about_itself(const Refit& at) const;

  /// Of the reference's model with these effects.  Shape: bins x channels.
  Eigen::MatrixXd unmoved_residual(const std::vector<Chosen>& chosen) const;
  Eigen::VectorXd whiten(const Eigen::MatrixXd& x) const;
  /// Of the bins outside `kept`, each model about itself, its parameters as free as the kept bins leave them.  With e
  /// the residual at the reference's parameters, M of all bins and M_k of the kept, d = e_without - e_with:
  ///   -2 ln p = e' (M - M_k) e + ln det M^-1 - ln det M_k^-1,  expected = d' (M - M_k) d, d and the metrics in the
  /// tangent of `without`
  Predicted predicted(const Refit& with, const Refit& without) const;
  /// Of r at the reference's parameters.
  Eigen::VectorXd effective(const Refit& at) const;
  double magnitude(const Chosen& chosen) const;
  /// The model's changes.
  Changes changes(const std::vector<Chosen>& chosen, const Eigen::VectorXd& moved) const;

 private:
  Eigen::MatrixXd residual_of(const std::vector<Chosen>& chosen, const Eigen::VectorXd& moved) const;
  std::shared_ptr<const Eigen::MatrixXd> whitened_candidates() const;
  /// What no tangent changes.
  struct Structure {
    Eigen::MatrixXd with_parameters;  ///< whitened structure that comes with each parameter
    std::shared_ptr<const SharedColumns> shared;
  };
  struct Own {
    Eigen::MatrixXd parameters;  ///< whitened, of one prior standard deviation
    Metric metric;
  };
  Structure structure_of(const std::vector<bool>& bins, std::shared_ptr<const Eigen::MatrixXd> z) const;
  Own own_of(const std::vector<Parameter>& parameters, const std::vector<bool>& bins, const Structure& structure) const;
  std::shared_ptr<const Tangent> tangent_with(std::vector<Parameter> parameters) const;
  std::vector<Parameter> parameters_at(const std::vector<Chosen>& chosen, const Eigen::VectorXd& moved) const;
  std::vector<Parameter> parameters_at_fit() const;
  Changes changes_of(const std::vector<Chosen>& chosen) const;
  void judge(Refit& at) const;
  /// One step of refit() on magnitudes, with the parameters where they are.
  Refit magnitudes_alone(const Refit& from, const Eigen::MatrixXd& z) const;
  bool bends(std::size_t candidate) const;
  /// A quarter, half, three quarters and all of the bound of each candidate that bends.
  struct FarSizes {
    std::vector<Chosen> sizes;
    Eigen::MatrixXd z;  ///< what each shows in the reference's model, whitened
  };
  const FarSizes& far_sizes() const;
  Eigen::MatrixXd responses_of(const Refit& at) const;

  const Engine& engine_;
  const Window& window_;
  const Responses& responses_;
  const ReferenceFit& fit_;
  std::vector<bool> kept_;
  int jobs_;
  const Nuisance sizes_;
  std::vector<Eigen::MatrixXd> ensemble_;
  std::vector<bool> all_;  // bins, the kept ones among them
  Eigen::MatrixXd structural_;
  std::shared_ptr<const Eigen::MatrixXd> z_;  // whitened candidates
  Eigen::MatrixXd mixing_;                    // the square root of what the reference leaves of all directions
  Structure structure_;                       // of the kept bins
  std::shared_ptr<const Tangent> tangent_;
  mutable std::once_flag far_once_;
  mutable FarSizes far_;
};

}  // namespace airside::tools::gap
