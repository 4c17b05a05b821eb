#pragma once
// What a named effect is worth to the controller: weights of the twin as it was and of the patched twin, both put on
// the room in which the effect is real.

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "tools/methods.hpp"

namespace airside::tools::gap {

/// A room as it is typed: "301", "room.json", or "301+patch.json+patch.json" with merge patches (EnergyPlus).
struct RoomText {
  std::string room;
  std::vector<std::string> patches;
};
RoomText parse_room_text(const std::string& text);

struct RetrainPlan {
  std::string plant = "rc";  ///< rc or energyplus
  std::string twin, patched, measured;
  std::string preset = "product";
  int seeds = 5, first_seed = 1;
  int pretrain_days = 31, days = 7;
  int expert_days = 1;  ///< under the schedule before, which a flashed box has too
  int jobs = 2;
};

/// One controller on the measured room.
struct RetrainRun {
  std::uint64_t seed = 0;
  Metrics before, after;  ///< with weights of the twin, of the patched twin
};

/// Pretrains on both twins and runs both sets of weights on the measured room, without fine-tuning on its log: what
/// the twin says is all that the controller knows when it starts.
/// Errors: hal::InputError for rooms that do not exist, before anything is computed.
/// Cost: 2 * seeds pretrainings and runs, `jobs` at a time in child processes.
std::vector<RetrainRun> retrain(const RetrainPlan& plan, const std::function<void()>& done);

/// Steps of which done() tells.
std::size_t retrain_steps(const RetrainPlan& plan);

}  // namespace airside::tools::gap
