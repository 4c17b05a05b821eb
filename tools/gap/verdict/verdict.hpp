#pragma once
// What the workflow says of a log.

#include <string>
#include <vector>

#include "tools/gap/inference/posterior.hpp"
#include "tools/gap/verdict/rules.hpp"

namespace airside::tools::gap {

enum class VerdictKind { none, named, ambiguous, unknown };
const char* text_of(VerdictKind kind);

/// An effect that the workflow holds responsible.
struct Finding {
  sim::EffectAt at;
  double magnitude = 0, sd = 0;
  double share = 0;                             ///< as Alternative::share
  double log_likelihood_ratio = 0;              ///< 2 ln likelihood, by real simulation
  double log_likelihood_limit = 0;              ///< below which it is noise: each effect has its own
  double margin = 0;                            ///< gain over that of the best other effect that was simulated
  double same_sign = 1;                         ///< share of two-day blocks, each by what it can tell
  std::vector<sim::EffectAt> cannot_tell_from;  ///< its class, itself left out
  std::vector<Rival> rivals;                    ///< the likely ones
  std::string why_not;                          ///< empty: sure
};

/// Errors on the locked days, per channel, and summed up where the findings act.
struct LockedDays {
  Eigen::VectorXd rmse_before, rmse_after, mean_before, mean_after;  ///< K, kW, -
  double temp_rmse_before_k = 0, temp_rmse_after_k = 0;              ///< over all temperature channels
  double power_rmse_before_kw = 0, power_rmse_after_kw = 0;
  double score_before = 0, score_after = 0;   ///< root sum of squares over affected channels, each by its noise
  double score_floor = 0;                     ///< what noise alone would give
  double score_right = 0;                     ///< what a right model would: noise, and how drawn buildings differ
  double log_likelihood_ratio = 0;            ///< 2 ln likelihood, parameters as free as the other days leave them
  double predicted_log_likelihood_ratio = 0;  ///< the same, were the findings the whole truth
};

struct Verdict {
  VerdictKind kind = VerdictKind::none;
  std::vector<Finding> findings;         ///< named: all of them sure; ambiguous: the first is the best guess
  std::vector<Finding> unsure;           ///< named: found beside them, but not sure; no model holds it
  ReferenceFit fit;                      ///< to the reference period
  NullBlocks nulls;                      ///< what the reference's own days score
  double best_log_likelihood_ratio = 0;  ///< of any single effect on the unpatched model
  double log_likelihood_limit = 0;       ///< of the first finding, without one of that single effect
  double residual_ratio = 0;             ///< after the findings, over the reference's
  double residual_ratio_limit = 0;       ///< above which something else must be missing
  int buildings = 0;                     ///< drawn ones that count; what they add: as StructureEnsemble
  double buildings_add_alone = 0, buildings_add = 0;
  LockedDays locked;
  std::vector<Alternatives> alternatives;           ///< one a finding of the search, one where it found none
  std::vector<Posterior> posteriors;                ///< of these
  std::vector<Score> ranking;                       ///< of single effects on the unpatched model
  Eigen::MatrixXd residual_before, residual_after;  ///< bins x channels, all days
  Eigen::VectorXd moved;  ///< parameters of the model with the findings beyond the reference's estimate, prior sd
  std::string reason;     ///< one sentence
};

}  // namespace airside::tools::gap
