#pragma once
// A case for the gap workflow as a folder of files: case.json names the model, the weather, and the two logs.
// Format: FORMATS.md, "Cases of the gap workflow".

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "hal/text/input_error.hpp"
#include "sim/energyplus/options.hpp"
#include "tools/gap/clean_up/clean_up.hpp"
#include "tools/gap/verdict/workflow.hpp"

namespace airside::tools::gap {

/// Both logs of a case, cleaned up.
struct CaseLogs {
  CleanLog reference, measured;
};

struct LoadedCase {
  std::string name;  ///< the folder's
  std::unique_ptr<Engine> engine;
  CaseLogs logs;
  CaseData data;
};

/// A log that nothing can be concluded from; what() is the first reason.
class RefusedLog : public hal::InputError {
 public:
  RefusedLog(const hal::InputError& reason, CaseLogs logs) : hal::InputError(reason), logs_(std::move(logs)) {}
  /// All that was found, in both logs as far as they were read.
  const CaseLogs& logs() const { return logs_; }

 private:
  CaseLogs logs_;
};

/// Where a case's model and logs come from; paths are resolved.
struct CaseDescription {
  std::string engine = "rc";  ///< rc or energyplus
  std::string model;          ///< rc: room name or file; energyplus: room name or epJSON file
  std::vector<std::string> patches;
  std::string weather;  ///< EPW
  std::string reference_log, measured_log;
  int reference_days = 0;  ///< > 0, without a reference log: so many days of the measured log are the reference
  std::string topology = "5vav-5fcu-2power";
  std::string window;  ///< cases of one window and one model may share responses; empty: shares with none
  bool duties = true;
};

/// Errors: hal::InputError with file and key.
CaseDescription read_case(const std::filesystem::path& folder);
/// Writes case.json; paths are written as they stand.
void write_case(const std::filesystem::path& folder, const CaseDescription& description);

/// Whether it is worth asking what cases may share, which SharedWindows decides by their recordings: where a response
/// costs a second.
bool shares_responses(const CaseDescription& description);
/// Equal for cases that may share responses.
std::string shared_window_of(const CaseDescription& c);

/// The model as the user has it, before any effect: the epJSON with its patches, or the room file.
/// Errors: hal::InputError of unreadable files and unknown names.
nlohmann::json model_of(const CaseDescription& description);
/// The names of a model's zones and schedules, and the loops beside it; EnergyPlus only.
sim::EnergyPlusOptions energyplus_options_of(const CaseDescription& description);

/// Reads and cleans both logs, or divides the measured one at midnight after reference_days.
/// Errors: RefusedLog, also for files that are no logs.
CaseLogs read_case_logs(const CaseDescription& description, const CleanUpContext& context);

/// Errors: hal::InputError if the two periods overlap.
void require_apart(const CaseLogs& logs);

/// Reads model, weather and logs.
/// Errors: RefusedLog if it is the logs that cannot be used; hal::InputError of whatever else is wrong.
LoadedCase load_case(const CaseDescription& description, const std::string& name, const std::filesystem::path& cache);

/// Folders below `folder` that hold a case.json, in order of name.
/// Errors: hal::InputError if there is none.
std::vector<std::filesystem::path> case_folders(const std::filesystem::path& folder);

}  // namespace airside::tools::gap
