#pragma once
// Reads a set of points in as few requests as the map allows, and gives each its number or its fault.

#include <cstdint>
#include <string>
#include <vector>

#include "airside/fault.hpp"
#include "hal/modbus_link.hpp"
#include "hal/point_map.hpp"

namespace airside::hal {

class ModbusPoller {
 public:
  /// Groups points of one function whose addresses follow on each other, up to what one request may hold; a gap
  /// is never read, because many devices refuse it. Slots keep the order of `points`.
  explicit ModbusPoller(const std::vector<Point>& points);

  /// Reads every group. A group that the device refuses (exceptions 2 and 3) is read point by point: at once after
  /// exception 2, from the next poll on after 3; points refused alone stay invalid.
  /// Errors: LinkFault where the link itself failed; then all slots are invalid.
  /// Cost: one exchange a group; no heap.
  LinkResult<void> poll(ModbusLink& link);

  /// NaN where fault() is not none.
  double value(int slot) const { return value_[static_cast<std::size_t>(slot)]; }
  Fault fault(int slot) const { return fault_[static_cast<std::size_t>(slot)]; }
  /// Exception code that the last poll met, 0 for none.
  std::uint8_t last_exception() const { return last_exception_; }
  int groups() const { return static_cast<int>(groups_.size()); }

 private:
  struct Group {
    int fc, addr, count;
    std::vector<int> slots;
    bool split = false;
  };

  void invalidate(Fault fault);
  LinkResult<void> read_group(ModbusLink& link, Group& group);
  LinkResult<void> read_alone(ModbusLink& link, int slot);
  void take(int slot, std::span<const std::uint16_t> words);

  std::vector<Point> points_;
  std::vector<Group> groups_;
  std::vector<double> value_;
  std::vector<Fault> fault_;
  std::vector<std::uint16_t> words_;
  std::uint64_t generation_ = 0;
  std::uint8_t last_exception_ = 0;
};

}  // namespace airside::hal
