#pragma once
// What the sensors of a site could show at all: the size from which each effect would stand out.

#include <string>
#include <vector>

#include "tools/gap/run/gap_run.hpp"

namespace airside::tools::gap {

/// An effect at a place. Sizes are magnitudes on the side on which it shows more.
struct Detectable {
  sim::EffectAt at;
  double size = 0;       ///< at which its expected 2 ln likelihood ratio is its limit; NaN: no sensor shows it
  double bound = 0;      ///< the largest that is physical on that side
  bool visible = false;  ///< size is within the bound
};

/// Of every candidate, in the library's order: responses are taken as linear, the noise is the reference's, weather and
/// commands are the measured period's. What was measured in it does not count.
///   size = null + (probe - null) sqrt(limit / z' M z)
std::vector<Detectable> detectable_sizes(const GapRun& run);

/// "not visible with these sensors: ...", "" where all are.
std::string invisible_text(const std::vector<Detectable>& sizes);

/// What is played of the record where a model controls its rooms itself, and what that costs.
std::string own_control_text(const Engine& engine);

}  // namespace airside::tools::gap
