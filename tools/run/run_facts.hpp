#pragma once
// What a figure was made by: plant, engine, weather and the commit of the program. Every output names them, since two
// machines that differ in one of them give two tables.

#include <nlohmann/json.hpp>
#include <string>

#include "tools/run/plant_choice.hpp"

namespace airside::tools {

/// "airside 0.1.0, commit 5e7cc18".
std::string program_text();

struct RunFacts {
  std::string plant;     ///< "rc", "energyplus" or "learned"
  std::string engine;    ///< "EnergyPlus 25.2.0", "RC plant of airside 0.1.0"
  std::string weather;   ///< as weather_text(); empty: unknown
  std::string fallback;  ///< why `auto` did not mean EnergyPlus; empty where it did, or where the user chose
};

/// `energyplus`: which plant; for commands whose plant is no PlantChoice.
RunFacts run_facts(bool energyplus, std::string weather);
RunFacts run_facts(const PlantChoice& choice, const Site& site);

/// "EnergyPlus 25.2.0, weather Tampa.epw (CRC-32C 0123abcd), airside 0.1.0, commit 5e7cc18".
std::string text_of(const RunFacts& facts);
/// Adds plant_kind, engine, weather, version and commit, and fallback where there is one, to a command's --json.
void add_to(nlohmann::json& j, const RunFacts& facts);
/// Adds version and commit alone, where no plant took part.
void add_program_to(nlohmann::json& j);

/// Says on standard error that another plant than EnergyPlus runs, where the user did not choose it.
void say_fallback(const RunFacts& facts);

}  // namespace airside::tools
