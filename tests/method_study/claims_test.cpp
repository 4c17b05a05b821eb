// Verdicts and tables of a folder of runs.

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "hal/text/input_error.hpp"
#include "support/program.hpp"
#include "tools/study/method/claims.hpp"
#include "tools/study/method/tables.hpp"

namespace airside::tools {
namespace {

class MethodClaims : public testing::Test {
 protected:
  void write(const std::string& row, const std::string& room, int seed, const nlohmann::json& figures) const {
    nlohmann::json j{{"row", row}, {"room", room}, {"seed", seed}, {"study", study().facts()}, {"figures", figures}};
    std::ofstream(folder_.path() / (row + "_" + room + "_" + std::to_string(seed) + ".json")) << j.dump();
  }
  void write_score(const std::string& row, double dae, double darv) const {
    write(row, "301-real", 1, {{"dae_degc", dae}, {"darv_degc", darv}, {"me_degc", 2 * dae}, {"day1_dae_degc", dae}});
  }
  MethodStudy study() const {
    MethodStudy s;
    s.folder = folder_.path().string();
    return s;
  }
  ClaimVerdict claim(int number) const {
    return judge_claims(MethodResults::read(study())).at(static_cast<std::size_t>(number - 1));
  }
  TemporaryFolder folder_;
};

TEST_F(MethodClaims, AreInOrder) {
  int number = 0;
  for (const ClaimVerdict& v : judge_claims(MethodResults::read(study()))) EXPECT_EQ(v.number, ++number);
  EXPECT_EQ(number, 24);
}

TEST_F(MethodClaims, WithoutRunsNothingIsSaidToHold) {
  for (const ClaimVerdict& v : judge_claims(MethodResults::read(study())))
    EXPECT_TRUE(v.state == ClaimState::not_run || v.state == ClaimState::elsewhere) << v.number;
}

TEST_F(MethodClaims, OneMissingRowLeavesAClaimOpen) {
  write_score("paper", 0.06, 0.36);
  EXPECT_EQ(claim(7).state, ClaimState::not_run);
  write_score("without-physics", 0.09, 0.34);
  EXPECT_EQ(claim(7).state, ClaimState::reproduced);
}

TEST_F(MethodClaims, PartsThatFailAreSaid) {
  write_score("paper", 0.06, 0.36);
  write_score("without-online", 0.13, 0.40);  // DAE and ME twice as large, DARV not
  EXPECT_EQ(claim(9).state, ClaimState::partly);
  write_score("without-online", 0.05, 0.10);
  EXPECT_EQ(claim(9).state, ClaimState::not_reproduced);
}

TEST_F(MethodClaims, ThePublishedScoresPassTheirOwnRules) {
  for (const MethodRow& row : method_rows()) {
    if (row.table != MethodTable::score && row.name != std::string("paper")) continue;
    write_score(row.name, row.published[1].value, row.published[2].value);
  }
  EXPECT_EQ(claim(5).state, ClaimState::reproduced);
  EXPECT_EQ(claim(6).state, ClaimState::reproduced);
  EXPECT_NE(claim(6).ours.find("with DARV -1.00"), std::string::npos) << claim(6).ours;
}

TEST_F(MethodClaims, TheBestCycleIsJudgedByErrorUnrestAndForecasts) {
  const auto cycle = [this](const std::string& row, double dae, double darv, double forecast) {
    write(row, "301-real", 1, {{"dae_degc", dae}, {"darv_degc", darv}, {"forecast_mae_k", forecast}});
  };
  cycle("paper", 0.07, 0.28, 0.06);
  cycle("paper-24", 0.10, 0.28, 0.08);
  cycle("paper-12", 0.08, 0.40, 0.04);
  EXPECT_EQ(claim(14).state, ClaimState::not_run);
  cycle("paper-6", 0.09, 0.60, 0.02);
  EXPECT_EQ(claim(14).state, ClaimState::reproduced) << claim(14).ours;
  cycle("paper-6", 0.09, 0.20, 0.02);
  EXPECT_EQ(claim(14).state, ClaimState::partly);
  EXPECT_NE(claim(14).ours.find("DARV of paper-6 and 18 min 0.200 and 0.280"), std::string::npos) << claim(14).ours;
}

TEST_F(MethodClaims, AClaimAboutMethodsThatDidNotRunIsAtMostPartlyReproduced) {
  write_score("paper", 0.06, 0.36);
  write_score("pid", 0.35, 0.5);
  write_score("expert", 1.5, 0);
  EXPECT_EQ(claim(4).state, ClaimState::partly);
  EXPECT_NE(claim(4).ours.find("OSLN"), std::string::npos) << claim(4).ours;
}

TEST_F(MethodClaims, OneRunHasNoSpread) {
  write("expert", "301-real", 1, {{"dae_degc", 1.5}});
  const std::string text = method_table_markdown(method_tables_of(MethodResults::read(study())).at(0));
  EXPECT_NE(text.find("| 1.500 "), std::string::npos) << text;
  EXPECT_EQ(text.find("±"), std::string::npos) << text;
}

TEST_F(MethodClaims, TablesHaveThePublishedFigureBesideOurs) {
  write("without-tdb", "301-real", 1, {{"dae_degc", 0.25}, {"darv_degc", 0.5}});
  write("without-tdb", "301-real", 2, {{"dae_degc", 0.35}, {"darv_degc", 0.7}});
  const nlohmann::json tables = method_tables_of(MethodResults::read(study()));
  ASSERT_EQ(tables.size(), 1U);
  EXPECT_NEAR(tables[0]["lines"][0]["figures"]["dae_degc"]["mean"].get<double>(), 0.30, 1e-12);
  const std::string text = method_table_markdown(tables[0]);
  EXPECT_NE(text.find("| 0.300 ± 0.071 | 0.0558 "), std::string::npos) << text;
  EXPECT_NE(text.find("| 0.600 ± 0.141 | 0.411 "), std::string::npos) << text;
}

TEST_F(MethodClaims, AFileThatIsNoRunIsNamedWithItsField) {
  const auto said = [this](const std::string& text) {
    std::ofstream(folder_.path() / "paper_301-real_1.json") << text;
    try {
      (void)MethodResults::read(study());
    } catch (const hal::InputError& e) {
      return std::string(e.what());
    }
    return std::string("nothing");
  };
  EXPECT_NE(said("{}").find("paper_301-real_1.json: row"), std::string::npos);
  EXPECT_NE(said("{\"row\"").find("paper_301-real_1.json"), std::string::npos);
  nlohmann::json j{{"row", "paper"}, {"room", "301-real"}, {"seed", 1}, {"study", study().facts()}};
  j["figures"] = {{"dae_degc", "low"}};
  EXPECT_NE(said(j.dump()).find("figures.dae_degc: found \"low\""), std::string::npos);
  j["figures"] = {{"dae_degc", 0.1}};
  j["study"]["days"] = 3;
  EXPECT_NE(said(j.dump()).find("study.days: found 3; expected 14"), std::string::npos);
}

}  // namespace
}  // namespace airside::tools
