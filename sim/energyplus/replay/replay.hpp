#pragma once
// A recording lived through again by the EnergyPlus twin: the recorded commands and the measured weather go in as
// files, so that the plain `energyplus` program repeats the run without airside.

#include <atomic>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>

#include "sim/energyplus/options.hpp"
#include "sim/weather/recording.hpp"

namespace airside::sim {

/// A twin to replay on: the composed model, whose dates do not matter, and the room loops that live outside the
/// engine.  Of the loops a replay uses dampers, lag, bias, people (without noise) and, if asked, thermostats.
///
/// With `own` the model's thermostats, terminals, people and plant run by themselves: the recorded supply setpoint,
/// where a schedule for it is named, and the commands of further named schedules are all that is played, and of the
/// loops lag and bias alone count. `names` then has its zones and its meters, too.
struct EnergyPlusTwin {
  nlohmann::json model;
  RoomLoopOptions loops;
  ModelNames names;
  std::optional<OwnNames> own = std::nullopt;
  int step_s = 180;  ///< of the simulation; a divisor of 6 min
};

/// The twin of a run's options: model with patches, checked against the engine's schema.
/// Errors: as compose_model().
EnergyPlusTwin twin_of(const EnergyPlusOptions& options);

class ReplayMemory;

struct ReplayOptions {
  bool thermostats = false;          ///< fan coils follow their thermostats, not the record
  std::filesystem::path cache = {};  ///< folder of finished tables; empty: none
  std::filesystem::path keep = {};   ///< folder in which the run's files stay; empty: none, else no cache is read
  std::atomic<int>* engine_runs = nullptr;  ///< counts the engine's starts
  ReplayMemory* memory = nullptr;           ///< tables of this process, asked before the cache; with `keep` neither is
};

/// The twin's channels over the recorded rows.  A row at t shows the state at t: temperatures at the end of the
/// 3-min step that ends there, powers of that step, and the share of the 6 min from t in which a fan coil is on.
///
/// Shape: rows of the recording x channels_of(twin).count().  Units: degC, kW, 0..1.
/// The run begins two days before the recording's midnight; before it the first day is repeated, there and in warm-up:
/// the state at the first row then differs by 0.0001 K from that after 25 days of warm-up, and with twice the mass by
/// 0.008 K at most.
/// Errors: hal::InputError for an absent engine, a recording that does not fit the twin, a model that lacks a name;
/// std::runtime_error with the engine's own words when it gives up.
/// Cost: one child process; 0.25 s and 0.045 s a day, of five days more than the recording has; from the cache 10 ms.
/// Several threads may replay at once.
ChannelTable replay_energyplus(const EnergyPlusTwin& twin, const Recording& recording,
                               const ReplayOptions& options = {});

/// The columns of the twin's table: interior zones, perimeter zones, fans and plant; of a model with controls of its
/// own what [twin.names] has, with dampers where a terminal shows one.
Channels channels_of(const EnergyPlusTwin& twin);

}  // namespace airside::sim
