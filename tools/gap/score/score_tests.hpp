#pragma once
// What executed tests on site add to the verdicts.

#include <string>
#include <vector>

#include "tools/gap/score/score.hpp"
#include "tools/gap/score/score_cases.hpp"

namespace airside::tools::gap {

/// The measures of the sets again, of the verdicts after at most N executed tests, and which tests were done. Nothing
/// where no case was tested.
void count_after_tests(ScoreTable& table, const std::vector<ScoredCase>& cases);

/// For people, "" where no case was tested: exact without and with tests beside each other, and the tests that were
/// done.
std::string tests_text(const ScoreTable& table);

/// As docs/formats.md says.
nlohmann::json tests_json(const ScoreTable& table);

}  // namespace airside::tools::gap
