#include "tools/gap/responses.hpp"

namespace airside::tools::gap {

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
  for (const sim::EffectAt& at : library.parameters) {
    tasks.push_back({{{at, at.effect->null_value + at.effect->prior_sd}}, &recording});
  }
  if (with_candidates) {
    for (const sim::EffectAt& at : library.candidates) {
      for (const double probe : at.effect->probe) tasks.push_back({{{at, probe}}, &recording});
    }
  }
  const auto tables = simulate_all(engine, tasks, jobs, done);
  Responses out;
  out.base = binned(tables[0]);
  std::size_t next = 1;
  for (const sim::EffectAt& at : library.parameters) {
    out.parameters.push_back({at, at.effect->prior_sd, binned(tables[next++]) - out.base});
  }
  if (!with_candidates) return out;
  for (const sim::EffectAt& at : library.candidates) {
    for (const double probe : at.effect->probe)
      out.candidates.push_back({at, probe, binned(tables[next++]) - out.base});
  }
  return out;
}

}  // namespace airside::tools::gap
