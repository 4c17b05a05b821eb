#pragma once
// From a residual to a verdict: which effect is missing, where, how much, how sure, and does it help on days that
// nobody looked at.

#include <string>
#include <vector>

#include "tools/gap/null_blocks.hpp"

namespace airside::tools::gap {

/// Decision rules.  Source: the algorithm of DESIGN.md, "Gap workflow". The figures are not calibrated yet.
struct Rules {
  double gain_limit = 40;        ///< a gain below is noise, and so is one below this and
  double null_share = 1;         ///< this times the best gain of the reference's own blocks
  double margin_ratio = 1.25;    ///< gain over the best effect of another class, at least
  double margin_gain = 12;       ///< and so much more in 2 ln likelihood
  double class_cosine = 0.97;    ///< responses more alike than this cannot be told apart
  double same_sign_share = 0.8;  ///< of two-day blocks
  double leftover_limit = 1.6;   ///< mean square left over that of the reference: more is something else,
  double shape_share = 0.1;      ///< but for this share of what the findings explain: no effect has quite its shape
  double locked_gain = 0.10;     ///< share by which the locked days' error must fall
  double locked_share = 0.3;     ///< of days locked away at the start
  int most_effects = 3;
  int rivals = 4;  ///< of each finding, put in its stead by real simulation
};

enum class VerdictKind { none, named, ambiguous, unknown };
const char* text_of(VerdictKind kind);

/// An effect that the workflow holds responsible.
struct Finding {
  sim::EffectAt at;
  double magnitude = 0, sd = 0;
  double gain = 0;                              ///< 2 ln likelihood, by real simulation
  double margin = 0;                            ///< gain over that of the best effect outside the class
  double same_sign = 1;                         ///< share of two-day blocks
  std::vector<sim::EffectAt> cannot_tell_from;  ///< its class, itself left out
  std::string why_not;                          ///< empty: named
};

/// Errors on the locked days, per channel, and summed up where the findings act.
struct LockedDays {
  Eigen::VectorXd rmse_before, rmse_after, mean_before, mean_after;  ///< K, kW, -
  double temp_rmse_before_k = 0, temp_rmse_after_k = 0;              ///< over all temperature channels
  double power_rmse_before_kw = 0, power_rmse_after_kw = 0;
  double score_before = 0, score_after = 0;  ///< root sum of squares over affected channels, each by its noise
  double score_floor = 0;                    ///< what noise alone would give
};

struct Verdict {
  VerdictKind kind = VerdictKind::none;
  std::vector<Finding> findings;  ///< named: all; ambiguous: the first is the best guess
  NullBlocks nulls;               ///< what the reference's own days score
  double best_gain = 0;           ///< of any single effect on the unpatched model
  double gain_limit = 0;          ///< below which a gain is noise
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

/// Cost: 4 simulations, and 4 to 12 for each effect found.
/// Errors: as Engine::simulate.
Verdict analyse(const Engine& engine, const CaseData& data, const WindowResponses& responses, const Rules& rules = {});

}  // namespace airside::tools::gap
