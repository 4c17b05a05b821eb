#pragma once
// Checks a model or a patch against the engine's own schema. The engine ignores a misspelt field in silence and
// crashes on some unknown names, so every model passes here first.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hal/text/input_error.hpp"

namespace airside::sim {

enum class LintScope {
  patch,  ///< a part: required fields and references are not looked for, null removes
  whole,  ///< a model ready to run
};

struct LintTarget {
  std::string place;  ///< file or patch name, for complaints
  LintScope scope = LintScope::whole;
};

/// Everything that is wrong, in the model's order: unknown object types and fields (with the nearest known name),
/// wrong types, choices and bounds; for whole models also missing fields and names that nothing defines.
/// `schema` is Energy+.schema.epJSON.  Cost: 0.1 s for the first call with a schema, ms after.
/// Errors: hal::InputError when the schema cannot be read, or what is needed of it is no JSON.
std::vector<hal::InputError> epjson_complaints(const nlohmann::json& model, const std::filesystem::path& schema,
                                               const LintTarget& target);

/// Throws the first of epjson_complaints(), with the number of the others in its remedy.
void lint_epjson(const nlohmann::json& model, const std::filesystem::path& schema, const LintTarget& target);

}  // namespace airside::sim
