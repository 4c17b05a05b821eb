#pragma once
// The names that a point map may give a meaning: signals, what a site shows beside them, clock and heartbeat.

#include <optional>
#include <string>
#include <string_view>

#include "hal/points/stand_ins.hpp"

namespace airside::hal {

class PointMap;

/// A name with a place, such as `room_temp_3`, `room_temp_3b` or `damper_2`.
struct PlacedName {
  std::string_view stem;  ///< `room_temp`
  SignalKind counted;     ///< the kind whose count a place may reach: room_temp for `damper`
  int place;
  char sensor = 0;  ///< a to h where a zone has several sensors, else 0
};

/// Nothing for names that have no place.
std::optional<PlacedName> placed_name(std::string_view name);

/// `room_temp_3b`: one of several sensors in a zone.
std::string sensor_name(int place, char sensor);
constexpr char first_sensor = 'a', last_sensor = 'h';

/// "line 7 has "rom_temp_2": correct its name if it is that; otherwise " where a point without a meaning of its own is
/// called nearly `name`; else "".
std::string named_alike(const PointMap& map, std::string_view name);

/// The unit that lib expects of a point, nullptr where any will do: the name has no meaning of its own.
const char* expected_unit(std::string_view name);

}  // namespace airside::hal
