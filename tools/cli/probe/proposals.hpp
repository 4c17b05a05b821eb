#pragma once
// What a map's wrong rows should probably say, with the evidence; a person decides.

#include <string>
#include <vector>

#include "hal/points/point_map.hpp"
#include "tools/cli/probe/other_readings.hpp"
#include "tools/cli/probe/sheet.hpp"

namespace airside::tools {

/// One row that shows an implausible value, or that goes with such rows.
struct Proposal {
  const ProbedPoint* probed = nullptr;
  std::vector<OtherReading> readings;  ///< one: proposed; several: all are plausible, none is proposed; none: no idea
  std::string evidence;

  bool is_decided() const { return readings.size() == 1; }
};

/// A whole block of the same function that makes sense one register lower or higher, and as stated does not, moves
/// together. Otherwise rows of one kind that are encoded alike are judged together: a reading counts where it makes
/// every doubtful row of the kind plausible. Doubtful is what is outside its own limits or those of its name.
/// Cost: some exchanges for each doubtful row.
std::vector<Proposal> propose(const std::vector<ProbedPoint>& sheet, const hal::PointMap& map, ProbedDevice& device);

/// One line, ended: `room_temp_1  scale 1 -> 0.01: reads 22.35 degc instead of 2235; ...`.
std::string text_of(const Proposal& proposal);

}  // namespace airside::tools
