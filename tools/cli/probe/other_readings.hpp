#pragma once
// Ways to read a point that its row of the map does not state, and which of them give a plausible value.

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "hal/points/point_map.hpp"
#include "tools/cli/probe/sheet.hpp"

namespace airside::tools {

/// Values that a point of this name can have (`limits`), and those that it has nearly always (`usual`), in its unit.
struct PlausibleRange {
  double least = -HUGE_VAL, most = HUGE_VAL;
};
/// The project's limits of a signal of that name, as `airside init` writes them into every map; none for other names.
PlausibleRange limits_of_name(const std::string& name);
/// Within both limits_of_name() and the limits of the row.
PlausibleRange usual_range(const hal::Point& point);

/// `room_temp` of `room_temp_3b`.
std::string stem_of_name(const std::string& name);
/// Whether a value alone can show that it is read wrongly: not of states, heartbeats and clocks.
bool can_be_judged(const hal::Point& point);

/// A row as it would be, and what it would show.
struct OtherReading {
  hal::Point point;
  double value = 0;
  int changes = 1;  ///< of type, order, scale, unit and place
};

/// Registers of a map, so that no row is moved onto another's.
class ClaimedRegisters {
 public:
  explicit ClaimedRegisters(const hal::PointMap& map);
  /// Whether `moved` would read a register that another row than `stated` reads.
  bool are_others_in(const hal::Point& moved, const hal::Point& stated) const;

 private:
  std::set<std::pair<int, int>> claimed_;
};

/// All readings with one or two changes that give a usual value, fewest changes first; of readings with the same value
/// one. Each can hold the row's limits. Cost: some exchanges.
std::vector<OtherReading> other_readings(const hal::Point& stated, const ClaimedRegisters& claimed,
                                         ProbedDevice& device);

/// Whether two rows change alike: type, orders, scale, offset, function, and the same step of address.
bool is_same_change(const OtherReading& a, const hal::Point& stated_a, const OtherReading& b,
                    const hal::Point& stated_b);

/// `scale 1 -> 0.01, word_order big -> little`: the cells that differ.
std::string change_text(const hal::Point& stated, const hal::Point& other);
/// The same by column and new text.
std::vector<std::pair<std::string, std::string>> changed_cells(const hal::Point& stated, const hal::Point& other);

}  // namespace airside::tools
