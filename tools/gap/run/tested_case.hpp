#pragma once
// A case judged with the days of the tests that were done on it.

#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "sim/effects/effect.hpp"
#include "tools/gap/verdict/rules.hpp"

namespace airside::tools::gap {

/// The verdict on all days, as airside gap next draws it: days with a test stand before the measured ones. With
/// `tests`, the names of those that were done, and `experiments` where some are proposed still. A log that cannot be
/// used is a refused verdict.  buildings: as GapRequest::buildings.  Errors: as load_case() and Engine::simulate.
/// Cost: as run_gap().
nlohmann::json judge_with_tests(const std::filesystem::path& folder, const std::vector<sim::Effect>& effects,
                                const std::filesystem::path& cache, int jobs, bool propose,
                                std::optional<int> buildings = 0);

}  // namespace airside::tools::gap
