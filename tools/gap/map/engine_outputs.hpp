#pragma once
// Which output variables and meters the engine has for a model, by a run of a day.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "sim/energyplus/install.hpp"
#include "sim/energyplus/replay/replay.hpp"
#include "tools/adopt/sizes.hpp"
#include "tools/gap/map/mapping.hpp"

namespace airside::tools::gap {

/// Runs the twin's model for a day with the outputs of the mapping and returns the sizes that the engine found.
/// Errors: hal::InputError of a model that does not run, and for an output variable, its key or a meter that is not
///   there, with the nearest that are.
FoundSizes check_outputs(const sim::EnergyPlusTwin& twin, const Mapping& mapping,
                         const sim::EnergyPlusInstall& install);

}  // namespace airside::tools::gap
