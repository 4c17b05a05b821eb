#pragma once
// The words of column `type` in points.csv, read and written by one table.

#include <array>
#include <utility>

#include "hal/points/point_map.hpp"

namespace airside::hal {

/// In the order of PointType. Source: docs/formats.md, "Point map".
inline constexpr std::array<std::pair<const char*, PointType>, 7> point_type_names{{{"coil", PointType::coil},
                                                                                    {"discrete", PointType::discrete},
                                                                                    {"int16", PointType::int16},
                                                                                    {"uint16", PointType::uint16},
                                                                                    {"int32", PointType::int32},
                                                                                    {"uint32", PointType::uint32},
                                                                                    {"float32", PointType::float32}}};

constexpr const char* name_of(PointType type) {
  for (const auto& [name, of] : point_type_names)
    if (of == type) return name;
  return "";
}

}  // namespace airside::hal
