#pragma once
// Where the optional EnergyPlus engine, our worker program and our models lie on this machine.
// The engine is opened at run time only: nothing here is needed to build.

#include <filesystem>
#include <string>

namespace airside::sim {

/// The files of one EnergyPlus 25.2 install that a run needs.
struct EnergyPlusInstall {
  std::filesystem::path folder;   ///< the payload folder, EnergyPlus's root
  std::filesystem::path library;  ///< libenergyplusapi.so
  std::filesystem::path schema;   ///< Energy+.schema.epJSON
};

/// Looks in $AIRSIDE_ENERGYPLUS (the folder itself), else in the Python package of $AIRSIDE_VENV, else of
/// build/venv above the program or in the source folder.
/// Errors: hal::InputError naming the places looked at and how to install.
EnergyPlusInstall find_energyplus();

/// Whether find_energyplus() would succeed.
bool have_energyplus();

/// The engine's version as its library says it, such as "25.2.0".
std::string version_of(const EnergyPlusInstall& install);

/// The install's weather file of Tampa: hot and humid, the default climate of the twin.
/// Errors: hal::InputError when the file is missing.
std::filesystem::path default_weather(const EnergyPlusInstall& install);

/// The folder with twin.epJSON and the rooms' patches: $AIRSIDE_MODELS, else ../share/airside/models beside the
/// program's folder, else the source folder.
/// Errors: hal::InputError naming the places looked at.
std::filesystem::path find_models();

/// The program that holds the engine: $AIRSIDE_ENERGYPLUS_WORKER, else airside-energyplus beside this program,
/// else where it was built.
/// Errors: hal::InputError naming the places looked at.
std::filesystem::path find_energyplus_worker();

}  // namespace airside::sim
