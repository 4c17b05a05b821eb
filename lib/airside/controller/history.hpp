#pragma once
// The schedule days of the room's own log become a controller's first memories. Daemon, simulation and training share
// this.

#include <cmath>
#include <limits>

#include "airside/civil_time.hpp"
#include "airside/controller/controller.hpp"
#include "airside/controller/weight_payload.hpp"  // IWYU pragma: export
#include "airside/demand_settings.hpp"
#include "airside/fault.hpp"
#include "airside/forecast/head_features.hpp"
#include "airside/held_rooms.hpp"
#include "airside/learning/row_window.hpp"
#include "airside/network/scaler.hpp"
#include "airside/reading.hpp"
#include "airside/settings.hpp"
#include "airside/supervision/schedule.hpp"
#include "airside/supervision/validation.hpp"
#include "airside/topology.hpp"

namespace airside {

/// Whether anything learns from a history: weights do, and the objective "band" does without them.
constexpr bool uses_history(const ControllerSettings& s, bool has_weights) {
  return has_weights || s.objective == Objective::band;
}

/// Feeds logged 6-min rows to a controller, in order of time, through a validator of its own: a log has the same
/// spikes, stuck sensors and gaps as the bus it was taken from.
template <Topology T, class Scalar = float>
class HistoryReader {
 public:
  enum class Head { leave, learn };
  /// From which rows a transition may start: any (docs/method.md, open point 1), or those at which control decides.
  enum class Starts { every_row, every_cycle };

  HistoryReader(Controller<T, Scalar>& controller, Head head, Starts starts = Starts::every_row)
      : controller_(controller),
        head_(head),
        starts_(starts),
        window_(control_cycle(controller.settings())),
        validator_(controller.limits(), controller.settings()) {}

  /// One row of signals alone.
  void row(CivilTime time, const typename Reading<T>::Vector& value, double setpoint_degc) {
    Reading<T> reading;
    reading.time = time;
    reading.value = value;
    row(reading, setpoint_degc);
  }

  /// One row: `setpoint_degc` was applied from its time on. A row that may not be learned from, such as one of still
  /// air, breaks the window and nothing else. Where boxes modulate, the objective "band" learns from dampers, zone
  /// setpoints and meters.
  void row(const Reading<T>& reading, double setpoint_degc) {
    const CivilTime time = reading.time;
    const auto& value = reading.value;
    const bool flows = air_flows(controller_.settings(), time, reading.flows);
    const Expected<ValidReading<T>> valid = validator_.check(reading, time, flows);
    const bool learnable = valid && valid->learnable() && flows;
    if (valid && controller_.settings().objective == Objective::band) {
      Reading<T> sensed = reading;
      if (!std::isfinite(sensed.supply_temp_degc)) sensed.supply_temp_degc = setpoint_degc;
      controller_.remember_demand(sensed, *valid, learnable);
      ++demand_rows_;
      if (controller_.cycle().has_weights == 0) return;  // nothing else has a part in this objective
    }
    if (!learnable) {
      window_.push(time, value, std::numeric_limits<double>::quiet_NaN());
      ++refused_;
      return;
    }
    const ControlCycle cycle = control_cycle(controller_.settings());
    const auto& now = valid->value();  // as sensed, stand-ins filled in
    window_.push(time, now, setpoint_degc);
    if (!window_.has_transition() || (starts_ == Starts::every_cycle && !cycle.starts(time))) return;
    const auto& before = window_.at(cycle.rows);
    controller_.remember(before.value, before.setpoint_degc, now);
    ++transitions_;
    if (head_ == Head::leave || !window_.has_change_before()) return;
    const auto& earlier = window_.at(2 * cycle.rows);
    const Scaler<T>& scaler = controller_.learning().scaler;
    const Shape site = controller_.settings().shape;
    HeadFeatures f = head_features<T>({.before = earlier.value,
                                       .recent = window_.at(cycle.rows + 1).value,
                                       .now = before.value,
                                       .setpoint_before_degc = earlier.setpoint_degc,
                                       .last_move_k = earlier.setpoint_degc - window_.setpoint_degc(3 * cycle.rows),
                                       .held = controller_.settings().held},
                                      site, scaler.head_power_scale(site));
    f.x(HeadFeatures::setpoint_change) = before.setpoint_degc - earlier.setpoint_degc;
    const HeldRooms& held = controller_.settings().held;
    const double moved = held_after_degc<T>(held, site, before.value, now) - held_degc<T>(held, site, before.value);
    // Rows that share a cycle are worth one sample together.
    const double noise = starts_ == Starts::every_cycle ? 1.0 : std::sqrt(static_cast<double>(cycle.rows));
    const double error_k = controller_.remember_change(before.time, f, moved, noise);
    if (!std::isfinite(error_k)) return;
    ++forecasts_;
    error_sum_k2_ += error_k * error_k;
  }
  /// Root mean square error of the head's forecasts one cycle ahead, each made before its row was learned, K; NaN if
  /// there was none.
  double forecast_error_k() const { return std::sqrt(error_sum_k2_ / forecasts_); }
  int transitions() const { return transitions_; }
  int refused() const { return refused_; }
  /// Rows that the objective "band" was shown.
  int demand_rows() const { return demand_rows_; }

 private:
  Controller<T, Scalar>& controller_;
  Head head_;
  Starts starts_;
  RowWindow<T> window_;
  Validator<T> validator_;
  int transitions_ = 0;
  int refused_ = 0;
  int demand_rows_ = 0;
  int forecasts_ = 0;
  double error_sum_k2_ = 0;
};

}  // namespace airside
