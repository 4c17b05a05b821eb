#pragma once
// The ledger: what a controller costs in memory, and the budgets that the build refuses to exceed.

#include <array>
#include <cstddef>

#include "airside/controller/controller.hpp"
#include "airside/forecast/room_head.hpp"
#include "airside/learning/learning_state.hpp"
#include "airside/learning/replay_ring.hpp"
#include "airside/network/learner.hpp"
#include "airside/network/network.hpp"
#include "airside/network/scratch.hpp"
#include "airside/topology.hpp"

namespace airside {

struct FootprintEntry {
  const char* name;
  const char* what;
  std::size_t bytes;
  std::size_t budget_bytes;
};

/// One entry a part; the last is the whole controller.
template <Topology T>
constexpr auto footprint_ledger() {
  using C = Controller<T, float>;
  // Budgets follow the network's size; the constants are the method's room plus a tenth, and count again for each 32
  // inputs of a capacity class.
  constexpr std::size_t kb = 1024 * ((Layout<T>::inputs + 31) / 32);
  constexpr std::size_t net = sizeof(NetworkWeights<T, float>);
  return std::to_array<FootprintEntry>({
      {"weights", "network in use", net, 160 * kb},
      {"optimizer", "target network, Adam moments, step counter", sizeof(Learner<T, float>), 480 * kb},
      {"head", "room head: regressors, profile, covariance", sizeof(RoomHead<T>), 240 * kb},
      {"replay", "remembered transitions", sizeof(ReplayRing<T, float>), 3200 * kb},
      {"shadow", "network in training", net, 160 * kb},
      {"scratch", "activations of one tile, gradients, the network that runs, targets that are known",
       sizeof(NetworkScratch<T, float>), 1280 * kb},
      {"cycle", "validator, the last two readings, demand of boxes that modulate", sizeof(CycleState<T>), 16 * kb},
      {"controller", "everything above and the candidates", sizeof(C), 5120 * kb},
  });
}

/// Stack of one decision or learning step, bytes; checked by a test against -fstack-usage.
constexpr std::size_t stack_budget_bytes = 64 * 1024;

template <Topology T>
constexpr bool within_budget() {
  for (const FootprintEntry& e : footprint_ledger<T>()) {
    if (e.bytes > e.budget_bytes) return false;
  }
  return true;
}

}  // namespace airside
