#pragma once
// Where a log's rows keep the signals that each room has one of.

#include <vector>

#include "hal/log/log_csv.hpp"

namespace airside::hal {

/// Places in LogRow::side of a signal, by room; empty where one of the rooms has none.
inline std::vector<std::size_t> side_places(const TopologyCounts& counts, SideSignal signal) {
  std::vector<std::size_t> places;
  for (std::size_t i = 0; i < counts.sides.size(); ++i) {
    if (counts.sides[i].signal == signal) places.push_back(i);
  }
  if (places.size() != static_cast<std::size_t>(counts.vavs)) places.clear();
  return places;
}

}  // namespace airside::hal
