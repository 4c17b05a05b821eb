#pragma once
// Sizes that the engine found for autosized fields, written into the model: a patch of walls or weather must not
// resize the equipment.

#include <filesystem>
#include <nlohmann/json.hpp>

#include "tools/adopt/model/model_view.hpp"

namespace airside::tools {

struct FoundSizes {
  nlohmann::json patch = nlohmann::json::object();  ///< a merge patch on the model
  int written = 0;
  int open = 0;  ///< autosized fields that stay so: without a reported size, or whose written size means another thing
};

/// Takes the sizes of a run's eplusout.eio. Sizing objects keep their autosized fields: they are the rule of the
/// sizing. Errors: hal::InputError where the file cannot be read.
FoundSizes sizes_of_run(const ModelView& model, const std::filesystem::path& eio, const std::filesystem::path& schema);

}  // namespace airside::tools
