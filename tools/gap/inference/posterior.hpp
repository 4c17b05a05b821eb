#pragma once
// How probable each explanation of one gap is: every effect that was tried in its stead, nothing at all, or something
// that no effect is.

#include <string>
#include <utility>
#include <vector>

#include "sim/effects/effect.hpp"

namespace airside::tools::gap {

/// One effect tried in a finding's stead, beside the other findings.
struct Alternative {
  sim::EffectAt at;
  std::size_t candidate = 0;  ///< its index in Responses::candidates, in the direction of its magnitude
  double magnitude = 0, sd = 0;
  double share = 0;                 ///< of the way from null: the part of sd that the twin's other errors are
  double log_likelihood_ratio = 0;  ///< 2 ln likelihood that it gains over the model without it
  double of_reference = 0;          ///< the most that it gains in the reference's own blocks
  double residual_ratio = 0;        ///< what it leaves, over the reference's
  int places = 1;                   ///< at which its effect was tried
  double overlap = 0;               ///< of the channels in which it shows with those of the findings beside it, 0 to 1
  double cosine = 0;                ///< of its whitened response with that of the simulated one that gains most, 0 to 1
  bool simulated = false;           ///< false: linear responses alone
  bool found = false;               ///< it is the model's own finding
  bool locked = false;              ///< the two below are known
  double locked_log_likelihood_ratio = 0, locked_expected = 0;  ///< 2 ln likelihood on locked days: came, predicted
};

/// Everything that was tried in the stead of one finding, best first; or of none where nothing was found.
struct Alternatives {
  std::vector<Alternative> list;
  std::vector<std::string> beside;   ///< ids of the other findings, which stay
  double residual_ratio = 0;         ///< without any of them
  double residual_ratio_chance = 0;  ///< above which it is no chance
};

/// The constants of posterior_of(); learned ones from learned().
struct PosteriorModel {
  double temperature = 1;          ///< T_0: a gain counts as this times less than it would be worth in a true model,
  double temperature_gain = 1;     ///< G: and twice that where an effect gains this: errors of shape grow with it
  double null_share = 0;           ///< a, of an effect's own gain in the reference's blocks that is taken off
  double place_share = 1;          ///< c, of ln places that an effect at one of many places loses
  double small_share = 0;          ///< of the way to the bound: a smaller size is improbable,
  double small_power = 0;          ///< q, by this power of it
  double too_small = 0;            ///< ln odds that an effect loses that is nearer to null than such an effect is
  double nothing = 0;              ///< b, score of nothing where nothing gains
  double other = 0;                ///< d, score of something else beside the best effect's,
  double other_left = 0;           ///< e, and by the square of what is left over 1, in units of chance's excess
  double shape_share = 0;          ///< v, and of this share of what is explained: no effect has quite its shape,
  double other_overlap = 0;        ///< h, and where another finding shows in the same channels
  double locked_share = 0;         ///< w, of the locked days' ratio that counts
  double stray = 0;                ///< share of cases about which all this says nothing
  double veto_p = 0.001;           ///< a name is contradicted where locked days are less probable
  double veto_inflation = 7;       ///< of the variance 4 e of what they should give, e that was predicted,
  double veto_share = 0.25;        ///< besides this share of e as a standard deviation
  double name_probability = 0.95;  ///< of what is not something else: above, it is a name,
  double name_other = 0.3;         ///< unless something else is more probable than this
  double set_probability = 0.9;    ///< that the smallest set holds

  static const PosteriorModel& learned();
  /// Where no buildings are drawn: of models with controls of their own, and with --buildings 0.
  static const PosteriorModel& learned_without_buildings();
  /// Of models in whose stead an RC room answers.
  static const PosteriorModel& learned_by_surrogate();
};

struct EffectProbability {
  sim::EffectAt at;
  double probability = 0;
  bool vetoed = false;   ///< by the locked days
  std::size_t from = 0;  ///< index in Alternatives::list
};

/// Sums to one.
struct Posterior {
  std::vector<EffectProbability> effects;  ///< best first
  double nothing = 0, other = 0;
  std::vector<std::string> set;  ///< ids, "nothing", "other": the fewest that hold PosteriorModel::set_probability
  double name_needs = 1;         ///< PosteriorModel::name_probability
  /// Its first effect is more probable than `name_needs` of what is not something else, which is less probable than
  /// PosteriorModel::name_other, no locked day contradicts it, and it is as large as it is at least.
  bool sure = false;
  double likeliest() const { return effects.empty() ? 0 : effects.front().probability; }
};

/// 1 - stray of a softmax; the rest is shared evenly by what was simulated, nothing and something else. The scores are
///   x_k = max(0, g_k - a n_k),  X = max x,  T_k = T_0 max(1, rho) (1 + x_k / G)
///   s_k = (w l_k - (X - x_k)) / 2 T_k - c ln places + ln prior(size),  s_nothing = b - X / 2 T_0
///   s_other = max(max_k s_k + d + e (max(0, rho - 1) / (rho_chance - 1 + v (rho_0 - rho)))^2 + h o^2,
///                 s_nothing + f (max(0, rho - 1) / (rho_chance - 1))^2 - f),  f = 4
/// g gains, n the reference's own, l came on locked days, rho what the effect with the largest x leaves, rho_0 what is
/// left without it, o its overlap with other findings. Source: docs/gap-workflow.md, "How probable each effect is".
Posterior posterior_of(const Alternatives& tried, const PosteriorModel& model = PosteriorModel::learned());

/// By which a ratio must exceed a rival's for a name, were there only these two: 2 T ln(p / (1 - p)), T the
/// temperature at this ratio, p PosteriorModel::name_probability.
double sure_excess(double log_likelihood_ratio, const PosteriorModel& model);

/// The fewest explanations whose probabilities sum to `wanted`, the most probable first; of equal ones the first of
/// `all`.
std::vector<std::string> smallest_set(std::vector<std::pair<std::string, double>> all, double wanted);

/// Whether locked days contradict what an effect predicted: p(came | N(e, 4 e i + (s e)^2)) < veto_p, for what came <
/// e.
bool locked_days_veto(const Alternative& a, const PosteriorModel& model = PosteriorModel::learned());

}  // namespace airside::tools::gap
