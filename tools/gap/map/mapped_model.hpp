#pragma once
// The model of a mapping file: made ready for the workflow once, and its names checked against what the engine has.

#include <filesystem>

#include "sim/energyplus/options.hpp"
#include "tools/gap/map/mapping.hpp"

namespace airside::tools::gap {

/// The model as epJSON of the engine's version with the sizes that the engine finds, so that no effect resizes the
/// equipment; a file in `cache`, which is made when model, weather or mapping has changed.
/// Errors: hal::InputError as read_foreign_model(); for a zone, node, terminal, loop, schedule, meter or output that
/// the model has not, with the nearest that it has; for a model that does not run.
/// Cost: one run of a day, 1 to 20 s; from the cache 50 ms.
std::filesystem::path prepare_mapped_model(const Mapping& mapping, const std::filesystem::path& cache);

/// The names of a model by its mapping, as the model spells them.
/// Errors: hal::InputError for one that it has not.
sim::OwnNames own_names_of(const Mapping& mapping, const nlohmann::json& model);

/// Options of the mapping's twin; `model`: what prepare_mapped_model() made.
/// Errors: as own_names_of().
sim::EnergyPlusOptions mapped_options(const Mapping& mapping, const std::filesystem::path& model);

}  // namespace airside::tools::gap
