#pragma once
// From the rows of a run, or of a log, to what a report shows: simulation, studies and `airside report` share it, so
// that a logged week and a simulated one are drawn and judged alike.

#include "tools/report/run_report.hpp"
#include "tools/run/control_run.hpp"

namespace airside::tools {

/// Target, rooms and all series of a run; what the log does not hold stays empty and its chart is left out.
/// The caller adds the texts (plant, weather, seeds, versions, weights_digest, command) and the methods.
RunRecord make_run_record(const Site& site, const ControlRun& run);

/// The run that a log tells of: its rows, and the cycles and power readings that it holds whole. Rows with holes are
/// drawn as gaps and not scored.
/// Errors: hal::InputError when no cycle is whole; `place` names the log.
ControlRun run_of_log(const Site& site, const hal::Log& log, const std::string& place);

}  // namespace airside::tools
