#pragma once
// A model file of somebody else, IDF or epJSON, as epJSON of the installed engine's version.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sim/energyplus/install.hpp"
#include "tools/adopt/upgrade/upgrade.hpp"

namespace airside::tools {

struct ForeignModel {
  nlohmann::json content;
  std::vector<std::string> notes;  ///< how it was converted
  Upgrade upgrade;                 ///< where it was of an older version
};

/// Reads a model. One of an older version is brought to the engine's first: an IDF by the Transition programs of the
/// folder `transitions`, where one is given, AIRSIDE_TRANSITIONS names one or the engine has one, else by the tables
/// here; an epJSON always by the tables. An IDF goes through the engine's own converter, one with HVACTemplate objects
/// through its ExpandObjects first. Files that the model names are looked for beside it, and named by their whole path.
/// Errors: hal::InputError for a file that is absent, empty, neither IDF nor epJSON, of a newer version than the
///   engine or one too old to upgrade, or that the converter refuses, in its own words; as of upgraded_idf(); for a
///   file that the model names and that is not there.
/// Cost: an IDF 0.3 s.
ForeignModel read_foreign_model(const std::filesystem::path& file, const sim::EnergyPlusInstall& install,
                                const std::string& transitions = {});

}  // namespace airside::tools
