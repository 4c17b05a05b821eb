#pragma once
// Rooms that differ from an EnergyPlus twin as buildings differ from their models, to be replayed like it.

#include <cstdint>

#include "sim/energyplus/replay/replay.hpp"

namespace airside::sim {

/// The twin with other numbers, `share` times 10 to 20 %, and in other objects; boxes modulate where the seed is odd.
/// What a replay takes from the recording, as weather and commands, is as recorded.  Not for a model with controls of
/// its own, whose objects nobody knows.
/// Cost: a copy of the model.
EnergyPlusTwin differing_twin(EnergyPlusTwin twin, std::uint64_t seed, double share);

}  // namespace airside::sim
