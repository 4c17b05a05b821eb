#pragma once
// Table [twin] of a site file: the model that stands for the building, who controls its rooms, and the names by which
// the model offers what the points show.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace airside::hal {

class TomlSection;

/// Who controls what is not the supply setpoint. `external`: loops beside the engine command dampers, fan coils and
/// people. `own`: the model's own thermostats, terminals and schedules do, as in a model that somebody else wrote.
enum class TwinControl : std::uint8_t { external, own };

/// [twin.names]; an empty text or list is not given.
struct TwinNames {
  std::string supply_setpoint_schedule;  ///< the Schedule:Constant that holds the supply-air setpoint
  std::string supply_air_node;           ///< its temperature is `supply_temp`, its flow `supply_flow`
  std::string mau_outlet_node;
  std::vector<std::string> powers;  ///< meters, one a power point; "" for a point that has none

  // control = "own"
  std::vector<std::string> zones;      ///< one a room, in the order of the points room_temp_n
  std::vector<std::string> terminals;  ///< an air terminal a zone; "" where it shows no damper
  std::vector<std::string> fcu_zones;  ///< zones with a unit of their own: temperature, and whether its fan runs
  std::string supply_fan;
  std::vector<std::string> occupancy;  ///< zones whose people say whether the building is occupied

  // control = "external"; `#` stands for the place
  std::vector<std::string> interior_zones, perimeter_zones;
  std::string vav_on_schedule, vav_damper_schedule, fcu_on_schedule;
  std::string interior_occupancy_schedule, perimeter_occupancy_schedule;
};

struct TwinSection {
  std::string model;                 ///< path of an epJSON file, or "rc"
  std::vector<std::string> patches;  ///< paths of merge patches, applied in order
  std::string weather;               ///< path of an EPW file, or empty
  TwinControl control = TwinControl::external;
  int step_min = 0;         ///< of the simulation: 3 or 6; 0 where not given
  double supply_lag_s = 0;  ///< own: first-order lag of the AHU behind its setpoint
  std::optional<TwinNames> names;
};

/// Reads and checks the table; lists must have the counts of `topology`, such as "12vav-0fcu-2power". Paths are as
/// written.
/// Errors: InputError with place and key.
TwinSection read_twin_section(TomlSection root, const std::string& topology);

}  // namespace airside::hal
