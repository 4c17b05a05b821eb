#pragma once
// By which figures the workflow decides.

#include <algorithm>
#include <cmath>

#include "tools/gap/inference/null_blocks.hpp"

namespace airside::tools::gap {

/// Decision rules.  Source: docs/gap-workflow.md, "6. When an effect is named"; figures: docs/gap-figures.md.
struct Rules {
  double log_likelihood_limit = 30;   ///< a gain below is noise, and so is one below this and
  double null_share = 1;              ///< this times the same effect's best gain in the reference's own blocks
  double margin_log_likelihood = 20;  ///< by which the gain exceeds that of every other effect, at least,
  double margin_share = 0.25;         ///< and by this share of what it would if it were the whole truth
  double class_ratio = 1.25;          ///< where that is not so, effects within this ratio are the class
  double class_cosine = 0.97;         ///< responses more alike than this are not separable
  double same_sign_share = 0.8;       ///< of two-day blocks, each by what it can tell
  double residual_ratio_limit = 1.5;  ///< mean square left over that of the reference: more is something else,
  double residual_ratio_days = 9;     ///< from this number of fitted days on; in fewer the excess over 1 may be larger
                                      ///< as 1/sqrt, but
  double shape_share = 0.15;          ///< for this share of what the findings explain: no effect has quite its shape,
  double magnitude_share = 0.18;      ///< sd of a magnitude from the twin's other errors, of the way from its null
  double further_share = 0.10;        ///< so one more effect in the same channels must gain this share of that besides
  double locked_share_gained = 0.10;  ///< by which the locked days' error must fall, if what is predicted is not
                                      ///< contradicted there by two of its standard deviations; or it may
  double locked_share_lost = 0.03;    ///< rise by no more than this where
  double locked_log_likelihood_share = 0.3;  ///< of the 2 ln likelihood that the findings predict is gained,
  double locked_log_likelihood = 10;         ///< but no less than this
  double locked_share = 0.3;                 ///< of days locked away at the start
  int most_effects = 3;                      ///< and unknown where one more would still gain
  int rivals = 4;                            ///< of each finding, put in its stead by real simulation
  double rival_share = 0.2;                  ///< of the finding's gain: a rival below is not of its class however alike
  int first_looks = 4;                       ///< candidates that a round of the search tries by real simulation,
  double first_look_share = 0.5;             ///< with at least this share of the best one's gain by linear responses
  double unconfirmed_ratio = 4;  ///< times its limit by linear responses, though no simulation reaches the limit:
                                 ///< it is not that effect, but it is a gap, and so unknown
  double affected_share = 0.5;   ///< of how far the findings move the channel that they move most, in its noise:
                                 ///< channels that move as far count on the locked days
  int buildings = 0;             ///< drawn for StructureEnsemble, and the posterior draws the verdict;
                                 ///< 0: how they differ is asked of the reference alone, and rules draw it
  int alternatives = 12;         ///< of each finding, for its posterior, by real simulation,
  int dear_alternatives = 6;     ///< on an engine that spares runs,
  int locked_looks = 5;          ///< and of those, best first, that are held against the locked days
  double contradiction_sd = 2;   ///< standard deviations by which locked days fall short of what was predicted
};

/// A gain that `candidate` must exceed to be no noise: the common limit, and what it gains where nothing is missing.
inline double log_likelihood_limit(const Rules& rules, const NullBlocks& nulls, std::size_t candidate) {
  return rules.log_likelihood_limit + rules.null_share * nulls.log_likelihood_ratio[candidate];
}

/// Another effect in a finding's stead, by real simulation.
struct Rival {
  sim::EffectAt at;
  double log_likelihood_ratio = 0;  ///< 2 ln likelihood
  double cosine = 0;                ///< of the whitened responses
};

/// By which a finding's gain must exceed that of a rival. Were the finding the whole truth it would by
/// gain (1 - cosine^2); were the rival, it would fall short by as much.
inline double least_excess(const Rules& rules, double log_likelihood_ratio, const Rival& rival) {
  return std::max(rules.margin_log_likelihood,
                  rules.margin_share * log_likelihood_ratio * (1 - rival.cosine * rival.cosine));
}

/// First bin of the days that are locked away.
inline Eigen::Index locked_from(const Rules& rules, Eigen::Index bins) {
  const Eigen::Index days = bins / bins_per_day;
  return (days - static_cast<Eigen::Index>(std::lround(rules.locked_share * static_cast<double>(days)))) * bins_per_day;
}

}  // namespace airside::tools::gap
