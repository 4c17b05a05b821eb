#pragma once
// What the logs of a site have beside the columns of its topology.

#include "hal/log/log_csv.hpp"
#include "hal/points/point_map.hpp"
#include "hal/points/stand_ins.hpp"

namespace airside::hal {

/// The counts with the stand-ins of what the map lacks, and a further column for each side signal that it has.
TopologyCounts counts_of(TopologyCounts counts, const PointMap& map, const StandIns& stand_ins);

}  // namespace airside::hal
