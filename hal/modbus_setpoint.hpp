#pragma once
// Writes one point and finds out what the device made of it.

#include <limits>

#include "airside/fault.hpp"
#include "hal/modbus_link.hpp"
#include "hal/point_map.hpp"

namespace airside::hal {

class ModbusSetpoint {
 public:
  /// `settle_s`: how long the read-back may lag behind the write, s; [0, 10].
  /// Errors: InputError where the map has no such writable point.
  ModbusSetpoint(const PointMap& map, std::string_view name, double settle_s = 0.0);

  /// Writes `value` unless the policy is on-change and the device already holds it, then reads back.
  /// Where the device refuses, the other function (6 or 16) is tried once, and kept where it works.
  /// Returns the value read back, or the rounded value where nothing can be read back.
  /// Errors: write_refused where the device answered with an exception; not_applied for a value that the point cannot
  /// hold or that is outside its limits, a lost link, or a read-back that is no number. Cost: at most 4 exchanges and
  /// settle_s; no heap.
  Expected<double> write(ModbusLink& link, double value) { return write(link, value, link.generation()); }
  /// The same, but nothing is written on another connection than `generation`: not_applied.
  Expected<double> write(ModbusLink& link, double value, std::uint64_t generation);

  /// Where the value taken is read; nullptr for a point that cannot be read back.
  const Point* readback() const { return has_readback_ ? &readback_ : nullptr; }
  const Point& point() const { return point_; }
  /// Writes that reached the bus, for registers that wear out.
  std::uint64_t writes() const { return writes_; }

 private:
  Expected<double> read_back(ModbusLink& link) const;
  LinkResult<void> send(ModbusLink& link, std::span<const std::uint16_t> words);
  bool same(double a, double b) const;

  Point point_, readback_;
  bool has_readback_ = false;
  double settle_s_;
  int function_;
  bool alternate_tried_ = false;
  double last_written_ = std::numeric_limits<double>::quiet_NaN();
  std::uint64_t last_generation_ = 0;
  std::uint64_t writes_ = 0;
};

}  // namespace airside::hal
