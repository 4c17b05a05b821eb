#include "tools/gap/score/score.hpp"

#include "hal/text/input_error.hpp"
#include "tools/gap/score/score_measures.hpp"
#include "tools/gap/score/score_tests.hpp"

namespace airside::tools::gap {

namespace {

void describe_sets(ScoreTable& table, const std::vector<ScoredCase>& cases) {
  static const std::map<std::string, int> planned{{"single", 300}, {"null", 300}, {"real_null", 30},
                                                  {"outside", 60}, {"pair", 100}, {"real", 1}};
  std::vector<std::string> silent, refused;
  for (const char* set : set_names) {
    SetFacts facts;
    facts.set = set;
    facts.planned = planned.at(set);
    for (const ScoredCase* c : of_set(cases, set)) {
      ++facts.cases;
      if (!c->answered) {
        ++facts.unanswered;
        silent.push_back(c->id);
      }
      if (c->answered && c->kind == SaidKind::refused) {
        ++facts.refused;
        refused.push_back(c->id);
      }
      if (c->engine != "energyplus") continue;
      ++facts.energyplus;
      if (c->feedback && *c->feedback) ++facts.energyplus_feedback;
    }
    table.sets.push_back(facts);
  }
  warn(table, silent, "without verdict, counted as abstained");
  warn(table, refused, "refused for what is wrong with the logs, counted as abstained");
}

std::vector<ScoredCase> all_cases(const std::vector<JudgedCases>& drawings,
                                  const std::map<std::string, double>& null_of) {
  if (drawings.size() == 1) return read_cases(drawings.front().verdicts, drawings.front().key, null_of);
  std::vector<ScoredCase> all;
  for (std::size_t i = 0; i < drawings.size(); ++i) {
    const std::string number = std::to_string(i + 1);
    try {
      for (ScoredCase& one : read_cases(drawings[i].verdicts, drawings[i].key, null_of)) {
        one.id = number + "/" + one.id;
        all.push_back(std::move(one));
      }
    } catch (const hal::InputError& error) {
      throw hal::InputError("drawing " + number + ": " + error.place(), error.found(), error.expected(),
                            error.remedy());
    }
  }
  return all;
}

}  // namespace

ScoreTable score(const nlohmann::json& verdicts, const nlohmann::json& key,
                 const std::map<std::string, double>& null_of) {
  return score({{verdicts, key}}, null_of);
}

ScoreTable score(const std::vector<JudgedCases>& drawings, const std::map<std::string, double>& null_of) {
  const std::vector<ScoredCase> cases = all_cases(drawings, null_of);
  ScoreTable table;
  describe_sets(table, cases);
  count_sets(table, cases);
  count_after_tests(table, cases);
  measure_shrink(table, cases);
  measure_magnitudes(table, cases, null_of);
  measure_posteriors(table, cases);
  const auto below_1 = [](const ScoredCase& c) {
    return (c.set == "single" || c.set == "outside") && c.ratio && *c.ratio < 1;
  };
  table.confusion = confusion_of(cases, [&](const ScoredCase& c) { return !below_1(c); });
  table.confusion_below_1 = confusion_of(cases, below_1);
  return table;
}

}  // namespace airside::tools::gap
