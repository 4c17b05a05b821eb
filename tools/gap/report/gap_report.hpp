#pragma once
// The report of the gap workflow: what is missing in the model, where and when it shows, and how sure that is.

#include "tools/gap/run/gap_run.hpp"
#include "tools/report/charts/report_input.hpp"

namespace airside::tools {

/// Header, verdict, clean-up, maps of errors, curves, ranking, locked days and ledger.
ReportInput make_gap_report(const gap::GapRun& run);

}  // namespace airside::tools
