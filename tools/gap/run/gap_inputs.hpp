#pragma once
// What a verdict was drawn from, by content: so that it can be continued, and so that nobody continues another one.

#include "tools/gap/run/gap_run.hpp"

namespace airside::tools::gap {

/// Every input with its digest; paths are absolute.  Format: docs/formats.md.
/// Errors: hal::InputError of a file that cannot be read.
nlohmann::json inputs_json(const GapRequest& request);

/// The request of a report's folder (gap.json), with that verdict as `earlier`.
/// Errors: hal::InputError for a folder without one, one of a version that kept no inputs, and for an input that is
/// gone or has changed since.
GapRequest earlier_request(const std::filesystem::path& folder);

/// What was added since the earlier verdict, and what it changed; null where nothing is continued.
nlohmann::json continued_json(const GapRun& run);

}  // namespace airside::tools::gap
