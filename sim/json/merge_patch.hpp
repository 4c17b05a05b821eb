#pragma once
// JSON merge patches (RFC 7386): objects merge, null removes, anything else, arrays too, replaces.

#include <nlohmann/json.hpp>
#include <string>

namespace airside::sim {

/// The model after the patch.
/// Errors: hal::InputError when either is not a JSON object; `place` names the patch.
nlohmann::json merge_patched(nlohmann::json model, const nlohmann::json& patch, const std::string& place);

}  // namespace airside::sim
