#pragma once
// By which figures the workflow decides.

#include <algorithm>
#include <cmath>

#include "tools/gap/inference/null_blocks.hpp"

namespace airside::tools::gap {

/// What the search takes for an effect, and which days are locked.  The verdict itself is PosteriorModel's.
/// Source: docs/gap-workflow.md, "5. Selection and refit"; figures: docs/gap-figures.md.
struct Rules {
  double log_likelihood_limit = 30;   ///< a gain below is noise, and so is one below this and
  double null_share = 1;              ///< this times the same effect's best gain in the reference's own blocks
  double further_share = 0.10;        ///< one more effect in the same channels must gain this share of that besides
  double residual_ratio_limit = 1.5;  ///< mean square left over that of the reference: more is no chance,
  double residual_ratio_days = 9;     ///< from this number of fitted days on; in fewer the excess over 1 may be larger
                                      ///< as 1/sqrt
  double magnitude_share = 0.30;      ///< Alternative::share of what was simulated
  double locked_share = 0.3;          ///< of days locked away at the start
  double affected_share = 0.5;        ///< of how far the findings move the channel that they move most, in its noise:
                                      ///< channels that move as far count on the locked days
  int most_effects = 3;               ///< and unknown where one more would still gain
  int first_looks = 4;                ///< candidates that a round of the search tries by real simulation,
  double first_look_share = 0.5;      ///< with at least this share of the best one's gain by linear responses
  int buildings = 0;          ///< drawn for StructureEnsemble; 0: how they differ is asked of the reference alone
  int alternatives = 12;      ///< of each finding, for its posterior, by real simulation,
  int dear_alternatives = 6;  ///< on an engine that spares runs,
  int locked_looks = 5;       ///< and of those, best first, that are held against the locked days
};

/// A gain that `candidate` must exceed to be no noise: the common limit, and what it gains where nothing is missing.
inline double log_likelihood_limit(const Rules& rules, const NullBlocks& nulls, std::size_t candidate) {
  return rules.log_likelihood_limit + rules.null_share * nulls.log_likelihood_ratio[candidate];
}

/// Another effect in a finding's stead, by real simulation.
struct Rival {
  sim::EffectAt at;
  double log_likelihood_ratio = 0;  ///< 2 ln likelihood
};

/// First bin of the days that are locked away.
inline Eigen::Index locked_from(const Rules& rules, Eigen::Index bins) {
  const Eigen::Index days = bins / bins_per_day;
  return (days - static_cast<Eigen::Index>(std::lround(rules.locked_share * static_cast<double>(days)))) * bins_per_day;
}

}  // namespace airside::tools::gap
