#pragma once
// Which case of a blind plan is what: by nothing but numbers, so that any case can be made alone.

#include <string>
#include <vector>

#include "tools/gap/blind/blind_cases.hpp"
#include "tools/gap/blind/blind_site.hpp"

namespace airside::tools::gap {

constexpr int blind_windows = 5;
/// Kinds of draws.
enum CaseDraw : std::uint64_t { draw_effect = 810, draw_place, draw_second, draw_magnitude, draw_name, draw_sign };

/// First midnight of a window, 0 ..
CivilTime start_of_window(int window);

/// A case before anything is simulated: its set, its window, and which turn of its set on its engine it is.
struct PlannedCase {
  std::string set;
  bool energyplus = false;
  BlindWindow window;
  double ratio = 0;
  int turn = 0;
};

PlannedCase planned_case(const BlindPlan& plan, int i);

/// Of a case's room, people and noise.
std::uint64_t seed_of_case(std::uint64_t plan_seed, int i);

/// The weather of a window, 0 .., of the cases in a folder.
std::filesystem::path weather_of_window(const std::filesystem::path& folder, int window);

/// Case numbers in the order of their names, which says nothing: cases of one set do not stand together.
std::vector<int> in_order_of_name(std::uint64_t plan_seed, int total);

}  // namespace airside::tools::gap
