#pragma once
// From logged 6-min rows to transitions of a control cycle. A transition counts only if the setpoint was constant over
// it: under the schedule almost every row starts one, under the agent one row a cycle (docs/method.md, open point 1).

#include <array>
#include <cmath>
#include <cstddef>

#include "airside/civil_time.hpp"
#include "airside/reading.hpp"
#include "airside/topology.hpp"

namespace airside {

/// The last rows: enough for one transition, the change that led to it, and the setpoint before that. Of n rows a
/// cycle, 2 n + 1 readings and 3 n + 1 setpoints.
template <Topology T>
class RowWindow {
 public:
  using Vector = typename Reading<T>::Vector;
  struct Row {
    CivilTime time;
    Vector value = Vector::Zero();
    double setpoint_degc = 0;  ///< applied from this row on
  };

  explicit RowWindow(ControlCycle cycle = {}) : rows_per_cycle_(cycle.rows) {}

  /// Adds the next row. A row that is not finite or does not follow at 6 min starts the window anew.
  void push(CivilTime time, const Vector& value, double setpoint_degc) {
    if (count_ > 0 && time.seconds - at(0).time.seconds != row_s) count_ = 0;
    if (!value.allFinite() || !std::isfinite(setpoint_degc)) {
      count_ = 0;
      return;
    }
    newest_ = (newest_ + 1) % readings;
    rows_[static_cast<std::size_t>(newest_)] = {time, value, setpoint_degc};
    newest_setpoint_ = (newest_setpoint_ + 1) % setpoints;
    setpoints_degc_[static_cast<std::size_t>(newest_setpoint_)] = setpoint_degc;
    if (count_ < size()) ++count_;
  }

  /// Row `back` rows before the newest, at most two cycles.
  const Row& at(int back) const { return rows_[static_cast<std::size_t>((newest_ + readings - back) % readings)]; }
  /// Its setpoint, at most three cycles back.
  double setpoint_degc(int back) const {
    return setpoints_degc_[static_cast<std::size_t>((newest_setpoint_ + setpoints - back) % setpoints)];
  }

  /// Whether at(n) -> at(0) is a transition: the setpoint stayed the same from row n up to the newest.
  bool has_transition() const { return count_ > rows_per_cycle_ && constant(rows_per_cycle_); }

  /// Whether the change at(2 n) -> at(n) led to it under one setpoint too: then a room head can learn from it.
  bool has_change_before() const { return count_ == size() && has_transition() && constant(2 * rows_per_cycle_); }

 private:
  static constexpr int readings = 2 * most_rows_per_cycle + 1, setpoints = 3 * most_rows_per_cycle + 1;

  int size() const { return 3 * rows_per_cycle_ + 1; }

  /// The n rows from `back` on hold one setpoint.
  bool constant(int back) const {
    for (int i = 1; i < rows_per_cycle_; ++i) {
      if (setpoint_degc(back - i) != setpoint_degc(back)) return false;
    }
    return true;
  }

  std::array<Row, static_cast<std::size_t>(readings)> rows_{};
  std::array<double, static_cast<std::size_t>(setpoints)> setpoints_degc_{};
  int rows_per_cycle_;
  int newest_ = readings - 1, newest_setpoint_ = setpoints - 1;
  int count_ = 0;
};

}  // namespace airside
