#include "sim/json/merge_patch.hpp"

#include "hal/text/input_error.hpp"

namespace airside::sim {

nlohmann::json merge_patched(nlohmann::json model, const nlohmann::json& patch, const std::string& place) {
  if (!model.is_object() || !patch.is_object()) {
    const auto& wrong = model.is_object() ? patch : model;
    throw hal::InputError(place, std::string("a JSON ") + wrong.type_name(), "a JSON object of object types",
                          "start the file with { and an EnergyPlus object type");
  }
  model.merge_patch(patch);
  return model;
}

}  // namespace airside::sim
