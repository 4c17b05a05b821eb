#pragma once
// A site as a Brick model.

#include <string>

#include "tools/run/site.hpp"

namespace airside::tools {

/// Brick 1.3 and 1.4, with RealEstateCore's locations, QUDT units and a reference of each point to its register or its
/// BACnet object, and to its column of the log; Turtle. A site that is only simulated has no registers.
std::string brick_model(const Site& site);

}  // namespace airside::tools
