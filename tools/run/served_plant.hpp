#pragma once
// A simulated room behind Modbus registers.

#include "hal/modbus/server.hpp"
#include "sim/plant_model.hpp"

namespace airside::tools {

/// In lockstep (`speed` 0) the plant moves only when a client asks by clock_advance_s; with a speed it runs N
/// times faster than the wall clock, until `end`.
class ServedPlant {
 public:
  /// model and server must outlive this.
  ServedPlant(sim::PlantModel& model, hal::ModbusServer& server, double speed, CivilTime end);

  /// Moves the plant as far as it may go now.
  void step();
  /// Puts into the registers of every point that the plant offers what its sensors show.
  void publish();
  bool ended() const { return model_.time() >= end_; }

 private:
  double write(const hal::Point& point, double value);

  sim::PlantModel& model_;
  hal::ModbusServer& server_;
  double speed_;
  CivilTime end_, began_;
  std::int64_t began_ns_;
  CivilTime wanted_;
};

}  // namespace airside::tools
