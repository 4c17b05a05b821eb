#pragma once
// From a log to what the model lives through and what it is compared with.

#include <span>

#include "hal/log/log_csv.hpp"
#include "tools/gap/model/responses.hpp"

namespace airside::tools::gap {

/// The log's longest view: every 6 min from the first midnight to the last; gaps hold the last command and are missing
/// in what was measured.
/// `site`: which of the log's columns are stand-ins, which are not measured, and where dampers are; without it there
/// are none. `commands`: how many of further schedules stand behind the sides of a row.
/// Errors: hal::InputError where less than two whole days remain, or a gap is longer than a day.
Window window_of(std::span<const hal::LogRow> rows, const sim::Channels& channels,
                 std::shared_ptr<const sim::Weather> station, const std::string& place,
                 const hal::TopologyCounts& site = {}, std::size_t commands = 0);

}  // namespace airside::tools::gap
