#pragma once
// What every part of the verdict looks at: both windows as evidence, the fit to the reference, what its own days score,
// and the refits of the measured window.

#include <vector>

#include "tools/gap/inference/posterior.hpp"
#include "tools/gap/inference/refit.hpp"
#include "tools/gap/inference/structure_ensemble.hpp"
#include "tools/gap/verdict/rules.hpp"

namespace airside::tools::gap {

/// Parts refer to each other, so it stays where it was made; the arguments are kept by reference.
/// Errors: as Engine::simulate.  Cost: as fit_reference(), null_blocks() and a Refitter.
struct FittedCase {
  FittedCase(const Engine& engine, const CaseData& data, const WindowResponses& responses, const Rules& rules, int jobs,
             Refitter::Start start = Refitter::Start::reference);
  FittedCase(const FittedCase&) = delete;
  FittedCase& operator=(const FittedCase&) = delete;

  const Engine& engine;
  const CaseData data;  ///< evidence_of() both windows
  const WindowResponses& responses;
  const Rules& rules;
  const std::vector<bool> kept;  ///< bins of the measured window that are fitted: neither the first day nor locked ones
  const ReferenceFit fit;        ///< prior_fit() without a reference period
  const int jobs;
  const NullBlocks nulls;
  StructureEnsemble ensemble;
  Refitter refitter;

  /// Draws the buildings; the refitter's tangent must be simulated.
  void draw_buildings();

  Eigen::Index bins() const { return data.test.measured.rows(); }
  const Candidate& candidate(const Chosen& c) const { return responses.test.candidates[c.candidate]; }
  double limit(std::size_t candidate) const { return log_likelihood_limit(rules, nulls, candidate); }
  /// Whether the last of the chosen effects is as large as such an effect is at least.
  bool plausible(const Refit& at) const;
  /// Whether this effect at this place is chosen already, in either direction.
  bool already(const Refit& now, std::size_t candidate) const;
  /// Of the posterior.
  const PosteriorModel& constants() const {
    if (engine.stand_in()) return PosteriorModel::learned_by_surrogate();
    return ensemble.rooms > 0 ? PosteriorModel::learned() : PosteriorModel::learned_without_buildings();
  }
  /// As Rules::alternatives.
  int alternatives() const { return engine.spares_runs() ? rules.dear_alternatives : rules.alternatives; }
  /// Values that are fitted, at least 1.
  double samples() const;
  /// What is left by chance scatters the more the fewer days are fitted: the limit of Verdict::residual_ratio without
  /// findings.
  double residual_ratio_of_chance() const;
};

/// The chosen effects' magnitudes are free, but for number `left_out`.
Selection beside(const Refit& now, std::size_t left_out);

/// Whether a candidate shows in the channels in which chosen effects show: the largest cosine of the channels' norms of
/// whitened responses, 0 to 1; 0 where nothing is chosen.
double channel_overlap(const Tangent& tangent, const std::vector<Chosen>& chosen, std::size_t candidate);

/// What the wrong shape of chosen effects may look like: a share of the 2 ln likelihood that they explain, as far as
/// they show in the channels in which the candidate shows.
double shape_error(const Rules& rules, const Tangent& tangent, const std::vector<Chosen>& chosen, double explained,
                   std::size_t candidate);

}  // namespace airside::tools::gap
