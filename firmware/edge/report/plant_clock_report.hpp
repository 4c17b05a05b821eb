#pragma once
// What a plant's clock did beside steady progress, for log and status.

#include "hal/modbus/plant_clock.hpp"

namespace airside::edge {

class PlantClockReport {
 public:
  /// Once a row: a new jump is said, and shown by text() for a day of rows. One that flickers is said once.
  void row(const hal::ModbusPlantClock::Jumps& jumps);
  /// The clock is far behind the row that was waited for.
  static void set_back(CivilTime row, CivilTime clock);
  /// "ok", "read wrong" or "jumped".
  const char* text() const { return text_; }

 private:
  hal::ModbusPlantClock::Jumps said_;
  const char* text_ = "ok";
  int rows_left_ = 0;  ///< for which text_ is shown still
};

}  // namespace airside::edge
