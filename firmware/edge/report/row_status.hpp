#pragma once
// The status of a row, as far as controller, AHU and link know it.

#include "airside/controller/instances.hpp"
#include "firmware/edge/report/status_snapshot.hpp"
#include "hal/modbus/plant.hpp"

namespace airside::edge {

/// `sensed` and `controller` must outlive the snapshot. Cost: no heap.
template <Topology T>
StatusSnapshot row_status(CivilTime t, const Expected<Reading<T>>& sensed, const Controller<T>& controller,
                          const hal::ModbusPlant<T>& plant);

}  // namespace airside::edge
