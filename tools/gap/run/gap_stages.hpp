#pragma once
// What the whole workflow costs, stage by stage, as far as that is known at each moment.

#include <vector>

#include "tools/gap/model/responses.hpp"
#include "tools/gap/verdict/outlook.hpp"
#include "tools/gap/verdict/verdict.hpp"
#include "tools/run/progress/stage_clock.hpp"

namespace airside::tools::gap {

/// Numbers of the stages.
struct GapStage {
  static constexpr std::size_t responding = 0, fitting = 1, searching = 2, explaining = 3;
};

/// Steps are simulations; weights are by what runs in parallel, how long the simulated periods are, and for an RC room,
/// whose simulations are short, by the linear algebra between them. Counts: see simulate_responses(), fit_reference(),
/// Refitter, propose_experiments(), reconstruct_heat(), each with typical numbers of iterations.
class GapStages {
 public:
  /// `days`: of the measured window; `buildings`: as Rules::buildings; `dear`: an RC room answers in the model's stead.
  GapStages(const Engine& engine, const Library& library, int days, int jobs, int buildings = 0, bool dear = false);

  /// Before anything is known: something will be found or not.
  std::vector<Stage> stages() const;
  /// The search, as far as it can be seen.
  Stage search(const Outlook& outlook) const;
  /// What follows the verdict, and before there is one, what it probably asks for.
  Stage explanation(const Outlook& outlook) const;
  Stage explanation(VerdictKind verdict, bool has_rivals) const;

 private:
  /// `share`: of it, where it is not known whether there is an effect at all.
  Stage search_of(int effects, double share = 1) const;
  /// That tell an effect from its rivals.
  Stage tests(double share) const;
  /// `replays`: of the whole window in parallel, and linear algebra as long as `algebra` replays of an RC room.
  Stage explanation_of(double steps, double replays, double algebra) const;

  double responses_ = 0, parameters_ = 0;
  int zones_ = 0, jobs_ = 1;
  double buildings_ = 0;  ///< simulations of drawn buildings
  double days_ = 1;
  bool spares_ = false, dear_ = false;
};

/// A run of a model in whose stead an RC room answers takes as long as this many replays of that room.
constexpr double replays_of_dear_run = 60;

}  // namespace airside::tools::gap
