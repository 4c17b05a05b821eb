#pragma once
// The subcommands of `airside study`.

#include <CLI/CLI.hpp>

namespace airside::tools {

void add_study_tune(CLI::App& study);

}  // namespace airside::tools
