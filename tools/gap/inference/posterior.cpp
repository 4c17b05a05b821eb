#include "tools/gap/inference/posterior.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace airside::tools::gap {

namespace {

double net_gain(const Alternative& a, const PosteriorModel& model) {
  return std::max(0.0, a.log_likelihood_ratio - model.null_share * a.of_reference);
}

/// ln prior: of one place among its effect's, and of its size.
double ln_prior(const Alternative& a, const PosteriorModel& model) {
  const sim::Effect& e = *a.at.effect;
  double ln = -model.place_share * std::log(std::max(1, a.places));
  const double width = std::abs((a.magnitude < e.null_value ? e.low : e.high) - e.null_value);
  const double share = width > 0 ? std::abs(a.magnitude - e.null_value) / width : 0;
  if (share < model.small_share) ln += model.small_power * std::log(std::max(share, 1e-3) / model.small_share);
  if (!e.plausible(a.magnitude)) ln -= model.too_small;
  return ln;
}

void add_set(Posterior& p, double wanted) {
  std::vector<std::pair<double, std::string>> all{{p.nothing, "nothing"}, {p.other, "other"}};
  for (const EffectProbability& e : p.effects) all.emplace_back(e.probability, e.at.id());
  std::stable_sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  double sum = 0;
  for (const auto& [probability, id] : all) {
    p.set.push_back(id);
    sum += probability;
    if (sum >= wanted) break;
  }
}

}  // namespace

/// Learned on the first 12 cases of `airside gap blind --only single --cases 72 --seed 403`, judged on 13d8471 with the
/// refits of 06ebf4d.
const PosteriorModel& PosteriorModel::learned() {
  static const PosteriorModel model = [] {
    PosteriorModel m;
    m.temperature = 2.26;
    m.temperature_gain = 89;
    m.null_share = 0.55;
    m.place_share = 0.52;
    m.small_share = 0.05;
    m.small_power = 0.65;
    m.too_small = 2.0;
    m.nothing = 5.3;
    m.other = -3.7;
    m.other_ratio = 0.78;
    m.locked_share = 0.21;
    return m;
  }();
  return model;
}

/// Learned on 28 cases of `airside gap blind --rough --window 2` with drawn buildings: 9 of --only single --ratio 1
/// --seed 421, 9 of --ratio 3 --seed 422, 10 of --only null --seed 423.
const PosteriorModel& PosteriorModel::learned_with_buildings() {
  static const PosteriorModel model = [] {
    PosteriorModel m;
    m.temperature = 1.29;
    m.temperature_gain = 188;
    m.null_share = 0.71;
    m.place_share = 0.57;
    m.small_share = 0.05;
    m.small_power = 0;
    m.too_small = 2.0;
    m.nothing = 5.46;
    m.other = -4.04;
    m.other_ratio = 1.02;
    m.locked_share = 0.43;
    return m;
  }();
  return model;
}

bool locked_days_veto(const Alternative& a, const PosteriorModel& model) {
  if (!a.locked || a.locked_log_likelihood_ratio >= a.locked_expected) return false;
  const double sd = std::hypot(std::sqrt(std::max(1.0, 4 * a.locked_expected * model.veto_inflation)),
                               model.veto_share * a.locked_expected);
  const double z = (a.locked_expected - a.locked_log_likelihood_ratio) / sd;
  return std::erfc(z / std::sqrt(2.0)) / 2 < model.veto_p;
}

Posterior posterior_of(const Alternatives& tried, const PosteriorModel& model) {
  double best_gain = 0;
  for (const Alternative& a : tried.list) best_gain = std::max(best_gain, net_gain(a, model));
  const double temperature = model.temperature * (1 + best_gain / model.temperature_gain);
  std::vector<double> scores;
  double best = 0, left = tried.residual_ratio;
  for (const Alternative& a : tried.list) {
    const double locked = a.locked ? model.locked_share * a.locked_log_likelihood_ratio : 0;
    scores.push_back((net_gain(a, model) + locked) / (2 * temperature) + ln_prior(a, model));
    if (a.simulated && scores.back() > best) {
      best = scores.back();
      left = a.residual_ratio;
    }
  }
  const double chance = std::max(0.1, tried.residual_ratio_chance - 1);
  const double other = best + model.other + model.other_ratio * (left - 1) / chance;
  const double most = std::max({best, other, model.nothing});
  double sum = std::exp(model.nothing - most) + std::exp(other - most);
  for (const double s : scores) sum += std::exp(s - most);
  Posterior p;
  p.nothing = std::exp(model.nothing - most) / sum;
  p.other = std::exp(other - most) / sum;
  for (std::size_t i = 0; i < scores.size(); ++i) {
    const Alternative& a = tried.list[i];
    p.effects.push_back({a.at, std::exp(scores[i] - most) / sum, locked_days_veto(a, model), i});
  }
  std::stable_sort(p.effects.begin(), p.effects.end(),
                   [](const auto& a, const auto& b) { return a.probability > b.probability; });
  add_set(p, model.set_probability);
  p.sure = !p.effects.empty() && p.effects.front().probability > model.name_probability && !p.effects.front().vetoed;
  return p;
}

}  // namespace airside::tools::gap
