#pragma once
// Measured data from EnergyPlus: a room whose numbers differ from the twin's by 10 to 20 % and in which other objects
// do what the twin's do, run by the plant with its own loops. What the library hides by one object is hidden by
// another wherever the engine has one.

#include <filesystem>
#include <nlohmann/json.hpp>

#include "sim/energyplus/options.hpp"
#include "tools/gap/blind/blind.hpp"

namespace airside::tools::gap {

/// A built room. `nominal`: the twin's objects with the built room's numbers; `hidden`: the same with what is hidden
/// in it, still in the twin's objects. built_model() makes other objects of them.
struct EnergyPlusRoom {
  sim::EnergyPlusOptions options;  ///< loops, weather, seed
  nlohmann::json twin, nominal, hidden;
  std::uint64_t seed = 1;       ///< of the perturbation and the other objects
  double modulation_per_k = 0;  ///< opening added a K above 25.25; 0: fixed dampers
  std::vector<sim::EffectChange> sensors;
  double clock_ahead_h = 0, outdoor_shown_k = 0;
};

/// The room that stands for the real one.  `twin`: a name of energyplus_room_names().
/// Errors: as energyplus_room() and compose_model().  Cost: 0.5 s.
EnergyPlusRoom energyplus_measured_room(const std::string& twin, std::uint64_t seed, bool feedback);

/// Whether the effect can be hidden by hide(): not what the EnergyPlus model cannot express.
bool energyplus_can_hide(const sim::Effect& effect);

/// The room with something hidden in it; doors open by `seed`. Effects must outlive the room.
/// Errors: std::invalid_argument for what nobody can hide; hal::InputError as sim::model_patch.
EnergyPlusRoom hide(EnergyPlusRoom room, const std::vector<Hidden>& hidden, const std::vector<sim::Effect>& effects,
                    std::uint64_t seed);

/// What is hidden and the room itself by sim::other_objects().
nlohmann::json built_model(const EnergyPlusRoom& room, sim::RoomLoopOptions& loops);

/// What no thermostat commands, by the log's clock and the run's command seed alone, so that cases of one window are
/// commanded alike: every box off for 36 to 90 min of one day in ten, and without feedback fan coils that run in 54 %
/// of the hours from 7 to 20.
class WindowCommands {
 public:
  explicit WindowCommands(const MeasuredRun& run) : seed_(run.commands()) {}
  bool box_on(int vav, CivilTime t) const;
  bool fan_coil_on(int fcu, CivilTime t) const;

 private:
  std::uint64_t seed_;
};

/// What that room logs.  `weather`: EPW.
/// Errors: as EnergyPlusPlant.  Cost: one child process, about 2 s and 0.15 s a day.
std::vector<hal::LogRow> measure(const EnergyPlusRoom& room, const std::filesystem::path& weather,
                                 const MeasuredRun& run);

}  // namespace airside::tools::gap
