#pragma once
// A schedule that comes later.

#include <nlohmann/json.hpp>
#include <optional>

namespace airside::tools::gap {

/// A Schedule:Compact with every day's course moved by some minutes, later where positive; what leaves the day comes
/// in at its other end. Steps between minutes are averaged, so that a small move changes a little.
/// Nothing where its fields are not as the engine documents them.
std::optional<nlohmann::json> shifted_compact(const nlohmann::json& schedule, int minutes);

}  // namespace airside::tools::gap
