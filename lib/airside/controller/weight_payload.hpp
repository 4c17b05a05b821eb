#pragma once
// A blob's content goes into a controller, and comes out of it.

#include <algorithm>
#include <cstdint>

#include "airside/controller/blob.hpp"
#include "airside/controller/controller.hpp"
#include "airside/forecast/room_head.hpp"
#include "airside/network/network.hpp"
#include "airside/settings.hpp"
#include "airside/topology.hpp"

namespace airside {

/// What a blob carries for the controller of a topology.
template <Topology T>
using WeightPayload = BlobPayload<T, NetworkWeights<T, float>::count>;

/// Puts a blob's head into the controller.
template <Topology T>
void take_head(Controller<T, float>& controller, const WeightPayload<T>& payload) {
  if (payload.head_states == 0) return;
  controller.take_head(payload.head_theta, payload.head_covariance, payload.head_updates);
}

/// Whether exchange_payload() would take the blob's head. The room's own stays once it has learned for a day: it knows
/// this room, the blob's another one or a twin.
template <Topology T>
bool wants_head(const Controller<T, float>& controller, const WeightPayload<T>& payload) {
  const auto day = static_cast<std::uint32_t>(control_cycle(controller.settings()).per_day());
  return payload.head_states > 0 && controller.learning().head.updates() < day;
}

/// A blob's weights and scaler in place of those in use, its head where wants_head(), its residual network where it has
/// one.
template <Topology T>
void exchange_payload(Controller<T, float>& controller, const WeightPayload<T>& payload) {
  const bool head = wants_head<T>(controller, payload);
  if (payload.residual.is_trained != 0) controller.take_residual(payload.residual);
  controller.exchange(payload.scaler, payload.weights);
  if (head) take_head<T>(controller, payload);
}

/// Puts a blob's scaler, weights, head and residual network into the controller.
template <Topology T>
void take_payload(Controller<T, float>& controller, const WeightPayload<T>& payload) {
  take_head<T>(controller, payload);
  controller.take_residual(payload.residual);
  controller.start(payload.scaler, payload.weights);
}

/// Fills a blob's payload with what the controller has learned.
template <Topology T>
void give_payload(const Controller<T, float>& controller, WeightPayload<T>& payload) {
  const auto& learning = controller.learning();
  payload.site = controller.settings().shape;
  payload.cycle = control_cycle(controller.settings());
  payload.scaler = learning.scaler;
  std::copy(learning.weights.flat().begin(), learning.weights.flat().end(), payload.weights.begin());
  using Head = RoomHead<T>;
  // Days off of another room say little of this one's: they travel where somebody asked for them, else the blob is
  // 86 kB smaller and complete_day_types() begins them anew.
  const ControllerSettings& s = controller.settings();
  const bool two_types = day_types_of(s) == 2 && (s.head_day_types == 2 || s.weekday_only != 0);
  const int states = two_types ? Head::states : Head::regressors + Head::slots;
  payload.head_states = s.head != 0 ? static_cast<std::uint32_t>(states) : 0u;
  payload.residual = learning.residual.network;
  payload.head_updates = learning.head.updates();
  payload.head_theta = learning.head.theta();
  std::copy_n(learning.head.covariance().data(), payload.head_covariance.size(), payload.head_covariance.begin());
}

}  // namespace airside
