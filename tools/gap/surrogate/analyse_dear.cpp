#include "tools/gap/surrogate/analyse_dear.hpp"

#include <algorithm>
#include <cmath>
#include <set>

#include "tools/gap/inference/reference_fit.hpp"
#include "tools/gap/inference/structure_ensemble.hpp"

namespace airside::tools::gap {

namespace {

constexpr double near_enough = 0.7;  // of its size, or over it: an effect that was run
constexpr double least_probability = 0.01;
constexpr int most_bent = 3;
constexpr double bent = 0.3;  // of what an effect shows at its bound: so much is not in proportion to its size

/// The likely ones in each finding's place, as large as they are.
std::vector<sim::EffectChange> likely(const Engine& engine, const Verdict& v) {
  std::vector<sim::EffectChange> changes;
  std::set<std::string> ids;
  const auto take = [&](const sim::EffectAt& at, double magnitude) {
    if (magnitude == at.effect->null_value || engine.only_shows(*at.effect)) return;
    if (ids.insert(at.id()).second) changes.push_back({at, magnitude});
  };
  for (std::size_t i = 0; i < v.posteriors.size(); ++i) {
    int taken = 0;
    for (const EffectProbability& e : v.posteriors[i].effects) {
      const Alternative& a = v.alternatives[i].list[e.from];
      if (taken == dear_effects || (taken >= dear_effects / 2 && e.probability < least_probability)) break;
      if (!a.simulated) continue;
      ++taken;
      take(a.at, a.magnitude);
    }
  }
  return changes;
}

/// The model is run at the estimate of the reference period until what it shows there is what was expected of it.
void anchor_at_fit(SurrogateEngine& surrogate, const Engine& engine, const CaseData& data,
                   const WindowResponses& responses, int jobs) {
  constexpr int most_fits = 6;
  constexpr double as_expected_k = 0.03;
  if (!data.has_reference()) return;  // parameters are what their priors have
  const sim::Recording& days = data.reference.recording;
  Changes fitted;
  for (int i = 0; i < most_fits; ++i) {
    fitted = fit_reference(engine, responses.reference, data.reference, jobs).changes();
    const sim::ChannelTable expected = engine.simulate(fitted, days);
    surrogate.anchor(fitted, days);
    const Eigen::Index temperatures = engine.channels().mau_temp();
    const sim::ChannelTable off = (engine.simulate(fitted, days) - expected).leftCols(temperatures);
    if (off.norm() < as_expected_k * std::sqrt(static_cast<double>(off.size()))) break;
  }
  surrogate.anchor(fitted, data.test.recording);
}

bool was_run(double share) { return share > near_enough && share < 1 / near_enough; }

/// Whether at its bound the effect shows something else than it does now, in proportion.
bool bends(const Engine& engine, const sim::EffectChange& change, double bound, const sim::Recording& days) {
  const Eigen::Index shown = engine.channels().fcu_duty();
  const double null = change.at.effect->null_value;
  const sim::ChannelTable none = engine.simulate({}, days).leftCols(shown);
  const sim::ChannelTable now = engine.simulate({change}, days).leftCols(shown) - none;
  const sim::ChannelTable far = engine.simulate({{change.at, bound}}, days).leftCols(shown) - none;
  return (far - (bound - null) / (change.magnitude - null) * now).norm() > bent * far.norm();
}

/// The first of them that bend, half as large as they may be and wholly: a fit that begins at their size now need not
/// come there.
std::vector<sim::EffectChange> far_sizes(const Engine& engine, const std::vector<sim::EffectChange>& likely,
                                         const sim::Recording& days) {
  std::vector<sim::EffectChange> sizes;
  int found = 0;
  for (const sim::EffectChange& c : likely) {
    const sim::Effect& e = *c.at.effect;
    const double bound = c.magnitude < e.null_value ? e.low : e.high;
    if (!std::isfinite(bound) || !bends(engine, c, bound, days)) continue;
    if (++found > most_bent) break;
    for (const double share : {0.5, 1.0}) {
      const double magnitude = e.null_value + share * (bound - e.null_value);
      if (!was_run((c.magnitude - e.null_value) / (magnitude - e.null_value))) sizes.push_back({c.at, magnitude});
    }
  }
  return sizes;
}

void draw_once(const Engine& engine, const Window& window, Responses& responses, int buildings, int jobs) {
  if (buildings > 0 && responses.buildings.empty())
    responses.buildings = drawn_buildings(engine, {}, responses.base, window.recording, buildings, jobs);
}

}  // namespace

Verdict analyse_dear(SurrogateEngine& surrogate, const Engine& engine, const CaseData& data, WindowResponses& responses,
                     const Rules& rules, int jobs, const std::function<void(const Outlook&)>& look,
                     const std::function<void(const Analysed&)>& judged) {
  if (data.has_reference()) draw_once(engine, data.reference, responses.reference, rules.buildings, jobs);
  draw_once(engine, data.test, responses.test, rules.buildings, jobs);
  const sim::Recording& measured = data.test.recording;
  const std::vector<Candidate> of_room = responses.test.candidates;
  for (int round = 1;; ++round) {
    anchor_at_fit(surrogate, engine, data, responses, jobs);
    if (round == dear_rounds) return analyse(engine, data, responses, rules, jobs, look, judged);
    const Verdict v = analyse(engine, data, responses, rules, jobs);
    std::vector<sim::EffectChange> changes = likely(surrogate, v);
    if (round > 1) {
      std::erase_if(changes, [&](const sim::EffectChange& c) { return was_run(surrogate.learned(c, measured)); });
    }
    if (round == 1) {
      for (const sim::EffectChange& c : far_sizes(engine, changes, measured)) changes.push_back(c);
    }
    surrogate.learn(changes, measured, jobs);
    for (std::size_t i = 0; i < of_room.size(); ++i) {
      const Candidate& c = of_room[i];
      const sim::ChannelTable added = surrogate.added_response({c.at, c.probe}, measured);
      if (added.size() > 0) responses.test.candidates[i].response = c.response + binned(added, surrogate.channels());
    }
  }
}

}  // namespace airside::tools::gap
