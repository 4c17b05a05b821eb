#pragma once
// Reads a set of points in as few requests as the map allows, and gives each its number or its fault.

#include <cstdint>
#include <string>
#include <vector>

#include "airside/fault.hpp"
#include "hal/modbus/link.hpp"
#include "hal/points/point_map.hpp"

namespace airside::hal {

class ModbusPoller {
 public:
  /// Groups points of one function whose addresses follow on each other, up to what one request may hold; a gap
  /// is never read, because many devices refuse it. Slots keep the order of `points`.
  explicit ModbusPoller(const std::vector<Point>& points);

  /// Reads every group. What the device refuses is not asked again as it was: after exception 2 the group is read point
  /// by point, after 3 in requests of half as many registers, both for as long as the connection lasts; a point refused
  /// alone is invalid. A point whose words make sense only in another order is invalid too, until its own has made
  /// sense for a while; the order is never changed.
  /// Errors: LinkFault where the link itself failed; then all slots are invalid.
  /// Cost: one exchange a group, up to 7 and one a point more after a new connection; no heap.
  LinkResult<void> poll(ModbusLink& link);

  /// NaN where fault() is not none.
  double value(int slot) const { return value_[static_cast<std::size_t>(slot)]; }
  Fault fault(int slot) const { return fault_[static_cast<std::size_t>(slot)]; }
  /// Exception code that the last poll met, 0 for none.
  std::uint8_t last_exception() const { return last_exception_; }
  /// The last poll met exception 1, 2 or 3: the map asks for what the device does not have.
  bool map_refused() const { return map_refused_; }
  /// The last poll met an exception that only a gateway gives: 10, 11 or an unknown one.
  bool gateway_failed() const { return gateway_failed_; }
  /// A point whose words seem to stand in another order than the map says; nullptr where there is none.
  const Point* order_doubted() const;
  int groups() const { return static_cast<int>(groups_.size()); }

 private:
  struct Group {
    int fc, addr, count;
    std::vector<int> slots;
    int at_most;  ///< registers, or bits, in one request
  };
  static constexpr std::uint8_t order_is_doubted = 4, order_doubt_limit = 10;

  void invalidate(Fault fault);
  LinkResult<void> read_group(ModbusLink& link, Group& group);
  void take_exception(std::uint8_t code);
  void take(int slot, std::span<const std::uint16_t> words);

  std::vector<Point> points_;
  std::vector<Group> groups_;
  std::vector<double> value_;
  std::vector<Fault> fault_;
  std::vector<std::uint8_t>
      order_doubt_;  ///< 2 more with each reading that fits another order only, 1 less with others
  std::vector<std::uint16_t> words_;
  std::uint64_t generation_ = 0;
  std::uint8_t last_exception_ = 0;
  bool map_refused_ = false, gateway_failed_ = false;
};

}  // namespace airside::hal
