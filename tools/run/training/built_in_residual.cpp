#include "tools/run/training/built_in_residual.hpp"

#include <array>
#include <cstddef>

namespace airside::tools {

ResidualNetwork built_in_residual() {
  static constexpr std::array<float, std::size_t{ResidualNetwork::parameters}> numbers{
#include "tools/run/training/built_in_residual.inc"
  };
  ResidualNetwork network;
  network.take(numbers);
  return network;
}

}  // namespace airside::tools
