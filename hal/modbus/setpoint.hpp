#pragma once
// Writes one point and finds out what the device made of it.

#include <limits>

#include "airside/fault.hpp"
#include "hal/modbus/link.hpp"
#include "hal/points/point_map.hpp"

namespace airside::hal {

/// What became of a write that a person asked for, and of putting the value before it back; NaN: not reached.
struct WriteCheck {
  static constexpr double not_reached = std::numeric_limits<double>::quiet_NaN();
  double before = not_reached, sent = not_reached, taken = not_reached, restored = not_reached;
  Fault fault = Fault::none;  ///< of the first step that went wrong
};

class ModbusSetpoint {
 public:
  /// `settle_s`: how long the read-back may lag behind the write, s; [0, 10].
  /// Errors: InputError where the map has no such writable point.
  ModbusSetpoint(const PointMap& map, std::string_view name, double settle_s = 0.0);

  /// Writes `value` unless the policy is on-change and the device already holds it, then reads back.
  /// A value is chosen one step from what the caller believes to stand there: what the last write() returned, or what
  /// saw() was called since. After neither, the register is read and returned and nothing is written; where it cannot
  /// be read, the last value that was sent is sent again in the place of `value`, so that each step begins at a known
  /// one. What stood there without having been sent is never sent: it may lie outside all limits, or be a person's.
  /// Nothing is written over a number outside the point's limits: it is another's, or the map has the wrong scale.
  /// Nothing is written on another connection than `generation`.
  /// Where the device refuses, the other function (6 or 16) is tried once, and kept where it works.
  /// Returns the value read back, or the rounded value where nothing can be read back.
  /// Errors: write_refused where the device answered with exception 1 to 4; out_of_range where the register shows a
  /// number outside the point's limits, before or after; not_applied for a value that the point
  /// cannot hold or that is outside its limits, a lost link, or a read-back that is no number.
  /// Cost: at most 4 exchanges and settle_s; no heap.
  Expected<double> write(ModbusLink& link, double value, std::uint64_t generation);
  /// Moves the current value `standing` by `step`, or by the register's resolution where that is more, and puts it
  /// back; upwards, or downwards where it would leave min or max. It must have been sent by write() of this run: no
  /// person's value, and none from before the start, is ever sent back.
  /// Errors: in the result: released where another's value is there, out_of_range where no step fits, else as write().
  /// Cost: two write().
  WriteCheck check(ModbusLink& link, double standing, double step, double min, double max, std::uint64_t generation);
  /// What a reading has shown to stand there; NaN where it did not.
  void saw(double standing);

  /// Where the value taken is read; nullptr for a point that cannot be read back.
  const Point* readback() const { return has_readback_ ? &readback_ : nullptr; }
  const Point& point() const { return point_; }
  /// Writes that reached the bus, for registers that wear out.
  std::uint64_t writes() const { return writes_; }

 private:
  Expected<double> try_to_write(ModbusLink& link, double value, std::uint64_t generation);
  Expected<double> read_back(ModbusLink& link) const;
  LinkResult<void> send(ModbusLink& link, std::span<const std::uint16_t> words, std::uint64_t generation);
  Expected<double> confirm(ModbusLink& link, double wish);
  bool same(double a, double b) const;

  Point point_, readback_;
  bool has_readback_ = false;
  double settle_s_;
  int function_;
  bool alternate_tried_ = false;
  double last_written_ = std::numeric_limits<double>::quiet_NaN();
  double sent_ = std::numeric_limits<double>::quiet_NaN();       ///< by write(), and stood there when last seen
  double unsettled_ = std::numeric_limits<double>::quiet_NaN();  ///< sent since, and nobody knows whether it was taken
  bool told_ = false;                                            ///< the last write() returned a value
  bool seen_ = false;                                            ///< the last saw() did
  std::uint64_t last_generation_ = 0;
  std::uint64_t writes_ = 0;
};

}  // namespace airside::hal
