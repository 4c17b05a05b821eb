#pragma once
// A mapping file: which column of a log shows which output of a model, in which unit, and which column commands which
// schedule. With it the workflow reads any EnergyPlus model and any log.  Format: docs/formats.md, "Mapping files".

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "airside/civil_time.hpp"
#include "hal/log/log_csv.hpp"

namespace airside::tools::gap {

/// What a column shows.
enum class MappedKind {
  room_temperature,
  supply_temperature,
  preheated_temperature,
  outdoor_temperature,
  power,
  damper
};

/// From a log's number to degC, kW or a fraction.
struct MappedUnit {
  std::string name;
  double factor = 1, offset = 0;  ///< x factor + offset; of energy kWh
  bool energy = false;            ///< of a row: its power is energy over the row's time
};

struct MappedChannel {
  std::string column;
  MappedKind kind{};
  std::string zone;                 ///< of rooms and dampers
  std::string key, output;          ///< of an output variable; empty: the usual one
  std::string meter;                ///< of power, instead of both
  std::vector<std::string> summed;  ///< meters whose sum `meter` is; empty: it is one of the engine's own
  MappedUnit unit;
  double noise_floor = 0;  ///< K or kW; 0: the usual one
  bool mean = false;       ///< a value is the mean of its row's time, not an instant's
  bool counter = false;    ///< energy that is counted up: the difference to the row before counts
  std::string place;       ///< of its table, for complaints
};

struct MappedCommand {
  std::string column, schedule;
  MappedUnit unit;
  bool supply_setpoint = false;  ///< that of the supply air, in degC
  std::string place;
};

/// How a log's lines and times are written.
struct MappedLog {
  std::string time = "time";   ///< column
  std::string format = "iso";  ///< or "unix", or a pattern of strptime
  char separator = ',';
  bool decimal_comma = false;
  std::optional<double> utc_offset_h;  ///< of its clock; none: the weather file's standard time
  DaylightSaving daylight_saving = DaylightSaving::none;
  int step_min = 6;
  bool stamped_at_end = true;  ///< of the time that a row stands for
};

struct Mapping {
  std::string path;  ///< of the file itself
  std::string model, weather, place;
  std::vector<std::string> patches;    ///< merge patches on the model, in order
  std::vector<std::string> zones;      ///< that effects may be in, those with a room temperature first
  std::vector<std::string> air_loops;  ///< whose equipment they may change; empty: those of the zones
  int step_min = 6;                    ///< of the simulation
  MappedLog log;
  std::vector<MappedChannel> channels;
  std::vector<MappedCommand> commands;

  /// Channels of a kind, in the file's order.
  std::vector<const MappedChannel*> of(MappedKind kind) const;
  /// Its place among the log's values of its kind, 0-based: of rooms and dampers the zone's.
  std::size_t place_of(const MappedChannel& channel) const;
  const MappedCommand* supply_setpoint() const;
  /// Commands of further schedules.
  std::vector<const MappedCommand*> further_commands() const;
};

/// Reads and checks a mapping; paths are seen from its folder.
/// Errors: hal::InputError with line and key: an unknown key, kind or unit, a channel without an object, two of one
///   place, nothing to compare.
Mapping read_mapping(const std::string& path);

/// The same of text; `path` stands in messages.
Mapping parse_mapping(std::string_view text, const std::string& path);

/// Which column is which channel, object and schedule.  Format: docs/formats.md, `map`.
nlohmann::json json_of(const Mapping& mapping);

/// The same for a terminal: "room 1: T core, zone Core_ZN".
std::vector<std::string> lines_of(const Mapping& mapping);

/// The shape of a log as it is read by the mapping: a room a zone, no fan coil.
hal::TopologyCounts counts_of(const Mapping& mapping);

}  // namespace airside::tools::gap
