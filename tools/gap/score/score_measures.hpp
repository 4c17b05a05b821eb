#pragma once
// What is counted and measured over the cases of a blind test.

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "tools/gap/score/score.hpp"
#include "tools/gap/score/score_cases.hpp"

namespace airside::tools::gap {

/// "3 cases <what>: a, b, c", with at most eight of them; nothing for none.
void warn(ScoreTable& table, const std::vector<std::string>& ids, const std::string& what);

/// Shares of every set, in all and in parts.
void count_sets(ScoreTable& table, const std::vector<ScoredCase>& cases);
/// How far what was named closes the gap on locked days.
void measure_shrink(ScoreTable& table, const std::vector<ScoredCase>& cases);
/// How far magnitudes of right names are off.
void measure_magnitudes(ScoreTable& table, const std::vector<ScoredCase>& cases,
                        const std::map<std::string, double>& null_of);
/// How often the smallest sets of 90 % hold the truth, how large they are, and how often what is said comes true.
void measure_posteriors(ScoreTable& table, const std::vector<ScoredCase>& cases);
/// Cases for which `takes` holds, but no pairs.
Confusion confusion_of(const std::vector<ScoredCase>& cases, const std::function<bool(const ScoredCase&)>& takes);

}  // namespace airside::tools::gap
