#pragma once
// Days that come after a first verdict, perhaps with a test on site: read, checked against the days before, and stacked
// on them.

#include "tools/gap/run/gap_run.hpp"

namespace airside::tools::gap {

/// Reads the request's further logs into `run.added` and puts them into the measured window: days with a test before
/// the others, so that those that were locked away stay so; other days behind them, joined without a seam where they
/// follow within a day.
/// Errors: RefusedLog for a log that cannot be used; hal::InputError for days that are known already, for another
/// site's days, and for a log in which the test was not done.
void add_more_days(GapRun& run, const std::vector<sim::Effect>& effects);

}  // namespace airside::tools::gap
