#pragma once
// A model that somebody else wrote, whose own thermostats and terminals control its rooms: which of its objects the
// plant reads, and what of the model is changed for a run.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hal/text/input_error.hpp"
#include "sim/energyplus/adopted/model_index.hpp"
#include "sim/weather/recording.hpp"

namespace airside::sim {

/// What a log shows in the place of a channel's usual output.
struct OwnOutput {
  std::string key, variable;  ///< of an output in degC, W or, where the name ends in "Energy", J; empty: the usual one
};

/// The names by which such a model offers what its points show. An empty text or list is not there; so is "" within
/// terminals and powers.
struct OwnNames {
  std::string supply_setpoint_schedule;  ///< a Schedule:Constant, the only thing that is acted on
  std::string supply_air_node;
  std::string mau_outlet_node;
  std::vector<std::string> zones;      ///< one a room
  std::vector<std::string> terminals;  ///< one a zone
  std::vector<std::string> fcu_zones;
  std::string supply_fan;
  std::vector<std::string> powers;     ///< meters, one a power point
  std::vector<std::string> occupancy;  ///< zones whose people count

  std::vector<OwnOutput> room_outputs, power_outputs;  ///< one a room and a power, or none
  std::vector<std::string> commands;                   ///< schedules that follow the record's commands
  std::vector<ChannelGrain> grain;                     ///< one a column of a replay, or none
  bool every_air_loop = false;  ///< equipment is that of all loops with these zones, not of supply_air_node's alone
  std::vector<std::string> air_loops;  ///< or of these loops
  bool outdoor_measured = true;        ///< else the weather file's temperature is all there is
};

/// What follows from the names and the model.
struct OwnParts {
  std::vector<std::string> fcu_fans;          ///< the fan in the unit of each of fcu_zones
  std::vector<std::string> people_schedules;  ///< of the people in the zones of `occupancy`, each once
};

/// Every name that the model lacks, with the near ones that it has. Meters are not looked for: the engine makes them.
/// `place` names the model in complaints.
std::vector<hal::InputError> missing_own_names(const nlohmann::json& model, const OwnNames& names,
                                               const std::string& place);

/// Finds the parts; a name that missing_own_names() would refuse has none.
OwnParts own_parts(const nlohmann::json& model, const OwnNames& names);

/// Whose place a record's commands can take.
inline constexpr const char* command_schedule_types[] = {"Schedule:Constant", "Schedule:Compact", "Schedule:Year",
                                                         "Schedule:File"};

/// A schedule of command_schedule_types, by its name; `fields` is null where the model
/// has none.
ModelObject find_command_schedule(const nlohmann::json& model, const std::string& name);

/// The schedules that are commanded become constants, which a replay lets follow the record: nothing else of the model
/// may change what was commanded. A name that the model has not is passed over; a replay refuses it.
void free_command_schedules(nlohmann::json& model, const OwnNames& names);

/// Makes a run of the weather file of it: reports that nobody reads are dropped (they take most of the time of a
/// large model), daylight saving too, since schedules keep standard time.
/// Errors: hal::InputError for objects that must be expanded first.
void prepare_own_model(nlohmann::json& model, const std::string& place);

}  // namespace airside::sim
