#pragma once
// What the controller did from when to when, and why: bands behind the charts of a run, and the list of them.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "tools/report/charts/report_input.hpp"
#include "tools/report/run_report.hpp"

namespace airside::tools {

/// A control mode as the operator's page calls it: "Released" for `release`.
std::string mode_words(std::string_view mode);

/// A reason with what it means: "overridden: somebody else has set the setpoint".
std::string reason_words(const std::string& reason);

/// The signal that a row's fault is about, a text a row: "room_temp_2", several apart by commas, "" where there is no
/// such fault or none can be named. Without a number: those that have one elsewhere in the run. Stuck: the temperature
/// that has stood still for longest. Disagrees: the room furthest from the median of all.
std::vector<std::string> signals_at_fault(const hal::TopologyCounts& counts, const std::vector<hal::LogRow>& rows);

/// Every mode but undisturbed learning, in order; neighbours differ in mode, reason, fault or signal.
std::vector<ChartStretch> stretches_of(const RunRecord& record);

/// The same as a list with reason, fault and signal; nothing where there was no reason and no fault.
std::optional<ReportTable> events_table(const RunRecord& record);

}  // namespace airside::tools
