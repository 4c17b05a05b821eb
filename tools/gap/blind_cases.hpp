#pragma once
// Sealed cases: folders that the workflow may see, and a key that it may not.

#include <filesystem>
#include <functional>

#include "tools/gap/blind.hpp"

namespace airside::tools::gap {

/// How many of what.  Source: GAP.md, "Blind tests".
struct BlindPlan {
  int single = 0, null = 0, outside = 0, pairs = 0;
  std::uint64_t seed = 1;
  std::string twin = "301";  ///< the workflow's room; the measured ones differ from it
  int days = 14;             ///< of the reference, and of the measured period
  int jobs = 2;
  int total() const { return single + null + outside + pairs; }
};

/// 300 : 300 : 60 : 100, as near as `cases` allows.
BlindPlan plan_of(int cases, std::uint64_t seed);

/// Writes cases into `folder` and the key to `key`, which must not lie in it.
/// A hidden effect is as large as `ratio` times the noise in the channel that shows it most, within its bounds.
/// Errors: hal::InputError if the folder is not empty or cannot be written.
void make_blind_cases(const BlindPlan& plan, const std::vector<sim::Effect>& effects,
                      const std::filesystem::path& folder, const std::filesystem::path& key,
                      const std::function<void()>& done = {});

}  // namespace airside::tools::gap
