#include "tools/gap/run/gap_stages.hpp"

#include <algorithm>

#include "tools/gap/explain/flux.hpp"

namespace airside::tools::gap {

namespace {

constexpr double serial_fit = 18;     // six of the reference, two tangents, iterations of the model without effects
constexpr double serial_search = 50;  // of one effect: trials, its refit, its rivals
constexpr double search_of_nothing = 8;
// Tests on site: runs of plans and of the finalists' parameters, and the days of each.
constexpr double test_runs = 100, test_days = 5;
constexpr double heat_part = 0.6;  // of the window, that a pulse of heat is lived through
// Linear algebra, which runs alone, in replays of an RC room.
constexpr double fit_algebra = 60, test_algebra = 80, heat_algebra = 150;

/// Of steps one after another and others side by side.
double weight_of(double serial, double parallel, int jobs) {
  return (serial + parallel / jobs) / std::max(1.0, serial + parallel);
}

}  // namespace

GapStages::GapStages(const Engine& engine, const Library& library, int days, int jobs)
    : responses_(2.0 * static_cast<double>(simulated_runs(engine, library))),
      parameters_(engine.spares_runs() ? 0.0 : static_cast<double>(library.parameters.size())),
      zones_(engine.channels().mau_temp()),
      jobs_(std::max(1, jobs)),
      days_(std::max(1, days)),
      spares_(engine.spares_runs()) {}

std::vector<Stage> GapStages::stages() const {
  const double fit_parallel = 3 * parameters_, fit_steps = serial_fit + fit_parallel;
  const double fit_cost = serial_fit + fit_parallel / jobs_ + (spares_ ? 0 : fit_algebra);
  return {{"simulating every effect", responses_, 1.0 / jobs_},
          {"fitting", fit_steps, fit_cost / fit_steps},
          search_of(0.8),
          explanation_of(0.4 * test_runs, 0.4 * test_runs * test_days / days_, 0.4 * test_algebra)};
}

Stage GapStages::search_of(double effects) const {
  return {"searching", effects * (serial_search + parameters_), weight_of(serial_search, parameters_, jobs_)};
}

Stage GapStages::search(double over_limit) const {
  return over_limit > 1 ? search_of(1.3) : Stage{"searching", search_of_nothing, 1.0};
}

Stage GapStages::explanation_of(double steps, double replays, double algebra) const {
  const double cost = replays / jobs_ + (spares_ ? 0 : algebra);
  return {"explaining", 2 + steps, (2 + cost) / (2 + steps), false};
}

Stage GapStages::explanation(double over_limit) const {
  const double part = over_limit > 1 ? 0.5 : 0;
  return explanation_of(part * test_runs, part * test_runs * test_days / days_, part * test_algebra);
}

Stage GapStages::explanation(VerdictKind verdict) const {
  const HeatRules rules;
  const double pulses = zones_ * static_cast<double>(rules.pulse_hours.size());
  switch (verdict) {
    case VerdictKind::ambiguous: return explanation_of(test_runs, test_runs * test_days / days_, test_algebra);
    case VerdictKind::unknown:
      return explanation_of(pulses + rules.refinements, heat_part * pulses + rules.refinements * jobs_, heat_algebra);
    case VerdictKind::named:
    case VerdictKind::none: break;
  }
  return explanation_of(0, 0, 0);
}

}  // namespace airside::tools::gap
