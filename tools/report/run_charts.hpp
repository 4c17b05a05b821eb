#pragma once
// The charts of a run over its time, and the table of what the controller did and why.

#include "tools/report/charts/report_input.hpp"
#include "tools/report/run_report.hpp"

namespace airside::tools {

/// Adds those of which the record has a series: rooms, closed boxes, setpoint, dampers, modes and their reasons,
/// confidence and losses, power, outdoor air.
void add_line_charts(const RunRecord& record, ReportInput& out);

}  // namespace airside::tools
