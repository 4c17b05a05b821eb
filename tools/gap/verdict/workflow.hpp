#pragma once
// From a residual to a verdict: which effect is missing, where, how much, how sure, and does it help on days that
// nobody looked at.

#include <string>
#include <vector>

#include "tools/gap/inference/null_blocks.hpp"

namespace airside::tools::gap {

/// Decision rules.  Source: the algorithm of DESIGN.md, "Gap workflow"; figures: its blind tests.
struct Rules {
  double gain_limit = 30;        ///< a gain below is noise, and so is one below this and
  double null_share = 1;         ///< this times the same effect's best gain in the reference's own blocks
  double margin_gain = 20;       ///< by which the gain exceeds that of every other effect, at least,
  double margin_share = 0.25;    ///< and by this share of what it would if it were the whole truth
  double class_ratio = 1.25;     ///< where that is not so, effects within this ratio are the class
  double class_cosine = 0.97;    ///< responses more alike than this cannot be told apart
  double same_sign_share = 0.8;  ///< of two-day blocks, each by what it can tell
  double leftover_limit = 1.5;   ///< mean square left over that of the reference: more is something else,
  double leftover_days = 9;   ///< in so many fitted days or more; in fewer the excess over 1 may be larger as 1/sqrt,
  double shape_share = 0.15;  ///< but for this share of what the findings explain: no effect has quite its shape,
  double magnitude_share = 0.18;      ///< sd of a magnitude from the twin's other errors, of the way from its null
  double further_share = 0.10;        ///< so one more effect in the same channels must gain this share of that besides
  double locked_share_gained = 0.10;  ///< by which the locked days' error must fall, if what is predicted is not
                                      ///< contradicted there by two of its standard deviations; or it may
  double locked_share_lost = 0.03;    ///< rise by no more than this where
  double locked_gain_share = 0.3;     ///< so much of the 2 ln likelihood is gained that the findings predict,
  double locked_gain = 10;            ///< but no less than this
  double locked_share = 0.3;          ///< of days locked away at the start
  int most_effects = 3;               ///< and unknown where one more would still gain
  int rivals = 4;                     ///< of each finding, put in its stead by real simulation
};

enum class VerdictKind { none, named, ambiguous, unknown };
const char* text_of(VerdictKind kind);

/// A gain that `candidate` must exceed to be no noise: the common limit, and what it gains where nothing is missing.
double gain_limit(const Rules& rules, const NullBlocks& nulls, std::size_t candidate);

/// Another effect in a finding's stead, by real simulation.
struct Rival {
  sim::EffectAt at;
  double gain = 0;    ///< 2 ln likelihood
  double cosine = 0;  ///< of the whitened responses
};

/// By which a finding's gain must exceed that of a rival. Were the finding the whole truth it would by
/// gain (1 - cosine^2); were the rival, it would fall short by as much.
double least_excess(const Rules& rules, double gain, const Rival& rival);

/// An effect that the workflow holds responsible.
struct Finding {
  sim::EffectAt at;
  double magnitude = 0, sd = 0;
  double gain = 0;                              ///< 2 ln likelihood, by real simulation
  double gain_limit = 0;                        ///< below which it is noise: each effect has its own
  double margin = 0;                            ///< gain over that of the best effect outside the class
  double same_sign = 1;                         ///< share of two-day blocks, each by what it can tell
  std::vector<sim::EffectAt> cannot_tell_from;  ///< its class, itself left out
  std::vector<Rival> rivals;                    ///< the likely ones
  std::string why_not;                          ///< empty: named
};

/// Errors on the locked days, per channel, and summed up where the findings act.
struct LockedDays {
  Eigen::VectorXd rmse_before, rmse_after, mean_before, mean_after;  ///< K, kW, -
  double temp_rmse_before_k = 0, temp_rmse_after_k = 0;              ///< over all temperature channels
  double power_rmse_before_kw = 0, power_rmse_after_kw = 0;
  double score_before = 0, score_after = 0;  ///< root sum of squares over affected channels, each by its noise
  double score_floor = 0;                    ///< what noise alone would give
  double gain = 0;                           ///< 2 ln likelihood, parameters as free as the other days leave them
  double predicted_gain = 0;                 ///< the same, were the findings the whole truth
};

struct Verdict {
  VerdictKind kind = VerdictKind::none;
  std::vector<Finding> findings;  ///< named: all; ambiguous: the first is the best guess
  ReferenceFit fit;               ///< to the reference period
  NullBlocks nulls;               ///< what the reference's own days score
  double best_gain = 0;           ///< of any single effect on the unpatched model
  double gain_limit = 0;          ///< of the first finding, without one of that single effect
  double leftover = 0;            ///< after the findings, over the reference's
  double leftover_limit = 0;      ///< above which something else must be missing
  LockedDays locked;
  std::vector<Score> ranking;                       ///< of single effects on the unpatched model
  Eigen::MatrixXd residual_before, residual_after;  ///< bins x channels, all days
  std::string reason;                               ///< one sentence
};

struct CaseData {
  Window reference, test;
};

/// Responses of the two windows; shared by cases that have the same weather and hours.
struct WindowResponses {
  Responses reference, test;
};

/// Cost: some 12 simulations and three for each parameter; as many as half of that for each effect found.
/// Errors: as Engine::simulate.
Verdict analyse(const Engine& engine, const CaseData& data, const WindowResponses& responses, const Rules& rules = {},
                int jobs = 1);

}  // namespace airside::tools::gap
