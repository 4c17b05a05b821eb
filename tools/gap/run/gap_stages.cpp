#include "tools/gap/run/gap_stages.hpp"

#include <algorithm>

#include "tools/gap/explain/flux.hpp"
#include "tools/gap/surrogate/analyse_dear.hpp"

namespace airside::tools::gap {

namespace {

constexpr double serial_fit = 18;  // six of the reference, two tangents, iterations of the model without effects
// Of n effects: trials, refits and rivals of each beside the others; a tangent of each model, and of each without one
// of its effects.
constexpr double serial_search = 12.5, search_algebra = 32;
constexpr double search_of_nothing = 8;
// Tests on site: runs of plans and of the finalists' parameters, and the days of each.
constexpr double test_runs = 100, test_days = 5;
constexpr double heat_part = 0.6;  // of the window, that a pulse of heat is lived through
// Linear algebra, which runs alone, in replays of an RC room.
constexpr double fit_algebra = 30, test_algebra = 25, heat_algebra = 150;
// Before anything is known: shares of a search for one effect, and of the test that tells it from another.
constexpr double search_share = 0.7, test_share = 0.3;

}  // namespace

GapStages::GapStages(const Engine& engine, const Library& library, int days, int jobs, int buildings, bool dear)
    : responses_(2.0 * static_cast<double>(simulated_runs(engine, library)) + (dear ? 2 * replays_of_dear_run : 0)),
      parameters_(engine.spares_runs() ? 0.0 : static_cast<double>(library.parameters.size())),
      zones_(engine.channels().mau_temp()),
      jobs_(std::max(1, jobs)),
      buildings_(engine.draws_buildings() ? 2.0 * buildings : 0.0),
      days_(std::max(1, days)),
      spares_(engine.spares_runs()),
      dear_(dear) {}

std::vector<Stage> GapStages::stages() const {
  const double once = 3 * parameters_, search = dear_ ? serial_search * 2 + parameters_ : 0;
  const double rounds = dear_ ? dear_rounds : 1;  // all but the last with a search and what the model is run for
  const double runs =
      dear_ ? replays_of_dear_run * (rounds * (dear_fits + 1) + (rounds - 1) * dear_effects + dear_sizes) : 0;
  const double fit_parallel = rounds * once + buildings_ + (rounds - 1) * search + runs;
  const double fit_steps = rounds * serial_fit + fit_parallel;
  const double fit_cost =
      rounds * (serial_fit + (spares_ ? 0 : fit_algebra)) + (rounds - 1) * search_algebra + fit_parallel / jobs_;
  return {{"simulating every effect", responses_, 1.0 / jobs_},
          {"fitting", fit_steps, fit_cost / fit_steps},
          search_of(1, search_share),
          tests(test_share)};
}

Stage GapStages::search_of(int effects, double share) const {
  const double serial = serial_search * effects * (effects + 1), parallel = (2 * effects - 1) * parameters_;
  const double cost = serial + parallel / jobs_ + (spares_ ? 0 : search_algebra * effects);
  return {"searching", share * (serial + parallel), cost / (serial + parallel)};
}

Stage GapStages::tests(double share) const {
  return explanation_of(share * test_runs, share * test_runs * test_days / days_, share * test_algebra);
}

Stage GapStages::search(const Outlook& outlook) const {
  const int effects = outlook.found + outlook.more;
  return effects > 0 ? search_of(effects) : Stage{"searching", search_of_nothing, 1.0};
}

Stage GapStages::explanation_of(double steps, double replays, double algebra) const {
  const double cost = replays / jobs_ + (spares_ ? 0 : algebra);
  const double curves = dear_ ? 2 * replays_of_dear_run : 2;
  return {"explaining", curves + steps, (curves + cost) / (curves + steps), false};
}

Stage GapStages::explanation(const Outlook& outlook) const {
  if (outlook.unknown) return explanation(VerdictKind::unknown, false);
  return tests(outlook.found + outlook.more != 1 ? 0 : outlook.alike ? 0.5 : 0.25);
}

Stage GapStages::explanation(VerdictKind verdict, bool has_rivals) const {
  const HeatRules rules;
  const double pulses = zones_ * static_cast<double>(rules.pulse_hours.size());
  switch (verdict) {
    case VerdictKind::ambiguous: return tests(has_rivals ? 1 : 0);
    case VerdictKind::unknown:
      return explanation_of(pulses + rules.refinements, heat_part * pulses + rules.refinements * jobs_, heat_algebra);
    case VerdictKind::named:
    case VerdictKind::none: break;
  }
  return explanation_of(0, 0, 0);
}

}  // namespace airside::tools::gap
