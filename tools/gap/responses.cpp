#include "tools/gap/responses.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

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

Library library_of(const Engine& engine, const std::vector<sim::Effect>& effects) {
  Library library;
  for (const sim::Effect& effect : effects) {
    if (!engine.can(effect)) continue;
    for (const sim::EffectAt& at : sim::places_of(effect, engine.channels(), engine.has_facade())) {
      if (effect.prior_sd > 0) library.parameters.push_back(at);
      if (effect.candidate) library.candidates.push_back(at);
    }
  }
  return library;
}

std::size_t runs_of(const Library& library, bool with_candidates) {
  return 1 + library.parameters.size() + (with_candidates ? 2 * library.candidates.size() : 0);
}

Responses simulate_responses(const Engine& engine, const Library& library, const sim::Recording& recording,
                             bool with_candidates, int jobs, const std::function<void()>& done) {
  std::vector<Task> tasks{{{}, &recording}};
  const auto add = [&](const sim::EffectAt& at, double magnitude) {
    tasks.push_back({{{at, magnitude}}, &recording});
    return tasks.size() - 1;
  };
  constexpr std::size_t later = 0;
  const bool spares = with_candidates && engine.spares_runs();
  std::vector<std::size_t> task_of;
  for (const sim::EffectAt& at : library.parameters) {
    const bool waits = spares && enclosing_candidate(library, at);
    task_of.push_back(waits ? later : add(at, at.effect->null_value + at.effect->prior_sd));
  }
  if (with_candidates) {
    for (const sim::EffectAt& at : library.candidates) {
      for (const double probe : at.effect->probe) add(at, probe);
    }
  }
  const std::size_t first_candidate = tasks.size() - (with_candidates ? 2 * library.candidates.size() : 0);
  std::vector<sim::ChannelTable> tables = simulate_all(engine, tasks, jobs, done);

  Responses out;
  out.base = binned(tables[0]);
  const auto response = [&](std::size_t task) -> Eigen::MatrixXd { return binned(tables[task]) - out.base; };
  if (with_candidates) {
    std::size_t task = first_candidate;
    for (const sim::EffectAt& at : library.candidates) {
      for (const double probe : at.effect->probe) out.candidates.push_back({at, probe, response(task++)});
    }
  }
  std::vector<std::size_t> bent;
  std::vector<Task> again;
  for (std::size_t i = 0; i < library.parameters.size(); ++i) {
    const sim::EffectAt& at = library.parameters[i];
    Parameter parameter{at, at.effect->prior_sd, {}};
    if (task_of[i] != later) {
      parameter.response = response(task_of[i]);
    } else {
      const std::size_t probe = 2 * *enclosing_candidate(library, at);
      parameter.response = interpolated(*at.effect, out.candidates[probe].response, out.candidates[probe + 1].response,
                                        engine.channels());
      if (parameter.response.size() > 0) {
        if (done) done();
      } else {
        bent.push_back(i);
        again.push_back({{{at, at.effect->null_value + at.effect->prior_sd}}, &recording});
      }
    }
    out.parameters.push_back(std::move(parameter));
  }
  tables = simulate_all(engine, again, jobs, done);
  for (std::size_t k = 0; k < bent.size(); ++k) out.parameters[bent[k]].response = response(k);
  return out;
}

}  // namespace airside::tools::gap
