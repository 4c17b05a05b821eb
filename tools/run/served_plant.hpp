#pragma once
// A simulated room behind Modbus registers.

#include "hal/modbus/server.hpp"
#include "sim/plant_model.hpp"
#include "tools/run/site.hpp"

namespace airside::tools {

/// In lockstep (`speed` 0) the plant moves only when a client asks by clock_advance_s; with a speed it runs N
/// times faster than the wall clock, until `end`.
class ServedPlant {
 public:
  /// site, model and server must outlive this.
  ServedPlant(const Site& site, sim::PlantModel& model, hal::ModbusServer& server, double speed, CivilTime end);

  /// Moves the plant as far as it may go now.
  void step();
  /// Puts into the registers what the sensors show.
  void publish();
  bool ended() const { return model_.time() >= end_; }

 private:
  double write(const hal::Point& point, double value);

  const Site& site_;
  sim::PlantModel& model_;
  hal::ModbusServer& server_;
  double speed_;
  CivilTime end_, began_;
  std::int64_t began_ns_;
  CivilTime wanted_;
};

}  // namespace airside::tools
