#pragma once
// Whether the clock that rows are begun by can be right.

#include "airside/civil_time.hpp"
#include "airside/supervision/monitors.hpp"

namespace airside::edge {

class ClockReport {
 public:
  /// `newest_row`: the latest row of the state, 0 without. `is_simulated`: the clock is the plant's, which may live in
  /// any year.
  void begin(CivilTime newest_row, bool is_simulated);

  /// Whether a clock that shows t can be right. One before this program was written, or a day before the last row, has
  /// not been set since power came back; a clock that was ahead and is right now is believed after a day.
  bool is_set(CivilTime t);

 private:
  CivilTime newest_row_;  ///< the latest that a clock which can be right has shown
  bool is_simulated_ = false;
  PersistentCondition is_behind_;
};

}  // namespace airside::edge
