#pragma once
// Whether a site's points carry the objective that its file asks for.

#include <string>

#include "airside/demand_settings.hpp"
#include "hal/points/point_map.hpp"

namespace airside::hal {

/// Refuses the objective "band" where points do not show a damper and a zone setpoint for each of `rooms` rooms, the
/// supply air's temperature, the outdoor temperature and at least one power meter. `place` is the key that asks for it.
/// Errors: InputError naming every missing point, and what to do.
void refuse_objective(Objective objective, const PointMap& points, int rooms, const std::string& place);

}  // namespace airside::hal
