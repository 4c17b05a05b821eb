#pragma once
// Logs as the methods of a report: which files are one method, and what is wrong with one that cannot be judged.

#include <string>
#include <vector>

#include "hal/log/log_csv.hpp"
#include "tools/run/control_run.hpp"

namespace airside::tools {

/// A method's log, read and judged.
struct LoggedMethod {
  std::string name;
  std::vector<std::string> paths;  ///< in order of time; a folder counts as one
  hal::Log log;
  ControlRun run;
  Metrics metrics;

  /// Where it was read from, for people.
  std::string place() const;
};

/// The files of a method before they are read.
struct LogGroup {
  std::string name;
  std::vector<std::string> paths;
};

/// Which logs are one method. The daily files that a box writes into one folder (`airside-2021-07-01.csv`, a day's
/// further parts `airside-2021-07-01_01.csv`) are one, called as the folder; any other path is a method of its own,
/// called as the file. `names`, in order, name the methods found so; where there are more names than methods they
/// name the logs one by one, and logs of one name are one method.
/// Errors: hal::InputError for two methods of one name, and for more names than logs.
std::vector<LogGroup> group_logs(const std::vector<std::string>& logs, const std::vector<std::string>& names);

/// Reads and judges them. Holes are kept as gaps: a box's log has them where a sensor failed.
/// Errors: hal::InputError; for a log without one whole cycle with the cause, such as temperatures in degF.
std::vector<LoggedMethod> read_logged_methods(const Site& site, const std::vector<LogGroup>& groups);

}  // namespace airside::tools
