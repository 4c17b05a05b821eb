#pragma once
// airside gap fit: an RC room from a log, for a site without a model of its building.

#include <CLI/CLI.hpp>

namespace airside::tools {

void add_gap_fit(CLI::App& gap);

}  // namespace airside::tools
