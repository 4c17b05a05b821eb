// Posteriors of verdicts written by hand, with answers counted by hand.

#include <gtest/gtest.h>

#include <algorithm>

#include "tools/gap/report/reliability_svg.hpp"
#include "tools/gap/score/score.hpp"

namespace airside::tools::gap {
namespace {

using Json = nlohmann::json;

/// {x} would be x itself, not a list of it.
Json listed(std::initializer_list<Json> entries) { return entries; }
Json hidden_effect(const std::string& id, double magnitude) { return {{"id", id}, {"magnitude", magnitude}}; }

struct PosteriorCases {
  Json key = {{"format", 1}, {"seed", 7}, {"cases", Json::object()}};
  Json verdicts = {{"format", 1}, {"verdicts", Json::array()}};

  void add(const std::string& set, double ratio, const Json& hidden, const Json& posterior) {
    const std::string id = "case-" + std::to_string(key["cases"].size() + 1);
    key["cases"][id] = {{"set", set}, {"engine", "rc"}, {"ratio", ratio}, {"hidden", hidden}};
    verdicts["verdicts"].push_back(
        {{"case", id}, {"verdict", "none"}, {"effects", Json::array()}, {"posterior", posterior}});
  }
  void single(double ratio, const Json& posterior) {
    add("single", ratio, listed({hidden_effect("vav_flow@3", 0.7)}), posterior);
  }
  ScoreTable table() const { return score(verdicts, key, {{"vav_flow", 1}, {"gain_base", 0}}); }
};

std::string count_of_sets(const ScoreTable& table, const std::string& set, const std::string& slice = "all") {
  for (const CountRow& row : table.counts) {
    if (row.set == set && row.measure == "90 % set" && row.slice == slice)
      return std::to_string(row.k) + "/" + std::to_string(row.n);
  }
  return "no row";
}

Json posterior(const std::string& id, double probability, double nothing, double other,
               const std::vector<std::string>& set, const std::vector<std::string>& beside = {}) {
  return listed({{{"beside", beside},
                  {"candidates", listed({{{"id", id}, {"probability", probability}}})},
                  {"nothing", nothing},
                  {"other", other},
                  {"set", set}}});
}

TEST(Score, MeasuresTheGapClosedToARightModelBesideTheGapClosedToNoise) {
  PosteriorCases b;
  const auto named = [&b](double after, const Json& right) {
    b.single(3, posterior("vav_flow@3", 0.98, 0.01, 0.01, {"vav_flow@3"}));
    Json& verdict = b.verdicts["verdicts"].back();
    verdict["verdict"] = "named";
    verdict["effects"] = listed({{{"id", "vav_flow@3"}, {"magnitude", 0.7}}});
    verdict["locked"] = {{"score_before", 5}, {"score_after", after}, {"score_floor", 1}, {"score_right", right}};
    verdict["locked"]["temp_rmse_after_k"] = nullptr;
  };
  named(3, 2);        // of 4 down to noise 2 are gone, of 3 down to a right model 2
  named(1.5, 2);      // better than a right model: all
  named(3, 6);        // no gap above a right model
  named(3, nullptr);  // no buildings were drawn
  const ScoreTable table = b.table();
  const auto row = [&table](const std::string& measure) {
    return *std::ranges::find_if(table.spreads,
                                 [&](const SpreadRow& r) { return r.measure == measure && r.slice == "all"; });
  };
  EXPECT_EQ(row("gap closed").n, 4);
  EXPECT_DOUBLE_EQ(row("gap closed").median, 0.5);
  EXPECT_EQ(row("closed to a right model").n, 2);
  EXPECT_DOUBLE_EQ(row("closed to a right model").quartile_1, 0.75);
  EXPECT_DOUBLE_EQ(row("closed to a right model").quartile_3, 11.0 / 12);
  for (const CountRow& r : table.counts) EXPECT_FALSE(r.measure.empty());
}

TEST(Score, HoldsPosteriorsToWhatIsHidden) {
  PosteriorCases b;
  b.single(1, posterior("vav_flow@3", 0.98, 0.01, 0.01, {"vav_flow@3"}));
  b.single(3, posterior("vav_stuck@3", 0.6, 0.05, 0.05, {"vav_stuck@3", "vav_flow@3"}));
  b.single(1, posterior("gain_base", 0.97, 0.01, 0.02, {"gain_base"}));
  b.single(0.5, posterior("gain_base", 0.1, 0.9, 0, {"nothing"}));
  b.add("null", 0, Json::array(), posterior("gain_base", 0.1, 0.9, 0, {"nothing"}));
  b.add("outside", 3, listed({hidden_effect("fcu_dial@1", 1)}),
        posterior("gain_base", 0.3, 0, 0.7, {"other", "gain_base"}));
  const ScoreTable table = b.table();
  EXPECT_EQ(count_of_sets(table, "single", "ratio >= 1"), "2/3");
  EXPECT_EQ(count_of_sets(table, "single", "ratio 0.5"), "0/1");
  EXPECT_EQ(count_of_sets(table, "null"), "1/1");
  EXPECT_EQ(count_of_sets(table, "outside"), "1/1");
  EXPECT_EQ(table.posteriors.single, 3);
  EXPECT_DOUBLE_EQ(table.posteriors.set_size_median, 1);
  EXPECT_DOUBLE_EQ(table.posteriors.set_size_quartile_3, 2);
  ASSERT_EQ(table.posteriors.reliability.size(), 4U);
  const ReliabilityBin &middle = table.posteriors.reliability[1], &surest = table.posteriors.reliability[3];
  EXPECT_EQ(middle.n, 2) << "0.6 and 0.7";
  EXPECT_EQ(middle.came, 1);
  EXPECT_EQ(surest.n, 2);
  EXPECT_EQ(surest.came, 1);
  EXPECT_DOUBLE_EQ(surest.said, 0.975);
  EXPECT_NE(text_of(table).find("95 to 100 %: said  97.5 %, came  50.0 %"), std::string::npos) << text_of(table);
  EXPECT_EQ(json_of(table)["posteriors"]["reliability"][3]["came"], 1);
}

TEST(ReliabilitySvg, MarksEachBinThatHasCasesAndColoursWhatIsNotHonest) {
  const std::string svg =
      reliability_svg({{0, 0.5, 0, 0, 0}, {0.5, 0.8, 20, 14, 0.66}, {0.95, 1, 40, 20, 0.98}}, "a & b");
  EXPECT_NE(svg.find("<g class=\"honest\"><title>said 66 %, came 14 of 20</title>"), std::string::npos) << svg;
  EXPECT_NE(svg.find("<g class=\"off\"><title>said 98 %, came 20 of 40</title>"), std::string::npos);
  EXPECT_EQ(svg.find("came 0 of 0"), std::string::npos) << "a bin without cases";
  EXPECT_NE(svg.find("a &amp; b"), std::string::npos);
  EXPECT_NE(reliability_svg({}, "nothing").find("</svg>"), std::string::npos);
}

TEST(Score, CountsOfAPosteriorBesideOneOfAPairOnlyTheOther) {
  PosteriorCases b;
  const Json hidden = listed({hidden_effect("vav_flow@3", 0.7), hidden_effect("gain_base", 2)});
  b.add("pair", 3, hidden, posterior("vav_flow@3", 0.98, 0.01, 0.01, {"vav_flow@3"}, {"vav_flow@3"}));
  b.add("pair", 3, hidden, posterior("gain_base", 0.98, 0.01, 0.01, {"gain_base"}, {"vav_flow@3"}));
  EXPECT_EQ(count_of_sets(b.table(), "pair"), "1/2");
}

}  // namespace
}  // namespace airside::tools::gap
