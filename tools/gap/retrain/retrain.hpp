#pragma once
// What a named effect is worth to the controller: weights of the twin as it was and of the patched twin, both put on
// one simulated room. A controller can only be tried on a plant: no log says what other setpoints would have done.

#include <cstdint>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/gap/model/engine.hpp"
#include "tools/study/control_methods.hpp"

namespace airside::tools::gap {

/// A room as it is typed, and what is true of it besides.
struct RetrainRoom {
  std::string room;                  ///< "301", "room.json", "twin.epJSON"
  std::vector<std::string> patches;  ///< EnergyPlus: merge patches, in order
  Changes changes;                   ///< the effects must outlive the room
  bool changes_in_model = false;     ///< EnergyPlus: the patches hold them, only the loops beside the engine do not
};

/// "301+patch.json+patch.json".
RetrainRoom parse_retrain_room(const std::string& text);
std::string text_of(const RetrainRoom& room);

struct RetrainPlan {
  Site site = built_in_site();
  std::string plant = "rc";  ///< rc or energyplus
  RetrainRoom twin, patched, measured;
  std::string weather;  ///< EPW of a whole year; empty: the plant's own, the same year for both twins
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

struct Retraining {
  RetrainPlan plan;
  std::vector<RetrainRun> runs;
  bool stand_in = false;             ///< the patched twin plays the measured room: nobody gave another
  std::vector<std::string> remarks;  ///< what a reader must know beside the figures

  int seeds_lower(double Metrics::*figure) const;
};

/// A figure of the table.
struct RetrainFigure {
  const char *key, *title;  ///< "dae_degc", "DAE"
  double Metrics::*figure;
};
/// DAE, ME, DARV, DAE of the first day.
const std::vector<RetrainFigure>& retrain_figures();

/// Before, after, and after - before seed by seed.
struct RetrainSpread {
  Spread before, after, change;
};
RetrainSpread spread_of(const Retraining& retraining, double Metrics::*figure);
/// DAE of a day, 0-based.
RetrainSpread daily_dae(const Retraining& retraining, std::size_t day);

/// "vav_flow@2=0.5" as a change of the library.
/// Errors: hal::InputError for another shape, an unknown effect or place, a magnitude out of bounds, and an effect that
/// neither model nor loops of `plant` can hold.
sim::EffectChange parse_change(const std::string& text, const std::vector<sim::Effect>& effects,
                               const sim::Channels& channels, const std::string& plant);

/// Makes the room and throws it away.
/// Errors: hal::InputError for a room that does not exist or has not the site's shape.
void check_retrain_room(const RetrainPlan& plan, const RetrainRoom& room);
/// All three.
void check_retrain_rooms(const RetrainPlan& plan);

/// Pretrains on both twins and runs both sets of weights on the measured room, without fine-tuning on its log: what
/// the twin says is all that the controller knows when it starts. Both twins have the same weather, people and seeds.
/// Errors: std::runtime_error of a child; check_retrain_rooms() says before what is wrong with a room.
/// Cost: 2 * seeds pretrainings and runs, `jobs` at a time in child processes.
Retraining retrain(const RetrainPlan& plan, const std::function<void()>& done);

/// Steps of which done() tells.
std::size_t retrain_steps(const RetrainPlan& plan);

/// Units are in the names.  Format: docs/formats.md.
nlohmann::json json_of(const Retraining& retraining);
/// The table for a terminal.
std::string text_of(const Retraining& retraining);
/// "DAE of the first 7 days 0.060 -> 0.041 K, lower with 5 of 5 seeds".
std::string sentence_of(const Retraining& retraining);

}  // namespace airside::tools::gap
