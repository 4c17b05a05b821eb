#pragma once
// The twin that a site or a command line names: whether it could run, found out without running it.

#include <optional>
#include <string>
#include <vector>

#include "hal/log/log_csv.hpp"
#include "tools/cli/site/findings.hpp"

namespace airside::tools {

/// Looks at an epJSON model and its patches: the engine's schema, and the names that airside drives and reads in it.
/// `model_path` may be empty: then the patches are looked at alone. `counts`: of the site, whose shape the twin must
/// have.
void check_twin(Findings& out, const std::string& model_path, const std::vector<std::string>& patch_paths,
                const hal::TopologyCounts& counts);

/// An EPW file; `for_engine`: as EnergyPlus reads it, which takes more columns than the rc plant.
void check_weather(Findings& out, const std::string& path, bool for_engine);

}  // namespace airside::tools
