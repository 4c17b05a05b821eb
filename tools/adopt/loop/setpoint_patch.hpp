#pragma once
// The change that gives a model's supply-air setpoint into other hands: a constant schedule that a run may set.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "tools/adopt/loop/air_loop.hpp"

namespace airside::tools {

struct SetpointPatch {
  nlohmann::json patch;            ///< a merge patch on the model (RFC 7386)
  std::string schedule;            ///< name of the Schedule:Constant that holds the setpoint
  std::vector<std::string> notes;  ///< what was replaced
  bool unit_switched = false;      ///< a packaged unit was under control by load, and no longer is
  bool knew_the_load = false;      ///< the supply outlet's manager took the zone's load of the same step
};

/// Every manager of temperature at the supply outlet becomes one SetpointManager:Scheduled. Managers that set the mixed
/// air, or a coil from the cooling coil on, by a rule of their own would compete with it: there the supply setpoint
/// less the fan's heat is taken (SetpointManager:MixedAir). A unit controlled by load is switched to setpoint control
/// where its type offers that.
/// `setpoint_degc`: the schedule's value until a run sets it. Units: degC.
/// Errors: hal::InputError where nothing on the loop follows a setpoint, and for units of a type without setpoint
///   control.
SetpointPatch setpoint_patch(const ModelView& model, const AirLoop& loop, double setpoint_degc);

}  // namespace airside::tools
