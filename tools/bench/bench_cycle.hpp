#pragma once
// Times whole cycles of the objective "band": decide and absorb, learning included.

#include <string>

#include "airside/network/kernels/kernels.hpp"
#include "tools/bench/stopwatch.hpp"

namespace airside::tools {

/// With 5, 12 and 32 boxes that modulate.
/// Errors: std::runtime_error where the objective does not act, so that its time would say nothing.
void measure_cycles(const Stopwatch& watch, const Kernels<float>& kernels, const std::string& prefix);

}  // namespace airside::tools
