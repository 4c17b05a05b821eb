#pragma once
// How much memory a controller takes, chosen for the whole build (AIRSIDE_SMALL_MEMORY). `full` is the box with an
// operating system; `small` fits the static RAM of one microcontroller (docs/porting.md, "Cortex-M7 without an
// operating system").

#include <cstddef>

namespace airside {

/// Of Eigen's vectors in saved state: Eigen's own choice follows the build's vectors, and a state must be read by the
/// builds of all architectures.
constexpr std::size_t state_alignment = 16;

#ifdef AIRSIDE_SMALL_MEMORY
constexpr int replay_capacity = 220;  ///< transitions kept: nearly three days of cycles
constexpr int max_batch = 128;        ///< samples of one optimiser step
constexpr int tile_samples = 8;       ///< samples that pass through the network together
constexpr int max_day_types = 1;      ///< daily profiles of the room head: none of its own for days off
constexpr int cached_targets = 0;     ///< slots of the replay whose bootstrap target is remembered
#else
constexpr int replay_capacity = 42 * 240;  ///< transitions kept (docs/method.md 5)
constexpr int max_batch = 1000;            ///< samples of one optimiser step
constexpr int tile_samples = 48;  ///< samples that pass through the network together: activations stay in cache
constexpr int max_day_types = 2;  ///< daily profiles of the room head
constexpr int cached_targets = replay_capacity;  ///< slots of the replay whose bootstrap target is remembered
#endif

}  // namespace airside
