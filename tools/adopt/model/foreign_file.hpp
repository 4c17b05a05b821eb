#pragma once
// A model file of somebody else, IDF or epJSON, as epJSON of the installed engine's version.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sim/energyplus/install.hpp"

namespace airside::tools {

struct ForeignModel {
  nlohmann::json content;
  std::vector<std::string> notes;  ///< how it was converted
};

/// Reads a model; an IDF goes through the engine's own converter, one with HVACTemplate objects through its
/// ExpandObjects first. Files that the model names are looked for beside it, and named by their whole path.
/// Errors: hal::InputError for a file that is absent, empty, neither IDF nor epJSON, of another version of the engine
///   (with what upgrades it), or that the converter refuses, in its own words; for a file that the model names and
///   that is not there.
/// Cost: an IDF 0.3 s.
ForeignModel read_foreign_model(const std::filesystem::path& file, const sim::EnergyPlusInstall& install);

}  // namespace airside::tools
