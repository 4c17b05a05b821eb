#pragma once
// What the worker process receives in its one file, run.json: everything that does not change during a run.

#include <cstdint>
#include <filesystem>
#include <string>

#include "sim/energyplus/options.hpp"

namespace airside::sim {

/// The engine runs one day ahead of the run's start: its meters stand still in warm-up, and the first sensors
/// shall show power too.
constexpr std::int64_t lead_s = 86400;

struct RunConfig {
  std::string engine_library, engine_folder;
  std::string run_folder, model, weather;
  std::int64_t start_s = 0;
  std::int64_t end_s = 0;
  int step_s = 180;
  std::uint64_t seed = 1;
  double setpoint_degc = 25;
  RoomLoopOptions rooms;
  ModelNames names;
  bool own_control = false;  ///< then `own` counts, else `names`
  OwnNames own;
  OwnParts own_parts;
};

void write_run_config(const RunConfig& config, const std::filesystem::path& file);

/// Errors: hal::InputError, nlohmann::json::exception for a file of another build.
RunConfig read_run_config(const std::filesystem::path& file);

}  // namespace airside::sim
