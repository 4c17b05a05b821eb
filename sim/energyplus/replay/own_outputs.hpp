#pragma once
// Which of the engine's outputs shows each channel of a model that controls its rooms itself.

#include <string>
#include <vector>

#include "sim/energyplus/replay/replay.hpp"

namespace airside::sim {

/// One channel; the value of the step that ends at a row's time.
struct ChannelOutput {
  enum class Kind { variable, meter, runs };  ///< runs: 1 while the variable is above 1 W
  int column = 0;
  std::string key, variable;  ///< of a meter `key` alone
  Kind kind = Kind::variable;
  double factor = 1, offset = 0;  ///< of what the engine says
  /// As the engine's file of results names it.
  std::string series() const { return kind == Kind::meter ? key : key + "," + variable; }
};

/// The channels that the model shows; others of channels_of(twin) are never known. `twin.own` must be set.
std::vector<ChannelOutput> own_outputs(const EnergyPlusTwin& twin);

}  // namespace airside::sim
