// Cases of several drawings, counted together.

#include <gtest/gtest.h>

#include <algorithm>

#include "hal/text/input_error.hpp"
#include "tools/gap/score/score.hpp"

namespace airside::tools::gap {
namespace {

using Json = nlohmann::json;

const std::map<std::string, double> one_effect{{"vav_flow", 1}};

/// One single case that is named rightly.
JudgedCases drawing() {
  const Json effect{{"id", "vav_flow@3"}, {"magnitude", 0.7}};
  JudgedCases d;
  d.key = {{"format", 1}, {"seed", 7}, {"cases", Json::object()}};
  d.key["cases"]["case-1"] = {{"set", "single"}, {"engine", "rc"}, {"ratio", 1}, {"hidden", Json::array({effect})}};
  d.verdicts = {{"format", 1}, {"verdicts", Json::array()}};
  d.verdicts["verdicts"].push_back({{"case", "case-1"}, {"verdict", "named"}, {"effects", Json::array({effect})}});
  return d;
}

int exact_of(const ScoreTable& table) {
  for (const CountRow& row : table.counts)
    if (row.set == "single" && row.measure == "exact" && row.slice == "all") return row.k;
  return -1;
}

TEST(ScoreDrawings, AreCountedTogetherAndTheirCasesToldApart) {
  JudgedCases second = drawing();
  second.key["cases"]["case-2"] = {{"set", "null"}, {"engine", "rc"}, {"hidden", Json::array()}};  // no verdict
  const ScoreTable both = score({drawing(), second}, one_effect);
  EXPECT_EQ(exact_of(both), 2);
  const auto names_it = [](const std::string& warning) { return warning.find("2/case-2") != std::string::npos; };
  EXPECT_EQ(std::ranges::count_if(both.warnings, names_it), 1);
}

TEST(ScoreDrawings, AMistakeIsNamedWithItsDrawing) {
  JudgedCases other = drawing();
  other.verdicts["verdicts"][0]["case"] = "case-9";
  try {
    (void)score({drawing(), other}, one_effect);
    FAIL() << "verdicts of another drawing were counted";
  } catch (const hal::InputError& error) {
    EXPECT_EQ(error.place().find("drawing 2: verdicts["), 0U) << error.what();
  }
}

}  // namespace
}  // namespace airside::tools::gap
