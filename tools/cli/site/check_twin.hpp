#pragma once
// The twin that a site or a command line names: whether it could run, found out without running it, or by a day.

#include <string>

#include "hal/log/log_csv.hpp"
#include "hal/site/twin_section.hpp"
#include "tools/cli/site/findings.hpp"
#include "tools/run/site.hpp"

namespace airside::tools {

/// Looks at an epJSON model and its patches: the engine's schema, and the names that airside drives and reads in it.
/// `twin`: model and patches as a [twin] has them; an empty model: the patches are looked at alone. `counts`: of the
/// site, whose shape the twin must have.
void check_twin(Findings& out, const hal::TwinSection& twin, const hal::TopologyCounts& counts);

/// Whether a model file is somebody else's: an IDF, or an epJSON model that the engine's schema takes and that lacks
/// most names that airside drives in its own. False for a file that cannot be read, and without the engine: then
/// check_twin() says why.
bool is_foreign(const std::string& path);

/// All that `airside adopt` checks before it runs the engine; nothing is written.
/// `air_loop`, `weather`: empty: the only one, and the nearest.  Cost: below 1 s.
void check_foreign(Findings& out, const std::string& path, const std::string& air_loop, const std::string& weather);

/// Runs the twin of a site for a day of July under its schedule, and says what its sensors showed: what only the engine
/// knows, such as meters, is then known too.  Cost: 1 to 10 s.
void try_twin(Findings& out, const Site& site);

/// An EPW file; `for_engine`: as EnergyPlus reads it, which takes more columns than the rc plant.
void check_weather(Findings& out, const std::string& path, bool for_engine);

}  // namespace airside::tools
