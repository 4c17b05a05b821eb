#include "tools/gap/model/responses.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "sim/effects/effect_text.hpp"

namespace airside::tools::gap {

namespace {

/// The place of a parameter's effect among the candidates; none unless one prior standard deviation lies between null
/// and the probes.
std::optional<std::size_t> enclosing_candidate(const Library& library, const sim::EffectAt& at) {
  const sim::Effect& effect = *at.effect;
  const auto found = std::find_if(library.candidates.begin(), library.candidates.end(),
                                  [&](const sim::EffectAt& c) { return c.id() == at.id(); });
  const double a = effect.probe[0] - effect.null_value, b = effect.probe[1] - effect.null_value;
  if (found == library.candidates.end() || a == b || a == 0 || b == 0 || effect.prior_sd > std::max(a, b))
    return std::nullopt;
  return static_cast<std::size_t>(found - library.candidates.begin());
}

/// The response to one prior standard deviation by the parabola through null and both probes; empty where these are too
/// unlike each other: slopes to the two differ by 30 % in temperatures or in powers, where there is anything to see.
/// Duties say little here: single switchings of thermostats are chance.
Eigen::MatrixXd interpolated(const sim::Effect& effect, const Eigen::MatrixXd& first, const Eigen::MatrixXd& second,
                             const sim::Channels& channels) {
  constexpr double unlike = 0.3, unseen = 0.005;
  const double x = effect.prior_sd, a = effect.probe[0] - effect.null_value, b = effect.probe[1] - effect.null_value;
  const auto bent = [&](int from, int count) {
    const Eigen::MatrixXd u = first.middleCols(from, count) / a, v = second.middleCols(from, count) / b;
    const double steepest = std::max(u.norm(), v.norm());
    return x * steepest > unseen * std::sqrt(static_cast<double>(u.size())) && (u - v).norm() > unlike * steepest;
  };
  if (bent(0, channels.mau_temp()) || bent(channels.power(), channels.powers)) return {};
  return x * (x - b) / (a * (a - b)) * first + x * (x - a) / (b * (b - a)) * second;
}

}  // namespace

Window evidence_of(Window window, const sim::Channels& channels) {
  constexpr double follows_k = 0.3;
  const Eigen::Index bins = window.measured.rows(), supply = channels.supply_temp();
  std::vector<bool> above(static_cast<std::size_t>(bins));
  for (Eigen::Index b = 0; b < bins; ++b) {
    double setpoint = 0;
    for (Eigen::Index r = b * rows_per_bin; r < (b + 1) * rows_per_bin; ++r)
      setpoint += window.recording.rows[static_cast<std::size_t>(r)].setpoint_degc / rows_per_bin;
    above[static_cast<std::size_t>(b)] = window.measured(b, supply) - setpoint > follows_k;
  }
  for (std::size_t b = 0; b < above.size(); ++b) {
    const bool stays = (b > 0 && above[b - 1]) || (b + 1 < above.size() && above[b + 1]);
    if (above[b] && stays)
      window.measured(static_cast<Eigen::Index>(b), supply) = std::numeric_limits<double>::quiet_NaN();
  }
  return window;
}

namespace {

/// The title of an effect at no place in particular: "flow of box n is not what its controller believes".
std::string title_anywhere(const sim::Effect& effect) {
  std::string title = effect.title;
  sim::effect_text::replace_all(title, "the {facade}", "any");
  sim::effect_text::replace_all(title, "{n}", "n");
  return title;
}

}  // namespace

Library library_of(const Engine& engine, const std::vector<sim::Effect>& effects) {
  Library library;
  const std::array<bool, sim::facades> facades = engine.has_facade();
  for (const sim::Effect& effect : effects) {
    if (!engine.can(effect)) {
      if (!engine.plays_commands())
        library.not_applicable.push_back({effect.name, title_anywhere(effect), engine.why_not({&effect, 0})});
      continue;
    }
    const std::vector<sim::EffectAt> places = sim::places_of(effect, engine.channels(), facades);
    if (places.empty() && !engine.plays_commands())
      library.not_applicable.push_back({effect.name, title_anywhere(effect), "the model has no such place"});
    for (const sim::EffectAt& at : places) {
      if (std::string why = engine.why_not(at); !why.empty()) {
        library.not_applicable.push_back({at.id(), at.text(), std::move(why)});
        continue;
      }
      if (engine.doubts(effect)) library.parameters.push_back(at);
      if (effect.candidate) library.candidates.push_back(at);
    }
  }
  return library;
}

std::size_t runs_of(const Library& library, bool with_candidates) {
  return 1 + library.parameters.size() + (with_candidates ? 2 * library.candidates.size() : 0);
}

std::size_t simulated_runs(const Engine& engine, const Library& library) {
  const auto runs = [&](const sim::EffectAt& at) { return !engine.only_shows(*at.effect); };
  const auto parameters = std::count_if(library.parameters.begin(), library.parameters.end(), [&](const auto& at) {
    return runs(at) && !(engine.spares_runs() && enclosing_candidate(library, at));
  });
  const auto candidates = std::count_if(library.candidates.begin(), library.candidates.end(), runs);
  return static_cast<std::size_t>(1 + parameters + 2 * candidates);
}

Eigen::MatrixXd shown_response(const Engine& engine, const sim::ChannelTable& base, const sim::EffectChange& change) {
  return binned(sim::changed_sensors(base, engine.channels(), std::span(&change, 1)), engine.channels()) -
         binned(base, engine.channels());
}

Eigen::MatrixXd response_between_probes(const Library& library, const sim::EffectAt& at,
                                        const std::vector<Candidate>& candidates, const sim::Channels& channels) {
  const auto place = enclosing_candidate(library, at);
  if (!place) return {};
  return interpolated(*at.effect, candidates[2 * *place].response, candidates[2 * *place + 1].response, channels);
}

Responses simulate_responses(const Engine& engine, const Library& library, const sim::Recording& recording,
                             bool with_candidates, int jobs, const std::function<void()>& done) {
  const sim::ChannelTable base = engine.simulate({}, recording);
  if (done) done();
  Responses out;
  out.base = binned(base, engine.channels());
  // Each change is either known from the base or a task; responses are put where they belong as tasks end.
  std::vector<Task> tasks;
  std::vector<Eigen::MatrixXd*> places;
  const auto ask = [&](const sim::EffectAt& at, double magnitude, Eigen::MatrixXd& response) {
    if (engine.only_shows(*at.effect)) {
      response = shown_response(engine, base, {at, magnitude});
      if (done) done();
      return;
    }
    tasks.push_back({{{at, magnitude}}, &recording});
    places.push_back(&response);
  };
  const auto simulate = [&] {
    const std::vector<sim::ChannelTable> tables = simulate_all(engine, tasks, jobs, done);
    for (std::size_t i = 0; i < tables.size(); ++i) *places[i] = binned(tables[i], engine.channels()) - out.base;
    tasks.clear();
    places.clear();
  };

  for (const sim::EffectAt& at : library.parameters) out.parameters.push_back({at, at.effect->prior_sd, {}});
  if (with_candidates) {
    for (const sim::EffectAt& at : library.candidates) {
      for (const double probe : at.effect->probe) out.candidates.push_back({at, probe, {}});
    }
  }
  const bool spares = with_candidates && engine.spares_runs();
  const auto waits = [&](const Parameter& p) {
    return spares && !engine.only_shows(*p.at.effect) && enclosing_candidate(library, p.at);
  };
  const auto ask_parameter = [&](Parameter& p) { ask(p.at, p.at.effect->null_value + p.prior_sd, p.response); };
  for (Parameter& p : out.parameters) {
    if (!waits(p)) ask_parameter(p);
  }
  for (Candidate& c : out.candidates) ask(c.at, c.probe, c.response);
  simulate();
  for (Parameter& p : out.parameters) {
    if (!waits(p)) continue;
    p.response = response_between_probes(library, p.at, out.candidates, engine.channels());
    if (p.response.size() == 0)
      ask_parameter(p);
    else if (done)
      done();
  }
  simulate();
  return out;
}

}  // namespace airside::tools::gap
