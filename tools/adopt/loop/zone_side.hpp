#pragma once
// From an air loop's demand inlet to its zones: supply path, splitters and plenums, terminals, equipment lists.

#include "tools/adopt/loop/air_loop.hpp"

namespace airside::tools {

/// Fills terminals, fcu_zones and notes of a loop whose demand_inlet is known; `object` is the loop in the model.
/// Errors: hal::InputError as walk_air_loop().
void walk_zone_side(const ModelView& model, const ModelObject& object, AirLoop& loop);

}  // namespace airside::tools
