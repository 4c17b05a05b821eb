#pragma once
// A case for the gap workflow as a folder of files: case.json names the model, the weather, and the two logs.
// Format: docs/formats.md, "Cases of the gap workflow".

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sim/energyplus/options.hpp"

namespace airside::tools::gap {

/// Where a case's model and logs come from; paths are resolved.
struct CaseDescription {
  std::string engine = "rc";  ///< rc or energyplus
  std::string model;          ///< rc: room name or file; energyplus: room name or epJSON file
  std::vector<std::string> patches;
  std::string weather;  ///< EPW
  std::string reference_log, measured_log;
  int reference_days = 0;  ///< > 0, without a reference log: the first N days of the measured log are the reference
  std::string topology = "5vav-5fcu-2power";
  /// Site file by whose [twin.names] the model, which controls its rooms itself, is read; empty: the project's own
  /// names.
  std::string site;
  /// Mapping file by which the model and logs of other columns are read; empty: the project's own columns.
  std::string map;
  std::string window;  ///< a name for the stretch of weather; nothing depends on it
  bool duties = true;
  bool has_reference() const { return !reference_log.empty() || reference_days > 0; }
};

/// Errors: hal::InputError with file and key.
CaseDescription read_case(const std::filesystem::path& folder);
/// Writes case.json; paths are written as they stand.
void write_case(const std::filesystem::path& folder, const CaseDescription& description);

/// The model as the user has it, before any effect: the epJSON with its patches, or the room file.
/// Errors: hal::InputError of unreadable files and unknown names.
nlohmann::json model_of(const CaseDescription& description);
/// The names of a model's zones and schedules, and the loops beside it; EnergyPlus only.
sim::EnergyPlusOptions energyplus_options_of(const CaseDescription& description);

/// Folders below `folder` that hold a case.json, in order of name.
/// Errors: hal::InputError if there is none.
std::vector<std::filesystem::path> case_folders(const std::filesystem::path& folder);

}  // namespace airside::tools::gap
