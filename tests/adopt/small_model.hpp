#pragma once
// The project's own twin as a foreign model: one air loop of five VAV boxes without reheat, changed by merge patches.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "sim/json/json_file.hpp"
#include "sim/json/merge_patch.hpp"

namespace airside::tools {

inline const nlohmann::json& small_model() {
  static const nlohmann::json model =
      sim::read_json(std::filesystem::path(AIRSIDE_SOURCE_DIR) / "sim" / "models" / "twin.epJSON");
  return model;
}

inline nlohmann::json small_model_with(const std::string& patch) {
  return sim::merge_patched(small_model(), sim::parse_json(patch, "case"), "case");
}

}  // namespace airside::tools
