// Verdicts written by hand, with answers counted by hand.

#include "tools/gap/score/score.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <stdexcept>

#include "hal/text/input_error.hpp"
#include "tools/gap/report/confusion_svg.hpp"

namespace airside::tools::gap {
namespace {

using Json = nlohmann::json;

const std::map<std::string, double> null_of{{"vav_flow", 1},  {"vav_stuck", 0},   {"solar_gain", 1},
                                            {"gain_base", 0}, {"clock_shift", 0}, {"infiltration", 1}};

Json effect(const std::string& id, double magnitude = 0.5, const std::vector<std::string>& class_ids = {}) {
  return {{"id", id}, {"magnitude", magnitude}, {"class", class_ids}};
}

/// {x} would be x itself, not a list of it.
Json list(std::initializer_list<Json> entries) { return entries; }

/// A key and the verdicts on it, case by case.
struct Blind {
  Json key = {{"format", 1}, {"seed", 7}, {"cases", Json::object()}};
  Json verdicts = {{"format", 1}, {"verdicts", Json::array()}};

  Json& add(const std::string& set, const Json& hidden, const Json& facts, const std::string& verdict,
            const Json& effects = Json::array(), const Json& ranking = Json::array()) {
    const std::string id = "case-" + std::to_string(key["cases"].size() + 1);
    key["cases"][id] = {{"set", set}, {"engine", "rc"}, {"hidden", hidden}};
    if (!facts.is_null()) key["cases"][id].update(facts);
    verdicts["verdicts"].push_back({{"case", id}, {"verdict", verdict}, {"effects", effects}, {"ranking", ranking}});
    return verdicts["verdicts"].back();
  }
  Json& single(double ratio, const std::string& verdict, const Json& effects = Json::array(),
               const Json& ranking = Json::array()) {
    return add("single", list({effect("vav_flow@3", 0.7)}), {{"ratio", ratio}}, verdict, effects, ranking);
  }
  ScoreTable table() const { return score(verdicts, key, null_of); }
};

template <class Rows>
const auto& row_of(const Rows& rows, const std::string& set, const std::string& measure, const std::string& slice) {
  for (const auto& row : rows) {
    if (row.set == set && row.measure == measure && row.slice == slice) return row;
  }
  throw std::logic_error("no row " + set + ", " + measure + ", " + slice);
}

/// "k/n".
std::string count(const ScoreTable& table, const std::string& set, const std::string& measure,
                  const std::string& slice = "all") {
  const CountRow& row = row_of(table.counts, set, measure, slice);
  return std::to_string(row.k) + "/" + std::to_string(row.n);
}

std::string complaint(const Blind& blind) {
  try {
    blind.table();
  } catch (const hal::InputError& error) {
    return error.what();
  }
  return "no complaint";
}

TEST(Wilson, GivesTheTextbooksIntervals) {
  EXPECT_NEAR(wilson_95(0, 30).low, 0, 1e-12);
  EXPECT_NEAR(wilson_95(0, 30).high, 0.1135, 5e-5);
  EXPECT_NEAR(wilson_95(15, 20).low, 0.531, 5e-4);
  EXPECT_NEAR(wilson_95(15, 20).high, 0.888, 5e-4);
  EXPECT_NEAR(wilson_95(81, 263).low, 0.2553, 5e-5);  // Newcombe 1998, table I
  EXPECT_NEAR(wilson_95(81, 263).high, 0.3662, 5e-5);
  EXPECT_NEAR(wilson_95(20, 20).high, 1, 1e-12);
  EXPECT_EQ(wilson_95(0, 0).low, 0);
  EXPECT_EQ(wilson_95(0, 0).high, 1);
}

/// One case of every kind of answer to a single effect, at ratio 1.
Blind every_answer() {
  Blind b;
  b.single(1, "named", list({effect("vav_flow@3")}), {"vav_flow@3"});
  b.single(1, "named", list({effect("vav_stuck@3", 0.5, {"vav_flow@3"})}), {"vav_stuck@3", "vav_flow@3"});
  b.single(1, "ambiguous", list({effect("vav_stuck@3", 0.5, {"vav_flow@3"})}));
  b.single(1, "ambiguous", list({effect("gain_base")}), {"gain_base", "vav_flow@3"});
  b.single(1, "ambiguous", list({effect("gain_base")}), {"gain_base", "infiltration", "vav_flow@3"});
  b.single(1, "named", list({effect("vav_flow@2")}), {"vav_flow@2", "gain_base"});
  b.single(1, "named", list({effect("gain_base")}), {"gain_base"});
  b.single(1, "unknown", Json::array(), {"vav_flow@3"});
  b.single(1, "none");
  b.single(1, "named", list({effect("vav_flow@3"), effect("gain_base")}));
  return b;
}

TEST(Score, TellsRightClassWrongPlaceWrongAndAbstainedApart) {
  const ScoreTable table = every_answer().table();
  for (const char* slice : {"all", "ratio 1", "ratio >= 1"}) {
    EXPECT_EQ(count(table, "single", "exact", slice), "2/10");
    EXPECT_EQ(count(table, "single", "class", slice), "4/10");
    EXPECT_EQ(count(table, "single", "top 2", slice), "6/10");
    EXPECT_EQ(count(table, "single", "wrong name", slice), "2/10");
    EXPECT_EQ(count(table, "single", "wrong place", slice), "1/10");
    EXPECT_EQ(count(table, "single", "extra name", slice), "1/10");
    EXPECT_EQ(count(table, "single", "abstained", slice), "5/10");
  }
}

TEST(Score, CountsAnEffectThatWasOnlyGuessedInNoVerdictAsNothing) {
  Blind b;
  b.single(1, "unknown", list({effect("vav_flow@3")}));
  b.single(1, "none", list({effect("vav_flow@3")}));
  const ScoreTable table = b.table();
  EXPECT_EQ(count(table, "single", "exact"), "0/2");
  EXPECT_EQ(count(table, "single", "class"), "0/2");
  EXPECT_EQ(count(table, "single", "abstained"), "2/2");
}

TEST(Score, SplitsByRatioEngineFeedbackAndWorkflow) {
  Blind b;
  const Json hidden = list({effect("vav_flow@3", 0.7)});
  const Json right = list({effect("vav_flow@3")}), wrong = list({effect("gain_base")});
  b.add("single", hidden, {{"ratio", 0.5}, {"feedback", true}, {"workflow", "rc"}}, "named", wrong);
  b.add("single", hidden, {{"ratio", 0.5}, {"feedback", false}, {"workflow", "rc"}}, "none");
  b.add("single", hidden, {{"ratio", 1}, {"feedback", true}, {"engine", "energyplus"}}, "named", right);
  b.add("single", hidden, {{"ratio", 3}, {"feedback", false}, {"workflow", "energyplus"}}, "named", right);
  b.add("single", hidden, {{"ratio", 3}, {"feedback", false}, {"engine", "energyplus"}}, "none");
  const ScoreTable table = b.table();
  EXPECT_EQ(count(table, "single", "exact"), "2/5");
  EXPECT_EQ(count(table, "single", "exact", "ratio 0.5"), "0/2");
  EXPECT_EQ(count(table, "single", "exact", "ratio 1"), "1/1");
  EXPECT_EQ(count(table, "single", "exact", "ratio 3"), "1/2");
  EXPECT_EQ(count(table, "single", "exact", "ratio >= 1"), "2/3");
  EXPECT_EQ(count(table, "single", "exact", "ratio >= 1, engine energyplus"), "1/2");
  EXPECT_EQ(count(table, "single", "exact", "ratio >= 1, engine rc"), "1/1");
  EXPECT_EQ(count(table, "single", "exact", "ratio >= 1, feedback on"), "1/1");
  EXPECT_EQ(count(table, "single", "exact", "ratio >= 1, feedback off"), "1/2");
  EXPECT_EQ(count(table, "single", "exact", "ratio >= 1, workflow energyplus"), "1/1");
  EXPECT_EQ(count(table, "single", "wrong name", "ratio 0.5"), "1/2");
  EXPECT_EQ(count(table, "single", "wrong name", "ratio 0.5, feedback on"), "1/1");
  const SetFacts& single = table.sets.at(0);
  EXPECT_EQ(single.cases, 5);
  EXPECT_EQ(single.planned, 300);
  EXPECT_EQ(single.energyplus, 2);
  EXPECT_EQ(single.energyplus_feedback, 1);
}

TEST(Score, PutsTargetsWhereThePlanHasThem) {
  const ScoreTable table = every_answer().table();
  const auto exact = row_of(table.counts, "single", "exact", "ratio >= 1");
  ASSERT_TRUE(exact.target);
  EXPECT_EQ(exact.target->value, 0.85);
  EXPECT_FALSE(exact.target->holds(exact.share()));
  EXPECT_FALSE(row_of(table.counts, "single", "exact", "ratio 1").target);
  const auto wrong = row_of(table.counts, "single", "wrong name", "ratio 0.5");  // there, though no case is
  ASSERT_TRUE(wrong.target);
  EXPECT_FALSE(wrong.target->at_least);
  EXPECT_EQ(wrong.n, 0);
  int targets = 0;
  for (const CountRow& row : table.counts) targets += row.target ? 1 : 0;
  for (const SpreadRow& row : table.spreads) targets += row.target ? 1 : 0;
  EXPECT_EQ(targets, 4 + 1 + 1 + 2 + 2 + 2 + 1 + 1 + 1);
}

TEST(Score, CountsNamesWhereNothingIsHiddenAndUnknownOutsideTheLibrary) {
  Blind b;
  b.add("null", Json::array(), {}, "none");
  b.add("null", Json::array(), {}, "unknown");
  b.add("null", Json::array(), {}, "ambiguous", list({effect("gain_base")}));
  b.add("null", Json::array(), {}, "named", list({effect("gain_base")}));
  b.add("real_null", Json::array(), {{"engine", nullptr}}, "none");
  b.add("outside", list({{{"id", "fcu_dial@2"}, {"magnitude", 1.5}}}), {}, "unknown");
  b.add("outside", list({{{"id", "fcu_dial@2"}}}), {}, "ambiguous", list({effect("gain_base")}));
  b.add("outside", list({{{"id", "fcu_dial@2"}}}), {}, "named", list({effect("gain_base")}));
  const ScoreTable table = b.table();
  EXPECT_EQ(count(table, "null", "named"), "1/4");
  EXPECT_EQ(count(table, "real_null", "named"), "0/1");
  EXPECT_EQ(count(table, "outside", "unknown"), "1/3");
  EXPECT_EQ(count(table, "outside", "wrong name"), "1/3");
}

TEST(Score, TellsBothOneAndExtraOfAPair) {
  Blind b;
  const Json hidden = list({effect("vav_flow@3", 0.7), effect("gain_base", 0.4)});
  const Json facts = {{"ratio", 1}};
  b.add("pair", hidden, facts, "named", list({effect("gain_base"), effect("vav_flow@3")}));
  b.add("pair", hidden, facts, "named", list({effect("gain_base")}));
  b.add("pair", hidden, facts, "named", list({effect("gain_base"), effect("infiltration")}));
  b.add("pair", hidden, facts, "named", list({effect("gain_base"), effect("vav_stuck@3", 0.5, {"vav_flow@3"})}));
  b.add("pair", hidden, facts, "named", list({effect("vav_stuck@3", 0.5, {"vav_flow@3", "gain_base"})}));
  b.add("pair", hidden, facts, "unknown");
  const ScoreTable table = b.table();
  EXPECT_EQ(count(table, "pair", "both"), "1/6");
  EXPECT_EQ(count(table, "pair", "at least one"), "4/6");
  EXPECT_EQ(count(table, "pair", "extra name"), "1/6");
  EXPECT_EQ(count(table, "pair", "both in class"), "2/6");
  EXPECT_EQ(count(table, "pair", "one in class"), "5/6");
  EXPECT_EQ(count(table, "pair", "abstained"), "1/6");
}

TEST(Score, HoldsTheRealCaseToItsOwnTargets) {
  Blind b;
  Json first = effect("solar_gain@south", 0.25);
  first["margin"] = 7.4;
  const Json hidden = list({{{"id", "solar_gain@south"}}});
  b.add("real", hidden, {{"engine", "measured"}}, "named", list({first}))["locked"] = {{"temp_rmse_after_k", 0.39}};
  first["margin"] = 4.9;
  b.add("real", hidden, {{"engine", "measured"}}, "named", list({first}))["locked"] = {{"temp_rmse_after_k", 0.41}};
  const ScoreTable table = b.table();
  EXPECT_EQ(count(table, "real", "exact"), "2/2");
  EXPECT_EQ(count(table, "real", "first by 5 x"), "1/2");
  EXPECT_EQ(count(table, "real", "locked <= 0.40 K"), "1/2");
  EXPECT_EQ(row_of(table.spreads, "right names", "magnitude error", "all").n, 0);  // nobody knows the truth
}

Json locked(const Json& before, const Json& after, const Json& floor) {
  return {{"score_before", before}, {"score_after", after}, {"score_floor", floor}};
}

TEST(Score, MeasuresTheGapClosedAndTheHarmOfEveryName) {
  Blind b;
  const Json right = list({effect("vav_flow@3")}), wrong = list({effect("gain_base")});
  b.single(1, "named", right)["locked"] = locked(5, 1, 1);        // 1
  b.single(1, "named", right)["locked"] = locked(5, 2, 1);        // 0.75
  b.single(1, "named", wrong)["locked"] = locked(5, 4, 1);        // 0.25
  b.single(1, "named", wrong)["locked"] = locked(5, 50, 1);       // -1, harm
  b.single(1, "named", wrong)["locked"] = locked(5, nullptr, 1);  // -1, harm: not finite
  b.single(1, "named", right)["locked"] = locked(1, 1.1, 1);      // no gap, harm
  b.single(1, "named", right);                                    // no figures
  b.single(1, "ambiguous", right)["locked"] = locked(5, 50, 1);   // not named
  const ScoreTable table = b.table();
  const SpreadRow& closed = row_of(table.spreads, "named", "gap closed", "all");
  EXPECT_EQ(closed.n, 5);  // -1 -1 0.25 0.75 1
  EXPECT_DOUBLE_EQ(closed.quartile_1, -1);
  EXPECT_DOUBLE_EQ(closed.median, 0.25);
  EXPECT_DOUBLE_EQ(closed.quartile_3, 0.75);
  EXPECT_EQ(count(table, "named", "harm"), "3/6");
  ASSERT_EQ(table.warnings.size(), 3u);  // the third: no intervals
  EXPECT_EQ(table.warnings[0], "1 case named without figures of locked days, left out of gap closed and harm: case-7");
  EXPECT_EQ(table.warnings[1],
            "1 case named without a gap above the floor on locked days, left out of gap closed: case-6");
}

TEST(Score, RelatesAMagnitudesErrorToTheDistanceFromNull) {
  Blind b;
  Json said = effect("vav_flow@3", 0.73);  // hidden 0.7, null 1: 10 %
  said["interval"] = {0.69, 0.77};
  b.single(1, "named", list({said}));
  said["magnitude"] = 0.4;  // 100 %
  said["interval"] = {0.3, 0.5};
  b.single(1, "named", list({said}));
  said["magnitude"] = nullptr;  // not finite
  said["interval"] = {nullptr, nullptr};
  b.single(1, "named", list({said}));
  b.single(1, "named", list({effect("gain_base", 0.7)}));
  const ScoreTable table = b.table();
  const SpreadRow& error = row_of(table.spreads, "right names", "magnitude error", "all");
  EXPECT_EQ(error.n, 3);
  EXPECT_NEAR(error.quartile_1, 0.55, 1e-9);
  EXPECT_NEAR(error.median, 1.0, 1e-9);
  EXPECT_TRUE(std::isinf(error.quartile_3));
  EXPECT_EQ(count(table, "right names", "interval covers"), "1/3");
  EXPECT_TRUE(json_of(table)["spreads"][0].contains("median"));
}

TEST(Score, CountsACaseWithoutVerdictAsAbstainedAndSaysSo) {
  Blind b = every_answer();
  b.add("null", Json::array(), {}, "none");
  b.add("outside", list({{{"id", "fcu_dial@2"}}}), {}, "unknown");
  b.verdicts["verdicts"].erase(11);
  b.verdicts["verdicts"].erase(0);
  const ScoreTable table = b.table();
  EXPECT_EQ(count(table, "single", "exact"), "1/10");
  EXPECT_EQ(count(table, "single", "abstained"), "6/10");
  EXPECT_EQ(count(table, "outside", "unknown"), "0/1");
  EXPECT_EQ(table.sets.at(0).unanswered, 1);
  EXPECT_EQ(table.confusion.said.back(), "no verdict");
  ASSERT_FALSE(table.warnings.empty());
  EXPECT_EQ(table.warnings[0], "2 cases without verdict, counted as abstained: case-1, case-12");
  EXPECT_NE(text_of(table).find(table.warnings[0]), std::string::npos);
}

TEST(Score, CountsRefusedLogsOnTheirOwn) {
  Blind b = every_answer();
  b.single(1, "refused");
  b.add("null", Json::array(), {}, "refused");
  b.add("outside", list({{{"id", "fcu_dial@2"}}}), {}, "refused");
  const ScoreTable table = b.table();
  EXPECT_EQ(count(table, "single", "abstained"), "6/11");
  EXPECT_EQ(count(table, "null", "named"), "0/1");
  EXPECT_EQ(count(table, "outside", "unknown"), "0/1");
  EXPECT_EQ(table.sets.at(0).refused, 1);
  EXPECT_EQ(table.sets.at(0).unanswered, 0);
  EXPECT_EQ(table.sets.at(1).refused, 1);
  EXPECT_EQ(table.confusion.said.back(), "refused");
  EXPECT_NE(text_of(table).find("3 cases refused"), std::string::npos);
  EXPECT_EQ(json_of(table)["sets"][0]["refused"], 1);
  EXPECT_NE(confusion_svg(table.confusion, "t").find("refused"), std::string::npos);
}

TEST(Score, ConfusesHiddenWithSaidByNameWithoutPlace) {
  Blind b = every_answer();
  b.single(0.5, "named", list({effect("clock_shift")}));
  b.add("null", Json::array(), {}, "named", list({effect("clock_shift")}));
  b.add("outside", list({{{"id", "fcu_dial@2"}}}), {}, "unknown");
  b.add("real", list({{{"id", "solar_gain@south"}}}), {{"engine", nullptr}}, "named",
        list({effect("solar_gain@east")}));
  const Confusion c = b.table().confusion;
  EXPECT_EQ(c.hidden, (std::vector<std::string>{"vav_flow", "solar_gain (real)", "fcu_dial (outside)", "nothing"}));
  EXPECT_EQ(c.right, (std::vector<std::string>{"vav_flow", "solar_gain", "unknown", "none"}));
  EXPECT_EQ(c.said, (std::vector<std::string>{"clock_shift", "gain_base", "solar_gain", "vav_flow", "vav_stuck",
                                              "ambiguous", "unknown", "none"}));
  EXPECT_EQ(
      c.counts,
      (std::vector<std::vector<int>>{
          {0, 1, 0, 3, 1, 3, 1, 1}, {0, 0, 1, 0, 0, 0, 0, 0}, {0, 0, 0, 0, 0, 0, 1, 0}, {1, 0, 0, 0, 0, 0, 0, 0}}));
  const Confusion below = b.table().confusion_below_1;
  EXPECT_EQ(below.hidden, std::vector<std::string>{"vav_flow"});
  EXPECT_EQ(below.counts, (std::vector<std::vector<int>>{{1, 0, 0, 0, 0}}));
}

TEST(Score, WritesJsonThatReadsBackToTheSameFigures) {
  const ScoreTable table = every_answer().table();
  const Json json = Json::parse(json_of(table).dump());
  EXPECT_EQ(json["format"], 1);
  EXPECT_EQ(json["counts"].size(), table.counts.size());
  EXPECT_EQ(json["spreads"].size(), table.spreads.size());
  bool seen = false;
  for (const Json& row : json["counts"]) {
    if (row["set"] != "single" || row["measure"] != "exact" || row["slice"] != "ratio >= 1") continue;
    seen = true;
    EXPECT_EQ(row["k"], 2);
    EXPECT_EQ(row["n"], 10);
    EXPECT_EQ(row["target"]["at_least"], 0.85);
    EXPECT_EQ(row["met"], false);
    EXPECT_NEAR(row["interval"][1].get<double>(), wilson_95(2, 10).high, 1e-12);
  }
  EXPECT_TRUE(seen);
}

TEST(Score, WritesATableThatFitsAPageAndJudgesEveryTarget) {
  Blind b = every_answer();
  for (int i = 0; i < 200; ++i) b.add("null", Json::array(), {}, "none");
  const std::string text = text_of(b.table());
  std::size_t from = 0;
  while (from < text.size()) {
    const std::size_t to = text.find('\n', from);
    std::size_t columns = 0;
    for (std::size_t i = from; i < to; ++i) columns += (static_cast<unsigned char>(text[i]) & 0xC0) != 0x80 ? 1u : 0u;
    EXPECT_LE(columns, 120u) << text.substr(from, to - from);
    from = to + 1;
  }
  for (const char* part : {"2/10     20.0  5.7 .. 51.0     ≥ 85 %   MISSED\n", "≤ 3 %    met\n", "no cases",
                           "20.0 [5.7, 51.0] 2/10", "vav_flow                         ambiguous"}) {
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
  }
}

TEST(Score, SaysThatFewCasesCannotTell) {
  Blind b;
  b.add("null", Json::array(), {}, "none");
  EXPECT_NE(text_of(b.table()).find("met, unsure"), std::string::npos);
}

TEST(ScoreInput, NamesTheFieldThatIsWrong) {
  const Blind good = every_answer();
  EXPECT_EQ(complaint(good), "no complaint");
  const auto spoilt_verdicts = [&](const char* pointer, const Json& value) {
    Blind b = good;
    b.verdicts[Json::json_pointer(pointer)] = value;
    return complaint(b);
  };
  const auto spoilt_key = [&](const char* pointer, const Json& value) {
    Blind b = good;
    b.key[Json::json_pointer(pointer)] = value;
    return complaint(b);
  };
  EXPECT_TRUE(spoilt_verdicts("/verdicts/3/effects/0/id", 7)
                  .starts_with("verdicts[3].effects[0].id: found 7; expected a text; "));
  EXPECT_TRUE(spoilt_verdicts("/verdicts/3/effects/0/id", "vav_flaw@3")
                  .starts_with("verdicts[3].effects[0].id: found \"vav_flaw@3\"; expected an effect of the library"));
  EXPECT_TRUE(spoilt_verdicts("/verdicts/1/effects/0/class/0", "x").starts_with("verdicts[1].effects[0].class[0]: "));
  EXPECT_TRUE(spoilt_verdicts("/verdicts/0/effects/0/magnitude", "0.7")
                  .starts_with("verdicts[0].effects[0].magnitude: found \"0.7\"; expected a number; "));
  EXPECT_TRUE(spoilt_verdicts("/verdicts/0/effects/0/interval", {1})
                  .starts_with("verdicts[0].effects[0].interval: found [1]; expected two numbers"));
  EXPECT_TRUE(spoilt_verdicts("/verdicts/0/effects", Json::array())
                  .starts_with("verdicts[0].effects: found []; expected at least one effect; "));
  EXPECT_TRUE(
      spoilt_verdicts("/verdicts/0/verdict", "sure")
          .starts_with(
              "verdicts[0].verdict: found \"sure\"; expected one of named, ambiguous, unknown, none, refused; "));
  EXPECT_TRUE(spoilt_verdicts("/verdicts/2", 1).starts_with("verdicts[2]: found 1; expected an object; "));
  EXPECT_TRUE(spoilt_verdicts("/verdicts", 1).starts_with("verdicts: found 1; expected a list; "));
  EXPECT_TRUE(spoilt_verdicts("/format", 2).starts_with("verdicts: format: found 2; expected 1; "));
  EXPECT_TRUE(spoilt_verdicts("/verdicts/5/case", "case-77")
                  .starts_with("verdicts[5].case: found \"case-77\"; expected a case of the answer key; "));
  EXPECT_TRUE(spoilt_verdicts("/verdicts/5/case", "case-1")
                  .starts_with("verdicts[5].case: found \"case-1\"; expected one verdict a case; "));
  EXPECT_TRUE(spoilt_key("/format", "1").starts_with("answer key: format: found \"1\"; expected 1; "));
  EXPECT_TRUE(spoilt_key("/cases", Json::array()).starts_with("cases: found []; expected an object; "));
  EXPECT_TRUE(spoilt_key("/cases/case-2/set", "double")
                  .starts_with("cases.case-2.set: found \"double\"; expected one of single, null, "));
  EXPECT_TRUE(spoilt_key("/cases/case-2/ratio", nullptr).starts_with("cases.case-2.ratio: found nothing; "));
  EXPECT_TRUE(spoilt_key("/cases/case-2/feedback", "yes").starts_with("cases.case-2.feedback: found \"yes\"; "));
  EXPECT_TRUE(
      spoilt_key("/cases/case-2/hidden/0/magnitude", 1)
          .starts_with(
              "cases.case-2.hidden[0].magnitude: found 1; expected another number than the effect's null value; "));
  EXPECT_TRUE(spoilt_key("/cases/case-2/hidden/0/magnitude", nullptr)
                  .starts_with("cases.case-2.hidden[0].magnitude: found nothing; expected a number; "));
  EXPECT_TRUE(
      spoilt_key("/cases/case-2/hidden", Json::array())
          .starts_with("cases.case-2.hidden: found []; expected one effect hidden in a case of the set single; "));
  EXPECT_TRUE(spoilt_key("/cases/case-2/set", "null").starts_with("cases.case-2.hidden: found "));
  EXPECT_TRUE(spoilt_key("/cases/case-2/set", "pair").starts_with("cases.case-2.hidden: found "));
}

TEST(ScoreInput, RefusesANameWithoutMagnitude) {
  Blind b = every_answer();
  b.verdicts["verdicts"][0]["effects"][0].erase("magnitude");
  EXPECT_TRUE(complaint(b).starts_with("verdicts[0].effects[0].magnitude: found nothing; expected a number; "));
}

/// Whether the text is well-formed XML, as far as these pictures need: every element closed by its own end, attributes
/// quoted and not doubled, no bare < or &.
std::string xml_fault(const std::string& text) {
  std::vector<std::string> open;
  bool root_seen = false;
  std::size_t i = 0;
  while (i < text.size()) {
    if (text[i] == '&') {
      const std::size_t end = text.find(';', i);
      static const std::vector<std::string> known{"&amp", "&lt", "&gt", "&quot", "&#39"};
      if (end == std::string::npos || std::ranges::find(known, text.substr(i, end - i)) == known.end()) return "bare &";
      i = end + 1;
    } else if (text[i] != '<') {
      if (open.empty() && !std::isspace(static_cast<unsigned char>(text[i]))) return "text outside the root";
      ++i;
    } else if (text.compare(i, 2, "</") == 0) {
      const std::size_t end = text.find('>', i);
      if (open.empty() || text.substr(i + 2, end - i - 2) != open.back()) return "wrong end at " + text.substr(i, 20);
      open.pop_back();
      i = end + 1;
    } else {
      std::size_t at = i + 1;
      const auto word = [&] {
        const std::size_t from = at;
        while (at < text.size() && (std::isalnum(static_cast<unsigned char>(text[at])) || text[at] == '-')) ++at;
        return text.substr(from, at - from);
      };
      const auto space = [&] {
        while (at < text.size() && std::isspace(static_cast<unsigned char>(text[at]))) ++at;
      };
      const std::string name = word();
      if (name.empty() || (open.empty() && root_seen)) return "no element at " + text.substr(i, 20);
      root_seen = true;
      std::vector<std::string> attributes;
      for (space(); at < text.size() && text[at] != '>' && text[at] != '/'; space()) {
        const std::string attribute = word();
        const std::size_t end = text.find('"', at + 2);
        if (attribute.empty() || text.compare(at, 2, "=\"") != 0 || end == std::string::npos ||
            text.substr(at, end - at).find('<') != std::string::npos ||
            std::ranges::find(attributes, attribute) != attributes.end()) {
          return "bad attribute at " + text.substr(i, 60);
        }
        attributes.push_back(attribute);
        at = end + 1;
      }
      if (text[at] == '>')
        open.push_back(name);
      else if (text.compare(at, 2, "/>") == 0)
        ++at;
      else
        return "unclosed tag";
      i = at + 1;
    }
  }
  return open.empty() && root_seen ? "" : "unclosed element";
}

/// 40 rows of 44 columns, as a full test makes them.
Confusion full_size() {
  Confusion c;
  for (int j = 0; j < 41; ++j) c.said.push_back("effect_number_" + std::to_string(j));
  for (const char* word : {"ambiguous", "unknown", "none"}) c.said.emplace_back(word);
  for (int i = 0; i < 40; ++i) {
    const bool known = i < 36;
    c.hidden.push_back(known ? c.said[static_cast<std::size_t>(i)] : "outside_" + std::to_string(i) + " (outside)");
    c.right.push_back(known ? c.hidden.back() : "unknown");
    std::vector<int> row(c.said.size(), 0);
    row[static_cast<std::size_t>(known ? i : 42)] = 9 + i % 7;
    row[static_cast<std::size_t>((i * 7) % 41)] += 1 + i % 4;
    row[41] = i % 5;
    c.counts.push_back(row);
  }
  return c;
}

TEST(ConfusionSvg, IsXmlAndShowsEveryLabelAndCount) {
  const Confusion c = full_size();
  const std::string svg = confusion_svg(c, "What was hidden & what was said");
  EXPECT_EQ(xml_fault(svg), "");
  for (const auto* names : {&c.hidden, &c.said}) {
    for (const std::string& name : *names) EXPECT_NE(svg.find(">" + name + "</text>"), std::string::npos) << name;
  }
  for (const auto& row : c.counts) {
    for (const int n : row) {
      EXPECT_TRUE(n == 0 || svg.find(">" + std::to_string(n) + "</text>") != std::string::npos) << n;
    }
  }
  EXPECT_NE(svg.find("hidden effect_number_1, said effect_number_1: 10 of 13 (77 %)"), std::string::npos);
}

TEST(ConfusionSvg, ColoursByShareAndByWhatIsRight) {
  const std::string svg = confusion_svg({{"a", "b"}, {"a", "b"}, {"a", "b", "none"}, {{4, 0, 0}, {0, 0, 4}}}, "t");
  EXPECT_NE(svg.find("class=\"right\" fill=\"#0b62b4\""), std::string::npos);  // all of the row, right
  EXPECT_NE(svg.find("class=\"\" fill=\"#56616e\""), std::string::npos);       // all of the row, abstained
  EXPECT_NE(svg.find("class=\"empty right\""), std::string::npos);             // right, but never said
  EXPECT_EQ(svg.find("class=\"\" fill=\"#d1570f\""), std::string::npos);       // nobody said a wrong name
}

TEST(ConfusionSvg, KeepsMarkupInLabelsHarmless) {
  const std::string attack = "</text><script>alert(1)</script>\"'&";
  const std::string svg = confusion_svg({{attack}, {attack}, {attack}, {{1}}}, attack);
  EXPECT_EQ(xml_fault(svg), "");
  EXPECT_EQ(svg.find("<script"), std::string::npos);
}

TEST(ConfusionSvg, OfNothingIsStillAPicture) { EXPECT_EQ(xml_fault(confusion_svg({}, "nothing")), ""); }

TEST(ConfusionSvg, RefusesCountsOfAnotherShape) {
  EXPECT_THROW(confusion_svg({{"a"}, {"a"}, {"a", "b"}, {{1}}}, "t"), std::invalid_argument);
}

}  // namespace
}  // namespace airside::tools::gap
