#pragma once
// The rows of one step, done to a model.

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "tools/adopt/upgrade/table/change.hpp"

namespace airside::tools::upgrade {

/// Type and name of an object of an epJSON, and the versions that changed it.
using ChangedObjects = std::map<std::pair<std::string, std::string>, std::vector<std::string>>;

/// Marks each changed object with the step's version, and adds what the step refuses.
void apply_step(IdfText& idf, const Step& step, std::vector<Refusal>& refused);
void apply_step(nlohmann::json& model, const Step& step, std::vector<Refusal>& refused, ChangedObjects& changed);

}  // namespace airside::tools::upgrade
