#pragma once
// Rows of points.csv that name a BACnet object. Behind `airside-bacnet` each has two registers by one rule, so that
// nobody writes addresses: place n among the points (from 0) has address 2n; float32, big end first; function 4, for
// what is written 3 and 16. The gateway has the same rule in firmware/bacnet/airside_bacnet/point_map.py.

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "hal/points/point_map.hpp"
#include "hal/points/point_row.hpp"

namespace airside::hal {

/// Point::object of what the gateway itself holds: the heartbeat that it watches, and the fingerprint of its map.
constexpr std::string_view held_by_gateway = "gateway";

/// Checks the object of a row, and fills the cells that the rule decides, which must be empty.
/// Returns the object in full, `1201:analog-input:3:present-value`.
/// Errors: InputError at file:line, column.
std::string take_bacnet_row(PointRow& row, std::size_t index);

/// Of a row of Modbus, which has no object: the empty text. Errors: InputError.
std::string refuse_object(const PointRow& row);

/// Adds a complaint where a map mixes protocols, names an object twice, or lacks what the gateway watches and shows.
/// `is_sound`: a point for each, whether its row is in order; of the others only names count.
void check_protocols(const PointMap& map, const std::vector<bool>& is_sound, std::vector<InputError>& complaints);

}  // namespace airside::hal
