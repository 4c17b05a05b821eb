#pragma once
// What a planned case hides, and how large: drawn by numbers alone, sized by the site's simulations.

#include <filesystem>
#include <vector>

#include "tools/gap/blind/blind_plan.hpp"

namespace airside::tools::gap {

/// Something hidden, and how far it shows.
struct Sized {
  Hidden hidden;
  Shown shown;
};

struct DrawnCase {
  std::vector<Sized> hidden;       ///< empty: nothing
  std::vector<Sized> not_reached;  ///< what was tried before: it cannot show so much, or never so little
};

/// What case i of the plan hides.  Thread-safe after site.prepare().
/// Errors: of the engine.  Cost: about five BlindSite::shown().
DrawnCase drawn_case(const BlindPlan& plan, const BlindSite& site, int i, const PlannedCase& c);

/// Writes the weather of all windows of a seed below `folder`, where weather_of_window() finds it.
/// Errors: hal::InputError if a file cannot be written.
void write_window_weather(const std::filesystem::path& folder, std::uint64_t seed);

/// What the sites of a plan are given, with the weather below `folder`.
BlindSetup setup_of(const BlindPlan& plan, const std::vector<sim::Effect>& effects,
                    const std::filesystem::path& folder);

}  // namespace airside::tools::gap
