#pragma once
// From [twin] of a site file to what an EnergyPlus run needs.

#include "hal/site/twin_section.hpp"
#include "sim/energyplus/options.hpp"
#include "tools/run/site.hpp"

namespace airside::tools {

/// The names by which the project's own twin is driven, with those that [twin.names] gives instead.
sim::ModelNames external_names(const hal::TwinSection& twin);
/// The names of a model that its own thermostats and terminals control; `twin` has control = "own".
sim::OwnNames own_names(const hal::TwinNames& names);

/// Whether an EnergyPlus model of this section has the site's shape: the lists of [twin.names] have its counts, and
/// without them it must be the method's.
bool shape_fits(const std::optional<hal::TwinSection>& twin, const hal::TopologyCounts& counts);

/// Model, patches, weather, steps, names and control of the section; the habits of a room are the twin's.
/// Errors: hal::InputError as read_json().
sim::EnergyPlusOptions twin_options(const hal::TwinSection& twin);

}  // namespace airside::tools
