#pragma once
// airside blob rank: which of several rooms' weights suits a room best.

#include <CLI/CLI.hpp>

namespace airside::tools {

/// Adds the subcommand `rank` to `airside blob`.
void add_rank(CLI::App& blob);

}  // namespace airside::tools
