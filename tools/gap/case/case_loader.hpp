#pragma once
// A case in memory: its model as an engine, its logs cleaned up, its two windows.

#include <memory>
#include <span>
#include <string>

#include "hal/text/input_error.hpp"
#include "tools/gap/case/case_format.hpp"
#include "tools/gap/clean_up/clean_up.hpp"
#include "tools/gap/model/responses.hpp"

namespace airside::tools::gap {

/// Both logs of a case, cleaned up.
struct CaseLogs {
  CleanLog reference, measured;
};

struct LoadedCase {
  std::string name;            ///< the folder's
  hal::TopologyCounts counts;  ///< of its logs
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

/// The shape of a case's logs: its mapping's or its site's, with stand-ins and dampers, or that of its topology.
/// Errors: hal::InputError.
hal::TopologyCounts counts_of(const CaseDescription& description);

/// Reads a log of the case's columns and cleans it up.  Errors: as read_dirty_log() or read_mapped_log().
CleanLog read_log_of(const CaseDescription& description, const std::string& path, CleanUpContext context);

/// The window of a case's log.  Errors: as window_of().
Window window_of_log(const CaseDescription& description, std::span<const hal::LogRow> rows,
                     const sim::Channels& channels, std::shared_ptr<const sim::Weather> station,
                     const std::string& place, const hal::TopologyCounts& counts);

/// Reads and cleans both logs, or divides the measured one at midnight after reference_days.
/// Errors: RefusedLog, also for files that are no logs.
CaseLogs read_case_logs(const CaseDescription& description, const CleanUpContext& context);

/// Errors: hal::InputError if the two periods overlap.
void require_apart(const CaseLogs& logs);

/// Reads model, weather and logs.
/// Errors: RefusedLog if it is the logs that cannot be used; hal::InputError of whatever else is wrong.
LoadedCase load_case(const CaseDescription& description, const std::string& name, const std::filesystem::path& cache);

}  // namespace airside::tools::gap
