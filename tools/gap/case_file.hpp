#pragma once
// A case for the gap workflow as a folder of files: case.json names the model, the weather, and the two logs.
// Format: FORMATS.md, "Cases of the gap workflow".

#include <filesystem>
#include <memory>
#include <string>

#include "tools/gap/workflow.hpp"

namespace airside::tools::gap {

struct LoadedCase {
  std::string name;    ///< the folder's
  std::string window;  ///< cases of one window and one model share responses; empty: shares with none
  std::unique_ptr<Engine> engine;
  CaseData data;
};

/// Where a case's model and logs come from; paths are resolved.
struct CaseDescription {
  std::string engine = "rc";  ///< rc or energyplus
  std::string model;          ///< rc: room name or file; energyplus: room name or epJSON file
  std::vector<std::string> patches;
  std::string weather;  ///< EPW
  std::string reference_log, measured_log;
  std::string topology = "5vav-5fcu-2power";
  std::string window;
  bool duties = true;
};

/// Errors: hal::InputError with file and key.
CaseDescription read_case(const std::filesystem::path& folder);
/// Writes case.json; paths are written as they stand.
void write_case(const std::filesystem::path& folder, const CaseDescription& description);

/// Reads model, weather and logs.
/// Errors: hal::InputError of whatever is wrong with them.
LoadedCase load_case(const CaseDescription& description, const std::string& name, const std::filesystem::path& cache);

/// Folders below `folder` that hold a case.json, in order of name.
/// Errors: hal::InputError if there is none.
std::vector<std::filesystem::path> case_folders(const std::filesystem::path& folder);

}  // namespace airside::tools::gap
