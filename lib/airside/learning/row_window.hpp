#pragma once
// From logged 6-min rows to 18-min transitions. A transition counts only if the setpoint was constant over it: under
// the schedule almost every row starts one, under the agent every third (docs/method.md, open point 1).

#include <array>
#include <cmath>
#include <cstddef>

#include "airside/civil_time.hpp"
#include "airside/reading.hpp"
#include "airside/topology.hpp"

namespace airside {

/// The last ten rows: enough for one transition, the change that led to it, and the setpoint before that.
template <Topology T>
class RowWindow {
 public:
  using Vector = typename Reading<T>::Vector;
  struct Row {
    CivilTime time;
    Vector value = Vector::Zero();
    double setpoint_degc = 0;  ///< applied from this row on
  };

  /// Adds the next row. A row that is not finite or does not follow at 6 min starts the window anew.
  void push(CivilTime time, const Vector& value, double setpoint_degc) {
    if (count_ > 0 && time.seconds - at(0).time.seconds != row_s) count_ = 0;
    if (!value.allFinite() || !std::isfinite(setpoint_degc)) {
      count_ = 0;
      return;
    }
    newest_ = (newest_ + 1) % size;
    rows_[static_cast<std::size_t>(newest_)] = {time, value, setpoint_degc};
    if (count_ < size) ++count_;
  }

  /// Row `back` rows before the newest.
  const Row& at(int back) const { return rows_[static_cast<std::size_t>((newest_ + size - back) % size)]; }

  /// Whether at(3) -> at(0) is a transition: the setpoint stayed the same from row 3 up to the newest.
  bool has_transition() const { return count_ > rows_per_cycle && constant(rows_per_cycle); }

  /// Whether the change at(6) -> at(3) led to it under one setpoint too: then a room head can learn from it.
  bool has_change_before() const { return count_ == size && has_transition() && constant(2 * rows_per_cycle); }

 private:
  static constexpr int size = 3 * rows_per_cycle + 1;

  /// Rows back .. back-2 hold one setpoint.
  bool constant(int back) const {
    const double a = at(back).setpoint_degc;
    return at(back - 1).setpoint_degc == a && at(back - 2).setpoint_degc == a;
  }

  std::array<Row, static_cast<std::size_t>(size)> rows_{};
  int newest_ = size - 1;
  int count_ = 0;
};

}  // namespace airside
