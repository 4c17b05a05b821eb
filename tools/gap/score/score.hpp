#pragma once
// How good the verdicts of the blind tests are: verdicts and answer key in, shares with their uncertainty beside the
// targets out. Nothing here knows how a verdict came about. Both formats are in docs/formats.md.

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "tools/gap/score/wilson.hpp"

namespace airside::tools::gap {

/// What a share or a median must reach. Source: docs/gap-figures.md, "Blind tests".
struct Target {
  double value = 0;
  bool at_least = true;  ///< false: at most
  bool holds(double figure) const { return at_least ? figure >= value : figure <= value; }
};

/// k of n cases.
struct CountRow {
  std::string set;      ///< of the key; "named": verdicts of all sets that name; "right names": of these the right ones
  std::string measure;  ///< score() lists them
  std::string slice;    ///< "all", "ratio 0.5", "ratio >= 1", "ratio >= 1, engine rc", "all, feedback on", ..
  int k = 0, n = 0;
  std::optional<Target> target;
  double share() const { return n > 0 ? static_cast<double>(k) / n : 0; }
  ShareInterval interval() const { return wilson_95(k, n); }
};

/// Quartiles of n values, linear between neighbours; 0 for none.
struct SpreadRow {
  std::string set, measure, slice;
  int n = 0;
  double quartile_1 = 0, median = 0, quartile_3 = 0;
  std::optional<Target> target;  ///< of the median
};

/// Cases by what was hidden and what was said; effects without their place.
/// Shape: counts hidden.size() x said.size(); right one a row.
struct Confusion {
  std::vector<std::string> hidden;  ///< "vav_flow", "fcu_dial (outside)", "nothing", ..
  std::vector<std::string> right;   ///< the column that is right for the row: its effect, "unknown" or "none"
  /// Effects, then "ambiguous", "unknown", "none" and, where they happened, "refused" and "no verdict".
  std::vector<std::string> said;
  std::vector<std::vector<int>> counts;
};

/// What a set is made of. Planned: docs/gap-figures.md, "Blind tests"; 0 where it has none.
struct SetFacts {
  std::string set;
  int cases = 0, planned = 0;
  int energyplus = 0;           ///< measured by EnergyPlus
  int energyplus_feedback = 0;  ///< of these with feedback on
  int unanswered = 0;
  int refused = 0;  ///< their logs could not be used
};

/// A test on site, the last of those that were done in a case.
struct TestFacts {
  std::string test;
  int cases = 0;                ///< of single effects in which it was the last
  int before = 0, exact = 0;    ///< of these named exactly without any test, and with it
  int in_class = 0, wrong = 0;  ///< with it: named or ambiguous with the truth; named without
};

/// Likeliest explanations whose probability is above `low` and not above `high`.
struct ReliabilityBin {
  double low = 0, high = 1;
  int n = 0, came = 0;  ///< came: it was the truth
  double said = 0;      ///< mean probability
};

/// How honest posteriors are: of cases that have one, one a finding.
struct PosteriorFacts {
  int single = 0;  ///< posteriors of single cases of ratio >= 1
  double set_size_quartile_1 = 0, set_size_median = 0, set_size_quartile_3 = 0;  ///< of these
  std::vector<ReliabilityBin> reliability;  ///< all sets, without single cases of ratio < 1
};

struct ScoreTable {
  std::vector<SetFacts> sets;
  std::vector<TestFacts> tests;
  std::vector<CountRow> counts;
  std::vector<SpreadRow> spreads;
  PosteriorFacts posteriors;
  Confusion confusion;          ///< single, outside, null and real cases, without those below
  Confusion confusion_below_1;  ///< single and outside cases of ratio < 1
  std::vector<std::string> warnings;
};

/// Holds the verdicts against the key. An effect is right if its id, place included, is hidden; it covers what is
/// hidden if that is right or in its class.
/// single, real: "exact": named, one of the effects right; "class": named or ambiguous, one of the effects covers;
///   "top 2": that, or among the first two of the ranking; "wrong name": named, no effect covers; "wrong place": of
///   these the ones with the right effect elsewhere; "extra name": named and covered, but another effect covers
///   nothing; "abstained": not named. Exact and class are not touched by extra names.
/// real also: "first by 5 x": the first effect right with a margin of 5 or more; "locked <= 0.40 K": temperatures
/// after. null, real_null: "named". outside: "unknown"; "wrong name": named. pair: "both", "at least one": named and
/// right; "both in class", "one in class": covered by different effects, named
///   or ambiguous; "extra name": named, an effect covers neither.
/// named: "gap closed" = 1 - (after - floor)/(before - floor) within -1 .. 1, left out where before <= floor;
///   "closed to a right model": the same, with what such a model would leave as floor, where verdicts have it;
///   "harm": after > before. An after that is not finite harms and closes -1.
/// Where tests on site were done: each measure of single, null, outside and pair again as "<measure>, N tests", of the
/// verdicts after at most N executed tests, a case without any counting by its first.
/// right names: "magnitude error" = |m - m_true| / |m_true - null|; "interval covers".
/// Every set, where verdicts have posteriors: "90 % set": it holds what is hidden and not among the other findings;
///   "other" outside, "nothing" where nothing is left; of a case with several posteriors, each of its sets does.
/// A case without verdict, or whose logs were refused, is abstained, with a warning.
/// `null_of`: the magnitude at which nothing is changed, one an effect of the library.
/// Errors: hal::InputError that names the field ("verdicts[3].effects[0].id", "cases.case-0001.set"): missing, of the
///   wrong type, an effect that null_of does not have, two verdicts for one case, a case that the key does not have, a
///   number of hidden effects that does not fit the set, a hidden magnitude that changes nothing.
ScoreTable score(const nlohmann::json& verdicts, const nlohmann::json& key,
                 const std::map<std::string, double>& null_of);

/// What was said of one drawing, and its answers.
struct JudgedCases {
  nlohmann::json verdicts, key;
};

/// The same of several drawings together; cases of the second drawing are named "2/case-0001". Errors: as above, with
/// the drawing's number before the field where there are several; none at all.
ScoreTable score(const std::vector<JudgedCases>& drawings, const std::map<std::string, double>& null_of);

/// Everything, as docs/formats.md says.
nlohmann::json json_of(const ScoreTable& table);

/// For people: what was tested, targets, slices, spreads, the most frequent confusions, warnings. UTF-8, 120 columns.
std::string text_of(const ScoreTable& table);

}  // namespace airside::tools::gap
