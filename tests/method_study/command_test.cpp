// `airside study method` as a person runs it: short runs, an interrupted study that goes on, the same bytes again.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/program.hpp"

namespace airside {
namespace {

class StudyOfMethod : public testing::Test {
 protected:
  Outcome study(const std::string& tables, std::vector<std::string> more = {}, const std::string& days = "2") const {
    std::vector<std::string> words = {"study",
                                      "method",
                                      "--tables",
                                      tables,
                                      "--days",
                                      days,
                                      "--pretrain-days",
                                      "3",
                                      "--summer-days",
                                      "1",
                                      "--winter-days",
                                      "1",
                                      "--operated-days",
                                      "3",
                                      "--steps",
                                      "20",
                                      "--seeds",
                                      "1",
                                      "-o",
                                      "runs"};
    words.insert(words.end(), more.begin(), more.end());
    return run_program("airside", words, folder_.path(), scratch_.path(), 400);
  }
  std::string run_text(const std::string& name) const { return text_of_file(folder_.path() / "runs" / name); }

  TemporaryFolder folder_, scratch_;
};

TEST_F(StudyOfMethod, RunsThatTheFolderHasAreLeftOutAndARepeatedRunIsTheSame) {
  const Outcome first = study("control", {"--json"});
  ASSERT_EQ(first.code, 0) << first.err;
  const nlohmann::json found = nlohmann::json::parse(first.out);
  EXPECT_EQ(found["runs"], 3);
  EXPECT_EQ(found["claims"].size(), 24U);
  const std::string before = run_text("paper_301-real_1.json");
  ASSERT_FALSE(before.empty());

  fs::remove(folder_.path() / "runs" / "paper_301-real_1.json");
  const Outcome again = study("control", {"--json"});
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_NE(again.err.find("1 runs"), std::string::npos) << again.err;
  EXPECT_EQ(run_text("paper_301-real_1.json"), before);
  EXPECT_EQ(again.out, first.out);
}

TEST_F(StudyOfMethod, DeploymentStartsFromPretrainedWeights) {
  const Outcome done = study("neighbours");
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_TRUE(fs::exists(folder_.path() / "runs" / "source-operated_301-real_1.blob"));
  const auto transferred = nlohmann::json::parse(run_text("room-to-room_401-real_1.json"));
  const auto alone = nlohmann::json::parse(run_text("room-alone_401-real_1.json"));
  EXPECT_NE(transferred["figures"]["dae_degc"], alone["figures"]["dae_degc"]);
  EXPECT_EQ(transferred["daily_dae_degc"].size(), 2U);
  EXPECT_NE(done.out.find("401-real, room-to-room"), std::string::npos) << done.out;
}

TEST_F(StudyOfMethod, ForecastsAreJudgedWithAndWithoutPhysicsLosses) {
  const Outcome done = study("physics");
  ASSERT_EQ(done.code, 0) << done.err;
  const auto figures = nlohmann::json::parse(run_text("physics_301-real_1.json"))["figures"];
  for (const char* with : {"with", "without"}) {
    const double error = figures[std::string(with) + "_mae_k"], wrong = figures[std::string(with) + "_violation_share"];
    EXPECT_GT(error, 0.01);
    EXPECT_LT(error, 5);
    EXPECT_GT(wrong, 0);
    EXPECT_LT(wrong, 1);
  }
}

TEST_F(StudyOfMethod, AFolderOfAnotherStudyIsRefused) {
  ASSERT_EQ(study("control").code, 0);
  const Outcome other = study("control", {"--report-only"}, "3");
  EXPECT_EQ(other.code, 1);
  EXPECT_NE(other.err.find("study.days: found 2; expected 3"), std::string::npos) << other.err;
}

}  // namespace
}  // namespace airside
