#pragma once
// What a site lacks, and what that costs in its rooms.

#include <string>

#include "hal/log/log_csv.hpp"

namespace airside::tools {

/// The key facts: what is not sensed, with its stand-in and its measured cost, and what the site shows beside the
/// network's inputs.
std::string signal_facts(const hal::TopologyCounts& site);

}  // namespace airside::tools
