// tools/learn_bound on made-up tables in which two effects can be told apart, and on files that are wrong.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <random>

#include "support/program.hpp"
#include "tools/gap/bound/bound_cases.hpp"

namespace airside::tools::gap {
namespace {

class LearnBound : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* venv = std::getenv("AIRSIDE_VENV");
    python_ = (venv != nullptr ? std::string(venv) : std::string(AIRSIDE_SOURCE_DIR) + "/build/venv") + "/bin/python";
    if (run({"-c", "import numpy"}).code != 0)
      GTEST_SKIP() << "NOT TESTED: numpy is missing; run tools/setup --for test, or set AIRSIDE_VENV";
  }
  Outcome run(std::vector<std::string> words) const {
    return run_program(python_, std::move(words), folder_.path(), scratch_.path());
  }
  Outcome learn(std::vector<std::string> words) const {
    words.insert(words.begin(), std::string(AIRSIDE_SOURCE_DIR) + "/tools/learn_bound");
    return run(std::move(words));
  }

  /// A room's level is its own in all periods; effects move the level of one channel.
  void write_drawing(int seed, int cases) const {
    const BoundColumns columns = bound_columns({2, 1, 1});
    constexpr Eigen::Index bins = Eigen::Index{4} * bins_per_day;
    std::mt19937 random(static_cast<unsigned>(seed));
    std::normal_distribution<double> normal;
    const std::filesystem::path path = folder_.path() / std::to_string(seed);
    std::ofstream out(path.string() + ".bin", std::ios::binary);
    nlohmann::json list = nlohmann::json::array();
    for (int i = 0; i < cases; ++i) {
      const bool first = i % 2 == 0, strong = i % 3 != 0;
      const double level = normal(random);
      list.push_back({{"id", first ? "bias@1" : "bias@2"},
                      {"ratio", strong ? 3.0 : 1.0},
                      {"window", i % 5},
                      {"feedback", i % 4 < 2}});
      for (const char* period : {"reference", "measured", "without"}) {
        Eigen::MatrixXd table(bins, std::ssize(columns.names));
        for (double& x : table.reshaped()) x = 0.3 * normal(random);
        table.array() += level;
        if (std::string(period) == "measured") table.col(first ? 0 : 1).array() += strong ? 1.5 : 0.5;
        const std::vector<std::int16_t> steps = steps_of(table, columns);
        out.write(reinterpret_cast<const char*>(steps.data()),
                  static_cast<std::streamsize>(steps.size() * sizeof steps[0]));
      }
    }
    std::ofstream(path.string() + ".json") << nlohmann::json{{"seed", seed},
                                                             {"periods", {"reference", "measured", "without"}},
                                                             {"columns", columns.names},
                                                             {"units_per_step", columns.units_per_step},
                                                             {"bins", bins},
                                                             {"cases", list}};
  }

  std::string python_;
  TemporaryFolder folder_, scratch_;
};

TEST_F(LearnBound, TellsApartWhatCanBeTold) {
  for (int seed = 1; seed <= 5; ++seed) write_drawing(seed, 24);
  const Outcome o = learn({".", "--rounds", "6", "--seeds", "1", "--sizes"});
  ASSERT_EQ(o.code, 0) << o.err;
  const nlohmann::json j = nlohmann::json::parse(o.out);
  EXPECT_EQ(j["cases"], 120);
  EXPECT_EQ(j["learned from"], 72);
  EXPECT_EQ(j["reported on"], 120) << "few drawings: each in turn";
  EXPECT_EQ(j["names"], 2);
  const nlohmann::json& told = j["figures"]["networks"]["all"];
  EXPECT_GE(told["3x"]["forced choice"]["share"].get<double>(), 0.9) << told;
  EXPECT_LE(told["3x"]["wrong name"]["share"].get<double>(), 0.1) << told;
  EXPECT_EQ(told["nulls named"]["of"], 120);
  EXPECT_GE(j["figures"]["nearest response"]["all"]["3x"]["forced choice"]["share"].get<double>(), 0.8) << j;
  EXPECT_EQ(learn({".", "--rounds", "6", "--seeds", "1", "--sizes"}).out, o.out) << "features kept, same seeds";
}

TEST_F(LearnBound, SaysWhatIsWrongWithItsTables) {
  EXPECT_NE(learn({"."}).err.find("three at least"), std::string::npos);
  for (int seed = 1; seed <= 3; ++seed) write_drawing(seed, 2);
  std::ofstream(folder_.path() / "2.json") << "{}";
  const Outcome o = learn({"."});
  EXPECT_EQ(o.code, 1);
  EXPECT_NE(o.err.find("2.json"), std::string::npos) << o.err;
}

}  // namespace
}  // namespace airside::tools::gap
