#pragma once
// Which objective a site file asks for, and whether the site's points carry it.

#include <string>
#include <string_view>

#include "airside/demand/demand_settings.hpp"
#include "hal/points/point_map.hpp"

namespace airside::hal {

/// "mean" or "band".  Errors: InputError naming `place`.
Objective parse_objective(std::string_view text, const std::string& place);

/// Refuses the objective "band" where points do not show a damper and a zone setpoint for each of `rooms` rooms, the
/// supply air's temperature, the outdoor temperature and at least one power meter. `place` is the key that asks for it.
/// Errors: InputError naming every missing point, and what to do.
void refuse_objective(Objective objective, const PointMap& points, int rooms, const std::string& place);

}  // namespace airside::hal
