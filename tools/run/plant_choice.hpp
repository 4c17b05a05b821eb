#pragma once
// Which simulated room a command works on, as command-line options that all commands share.

#include <CLI/CLI.hpp>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "airside/civil_time.hpp"
#include "sim/effects/effect.hpp"
#include "sim/plant_model.hpp"
#include "sim/weather/weather.hpp"
#include "tools/run/site.hpp"

namespace airside::tools {

struct PlantChoice {
  std::string kind = "auto";  ///< rc, energyplus, or auto: EnergyPlus where it is installed
  std::string room = "301";   ///< a built-in room, or a file (.json for rc)
  std::string model;          ///< epJSON file instead of the built-in twin; no patch of a built-in room goes onto it
  std::vector<std::string> patches;
  std::string environment;  ///< a file of tools/learn_environment instead of a room with physics; empty: none
  std::string weather;      ///< EPW file; empty: Tampa for EnergyPlus, synthetic for rc
  std::string start = "2021-07-01";
  std::uint64_t seed = 1;                ///< of people, outages and sensor noise
  bool weekends = false;                 ///< Saturday and Sunday nearly empty
  std::string scenario;                  ///< of sim/scenarios; empty: none
  std::string site_twin;                 ///< the site file whose [twin] gave model and patches; empty: options did
  std::optional<hal::TwinSection> twin;  ///< that [twin]: who controls the rooms, by which names

  // No options: for comparisons of rooms that differ in an effect and in nothing else.
  std::string weather_of;                  ///< rc without `weather`: the room whose made-up year it is; empty: its own
  std::vector<sim::EffectChange> changes;  ///< to the room; the effects must outlive the choice
  double fan_start_h = 0, fan_stop_h = 0;  ///< rc: the AHU rests outside these hours; equal: as the room has it
  bool changes_in_model = false;  ///< EnergyPlus: model and patches have them already, the loops beside lack them
};

/// Adds --plant, --room, --twin, --patch, --weather, --start, --seed, --weekends, --scenario to a command.
void add_plant_options(CLI::App& command, PlantChoice& choice, const std::string& default_start = "2021-07-01");

/// When a command means the site's [twin]: those that train do unless an option says otherwise; where the plant stands
/// for the built room, only --twin without a file does.
enum class TwinUse : std::uint8_t { unless_named, when_asked };

/// Takes model, names, patches and weather of the site's [twin] where no option of `command` names others: --twin FILE
/// or --room stands for another model, --patch for other patches, --weather for other weather.
/// Errors: hal::InputError for patches on "rc", for --twin without a file where there is no [twin], and for options
/// that a model with controls of its own does not heed.
void take_site_twin(const CLI::App& command, PlantChoice& choice, const Site& site, TwinUse use);

/// Puts the first day of the scenario, or of the learned environment's log, in the place of a start that `command` was
/// not given; one that was given in place of a scenario's is noted on standard error.
/// Errors: hal::InputError for a name that is none, and for a file that is no environment.
void take_scenario_start(const CLI::App& command, PlantChoice& choice);

/// Midnight of the start day.  Errors: hal::InputError for text that is no date.
CivilTime start_of(const PlantChoice& choice);

/// Whether the choice means EnergyPlus on this machine and for this shape of room ("auto" is rc for other shapes
/// than that of the model).
bool is_energyplus(const PlantChoice& choice, const Site& site);

/// Refuses a room that make_plant() would not know, and a model that the plant cannot use, without making anything.
/// Errors: hal::InputError.
void check_room(const PlantChoice& choice, const Site& site);

/// A weather file by name and checksum, since files of one name need not be one file; "" where it is missing.
std::string weather_file_text(const std::filesystem::path& file);
/// The weather by file and checksum, or the made-up year; "" where the engine or the file is missing.
std::string weather_text(const PlantChoice& choice, const Site& site);

/// The made-up year that rc has where no file is given.
std::shared_ptr<const sim::Weather> made_up_weather(const PlantChoice& choice);

/// Makes the room; `days` is how long it will be needed.
/// Errors: hal::InputError for unknown rooms, bad files, an absent engine, a model or patches that rc would drop.
std::unique_ptr<sim::PlantModel> make_plant(const PlantChoice& choice, const Site& site, int days);

/// The options as they must be typed again, for reports.
std::string command_text(const PlantChoice& choice, const Site& site);

}  // namespace airside::tools
