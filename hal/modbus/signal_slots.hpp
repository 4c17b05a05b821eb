#pragma once
// Which slots of a poller make up each signal: one, several sensors of a zone, or none and a stand-in.

#include <array>
#include <cstddef>
#include <vector>

#include "airside/fault.hpp"
#include "airside/signals.hpp"
#include "hal/modbus/poller.hpp"
#include "hal/points/point_map.hpp"

namespace airside::hal {

/// Signals in the order in which they were added.
class SignalSlots {
 public:
  /// Adds a signal and its points to `points`, whose positions are the poller's slots. A signal that the map lacks
  /// reads as its stand-in, NaN where it has none.
  void add(const PointMap& map, const StandIns& stand_ins, SignalId id, std::vector<Point>& points);

  /// The sensor's value; of several the median of those that are good, of two their mean. NaN where none is.
  /// Cost: no heap.
  double value(int index, const ModbusPoller& poller) const;
  /// Why value() is NaN: the fault of its first sensor.
  Fault fault(int index, const ModbusPoller& poller) const;

 private:
  struct Signal {
    int first_slot = -1, slots = 0;
    double stand_in = 0;  ///< where there is no slot
  };
  std::vector<Signal> signals_;
};

}  // namespace airside::hal
