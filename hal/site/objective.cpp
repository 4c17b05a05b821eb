#include "hal/site/objective.hpp"

#include <fmt/format.h>

#include <vector>

#include "hal/text/input_error.hpp"

namespace airside::hal {

void refuse_objective(Objective objective, const PointMap& points, int rooms, const std::string& place) {
  if (objective != Objective::band) return;
  std::vector<std::string> missing;
  const auto need = [&](const std::string& name) {
    if (points.find(name) == nullptr) missing.push_back(name);
  };
  for (int i = 1; i <= rooms; ++i) need(fmt::format("damper_{}", i));
  for (int i = 1; i <= rooms; ++i) need(fmt::format("zone_setpoint_{}", i));
  need("supply_temp");
  need("outdoor_temp");
  need("power_1");
  if (missing.empty()) return;
  throw InputError(
      place, fmt::format("\"band\", and {} without {}", points.file(), fmt::join(missing, ", ")),
      "a damper and a zone setpoint a room, supply_temp, outdoor_temp and power_1: from them demand and "
      "energy are learned",
      "add these points, for which [stand_in] cannot stand in, and a power meter to a topology without one; "
      "or take objective = \"mean\", which needs room temperatures alone; where boxes modulate and no "
      "damper is shown, keep the AHU's own reset");
}

}  // namespace airside::hal
