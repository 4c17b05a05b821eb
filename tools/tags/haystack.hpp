#pragma once
// A site in the tags of Project Haystack.

#include <nlohmann/json.hpp>

#include "tools/run/site.hpp"

namespace airside::tools {

/// A grid of Haystack 4 in its JSON encoding (Hayson): site, spaces, equipment and points, with the register of each
/// point in tags of airside's own, or its BACnet object in bacnetCur and such tags. A site that is only simulated has
/// no registers.
nlohmann::json haystack_grid(const Site& site);

}  // namespace airside::tools
