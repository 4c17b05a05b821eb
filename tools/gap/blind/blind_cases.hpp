#pragma once
// Sealed cases: folders that the workflow may see, and a key that it may not.

#include <filesystem>
#include <functional>

#include "tools/gap/blind/blind.hpp"

namespace airside::tools::gap {

/// What measures. The workflow's engine is of the same kind, with other objects and other numbers.
enum class BlindEngine {
  rc,
  energyplus,
  mixed,  ///< every fourth case of each set by EnergyPlus, the rest RC rooms of another structure
};

/// How many of what.  Source: docs/gap-figures.md, "Blind tests".
struct BlindPlan {
  int single = 0, null = 0, outside = 0, pairs = 0;
  std::uint64_t seed = 1;
  std::string twin = "301";  ///< the workflow's room; the measured ones differ from it
  int days = 14;             ///< of the reference, and of the measured period
  int jobs = 2;
  BlindEngine engine = BlindEngine::rc;
  int window = 0;                       ///< all cases in this one, 1 ..; 0: in all by turns
  double ratio = 0;                     ///< of single effects; 0: 0.5, 1 and 3 by turns
  std::vector<std::string> kinds = {};  ///< effects that are hidden, by turns; empty: all
  bool rough = false;           ///< sizes by a table of noise instead of fits to reference periods: quick, not exact
  std::filesystem::path cache;  ///< of finished EnergyPlus runs; empty: none
  int total() const { return single + null + outside + pairs; }
};

/// 300 : 300 : 60 : 100, as near as `cases` allows.
BlindPlan plan_of(int cases, std::uint64_t seed);

/// How often make_blind_cases() calls done(): for each case, and for each window that cases share.
int blind_steps(const BlindPlan& plan);

/// Writes cases into `folder` and the key to `key`, which must not lie in it.
/// A hidden effect is as large as `ratio` times the noise in the channel that shows it most, within its bounds; noise:
/// the standard deviation of what remains of a reference period after the workflow's own fit; on RC the median of five
/// rooms.
/// Names, order and times of the files say nothing of what they hold. The same plan gives the same bytes.
/// Errors: hal::InputError if the folder is not empty or cannot be written, or the engine is not there.
/// Cost: an RC case 1 s and a window 100 s; an EnergyPlus case 10 s and a window 10 s, and 5 min for each way of
/// control; on one core.
void make_blind_cases(const BlindPlan& plan, const std::vector<sim::Effect>& effects,
                      const std::filesystem::path& folder, const std::filesystem::path& key,
                      const std::function<void()>& done = {});

/// When a file was written would tell how long its effect took to hide.
void forget_time(const std::filesystem::path& path);

}  // namespace airside::tools::gap
