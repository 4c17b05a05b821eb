#pragma once
// Weights from a simulated room, before anything is installed.

#include <cstdint>
#include <string>

#include "tools/run/control_run.hpp"

namespace airside::tools {

/// Who acts in the twin while weights are pretrained (docs/method.md 7.2, 7.3, open point 27).
enum class Pretrainer {
  agent,            ///< dynamic: it controls and learns
  drawn_schedules,  ///< static: each day's working setpoint is drawn from {19.5, 20.0 .. 21.5}
  expert_schedule,  ///< static: the expert's, every day
};

struct PretrainOptions {
  std::uint64_t seed = 1;
  int updates_per_cycle = 0;  ///< 0: the preset's; pretraining can afford more than the box
  Pretrainer pretrainer = Pretrainer::agent;
  bool with_residual = true;  ///< the blob carries built_in_residual(), where a room head controls in cycles of 18 min
  std::string provenance;     ///< twin, patches, weather, dates; stored in the blob
};

struct Pretraining {
  BlobBytes blob;
  ControlRun run;
  std::uint64_t transitions = 0;  ///< remembered: any row of day 1 may start one, then every cycle
};

/// Dynamic pretraining (docs/method.md 7.2): day 1 under the schedule fits the scaler, then the agent controls the twin
/// and learns until `until`.  Static (7.3): all days under schedules that are fixed beforehand, then training; where no
/// reading is refused, with as many transitions and optimiser steps as the agent has of the same days.
Pretraining pretrain(const Site& site, sim::PlantModel& plant, CivilTime until, const PretrainOptions& options,
                     const OnProgress& progress = {});

}  // namespace airside::tools
