#pragma once
// How a controller begins: what a blob carries goes in, and the schedule days of the room's own log become its first
// memories. Daemon, simulation and training share this.

#include <cmath>
#include <limits>

#include "airside/controller/blob.hpp"
#include "airside/controller/controller.hpp"
#include "airside/learning/row_window.hpp"

namespace airside {

/// Feeds logged 6-min rows to a controller, in order of time, through a validator of its own: a log has the same
/// spikes, stuck sensors and gaps as the bus it was taken from.
template <Topology T, class Scalar = float>
class HistoryReader {
 public:
  enum class Head { leave, learn };
  /// From which rows a transition may start: any (spec OPEN-1), or those at which control decides.
  enum class Starts { every_row, every_cycle };

  HistoryReader(Controller<T, Scalar>& controller, Head head, Starts starts = Starts::every_row)
      : controller_(controller), head_(head), starts_(starts), validator_(controller.limits(), controller.settings()) {}

  /// One row: `setpoint_degc` was applied from `time` on. A row that may not be learned from breaks the window and
  /// nothing else.
  void row(CivilTime time, const typename Reading<T>::Vector& value, double setpoint_degc) {
    Reading<T> reading;
    reading.time = time;
    reading.value = value;
    const Expected<ValidReading<T>> valid = validator_.check(reading);
    const bool learnable = valid && valid->learnable();
    window_.push(time, value, learnable ? setpoint_degc : std::numeric_limits<double>::quiet_NaN());
    if (!learnable) {
      ++refused_;
      return;
    }
    if (!window_.has_transition() || (starts_ == Starts::every_cycle && !starts_cycle(time))) return;
    const auto& before = window_.at(rows_per_cycle);
    controller_.remember(before.value, before.setpoint_degc, value);
    ++transitions_;
    if (head_ == Head::leave || !window_.has_change_before()) return;
    const auto& earlier = window_.at(2 * rows_per_cycle);
    const Scaler<T>& scaler = controller_.learning().scaler;
    HeadFeatures f =
        RoomHead<T>::features({.before = earlier.value,
                               .recent = window_.at(rows_per_cycle + 1).value,
                               .now = before.value,
                               .setpoint_before_degc = earlier.setpoint_degc,
                               .last_move_k = earlier.setpoint_degc - window_.at(3 * rows_per_cycle).setpoint_degc},
                              scaler.scale(Layout<T>::power + T::powers - 1));
    f.x(HeadFeatures::setpoint_change) = before.setpoint_degc - earlier.setpoint_degc;
    const double moved = value.template head<T::vavs>().mean() - before.value.template head<T::vavs>().mean();
    // Where three rows share each cycle, each is worth a third of a sample.
    const double noise = starts_ == Starts::every_cycle ? 1.0 : std::sqrt(static_cast<double>(rows_per_cycle));
    controller_.remember_change(before.time, f, moved, noise);
  }
  int transitions() const { return transitions_; }
  int refused() const { return refused_; }

 private:
  Controller<T, Scalar>& controller_;
  Head head_;
  Starts starts_;
  RowWindow<T> window_;
  Validator<T> validator_;
  int transitions_ = 0;
  int refused_ = 0;
};

/// Puts a blob's head into the controller.
template <Topology T>
void take_head(Controller<T, float>& controller, const BlobPayload<T, NetworkWeights<T, float>::count>& payload) {
  if (payload.head_states == 0) return;
  RoomHead<T>& head = controller.learning().head;
  head.theta() = payload.head_theta;
  std::copy(payload.head_covariance.begin(), payload.head_covariance.end(), head.covariance().data());
  head.set_updates(payload.head_updates);
  head.complete_day_types(controller.settings());
}

/// Whether exchange_payload() would take the blob's head. The room's own stays once it has learned for a day: it knows
/// this room, the blob's another one or a twin.
template <Topology T>
bool wants_head(const Controller<T, float>& controller,
                const BlobPayload<T, NetworkWeights<T, float>::count>& payload) {
  return payload.head_states > 0 && controller.learning().head.updates() < cycles_per_day;
}

/// A blob's weights and scaler in place of those in use, and its head where wants_head().
template <Topology T>
void exchange_payload(Controller<T, float>& controller,
                      const BlobPayload<T, NetworkWeights<T, float>::count>& payload) {
  const bool head = wants_head<T>(controller, payload);
  controller.exchange(payload.scaler, payload.weights);
  if (head) take_head<T>(controller, payload);
}

/// Puts a blob's scaler, weights and head into the controller.
template <Topology T>
void take_payload(Controller<T, float>& controller, const BlobPayload<T, NetworkWeights<T, float>::count>& payload) {
  auto& learning = controller.learning();
  std::copy(payload.weights.begin(), payload.weights.end(), learning.weights.flat().begin());
  take_head<T>(controller, payload);
  controller.start(payload.scaler);
}

/// Fills a blob's payload with what the controller has learned.
template <Topology T>
void give_payload(const Controller<T, float>& controller, BlobPayload<T, NetworkWeights<T, float>::count>& payload) {
  const auto& learning = controller.learning();
  payload.scaler = learning.scaler;
  std::copy(learning.weights.flat().begin(), learning.weights.flat().end(), payload.weights.begin());
  using Head = RoomHead<T>;
  const bool two_types = day_types_of(controller.settings()) == 2;
  const int states = two_types ? Head::states : Head::regressors + Head::slots;
  payload.head_states = controller.settings().head != 0 ? static_cast<std::uint32_t>(states) : 0u;
  payload.head_updates = learning.head.updates();
  payload.head_theta = learning.head.theta();
  std::copy_n(learning.head.covariance().data(), payload.head_covariance.size(), payload.head_covariance.begin());
}

}  // namespace airside
