// The tables of what the room head misses, and the tool that says how much of it could be predicted: on errors that can
// be, on errors that cannot, and on files that are wrong.

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <random>

#include "support/program.hpp"

namespace airside::tools {
namespace {

class LearnResiduals : public ::testing::Test {
 protected:
  void SetUp() override {
    const char* venv = std::getenv("AIRSIDE_VENV");
    python_ = (venv != nullptr ? std::string(venv) : std::string(AIRSIDE_SOURCE_DIR) + "/build/venv") + "/bin/python";
    if (run(python_, {"-c", "import sklearn"}).code != 0)
      GTEST_SKIP() << "NOT TESTED: scikit-learn is missing; run tools/setup --for test, or set AIRSIDE_VENV";
  }
  Outcome run(const std::string& program, std::vector<std::string> words) const {
    return run_program(program, std::move(words), folder_.path(), scratch_.path());
  }
  Outcome collect(const std::string& room, const std::string& out) const {
    return run(std::string(AIRSIDE_BIN_DIR) + "/airside",
               {"study", "residuals", "--plant", "rc", "--scenarios", "summer,outages", "--rooms", room, "--seeds", "1",
                "--days", "4", "-o", out});
  }
  Outcome learn(std::vector<std::string> words) const {
    words.insert(words.begin(), std::string(AIRSIDE_SOURCE_DIR) + "/tools/learn_residuals");
    return run(python_, std::move(words));
  }

  /// Writes the errors anew: what happened to the rooms in the cycle before, or chance.
  void set_errors(const std::string& folder, bool predictable) const {
    std::mt19937 random(7);
    std::normal_distribution<double> normal(0, 0.05);
    for (const auto& file : std::filesystem::directory_iterator(folder_.path() / folder)) {
      std::ifstream in(file.path());
      std::string text, line;
      std::getline(in, text);
      double before = 0;
      while (std::getline(in, line)) {
        std::vector<std::string> fields;
        std::stringstream stream(line);
        for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
        fields.resize(3 + 2 * 25 + 8 + 2);  // an empty last field ends the line
        fields[2] = std::to_string(predictable ? 0.5 * before : normal(random));
        double mean = 0;
        for (std::size_t i = 3; i < 8; ++i) mean += std::stod(fields[i]) / 5;
        before = mean - 25.25;
        text += '\n';
        for (std::size_t i = 0; i < fields.size(); ++i) text += (i > 0 ? "," : "") + fields[i];
      }
      std::ofstream(file.path()) << text << '\n';
    }
  }

  /// R2 of a cycle ahead with own errors and the rooms' mean.
  double share(const nlohmann::json& found, const char* model) const {
    for (const nlohmann::json& f : found["figures"]) {
      if (f["ahead"] == 1 && f["groups"] == "rooms' mean" && f["model"] == model && f["scenario"] == "all")
        return f["r2"].get<double>();
    }
    ADD_FAILURE() << found;
    return 0;
  }

  std::string python_;
  TemporaryFolder folder_, scratch_;
};

TEST_F(LearnResiduals, SaysWhatCanBeForetoldAndWhatIsChance) {
  for (const auto& [room, out] : {std::pair{"301-real", "learned"}, {"study-1", "tried"}}) {
    const Outcome o = collect(room, out);
    ASSERT_EQ(o.code, 0) << o.err;
  }
  const Outcome again = collect("study-1", "tried");
  EXPECT_NE(again.out.find("0 runs"), std::string::npos) << "what is there is left: " << again.out;
  for (const bool predictable : {true, false}) {
    for (const char* folder : {"learned", "tried"}) set_errors(folder, predictable);
    const Outcome o = learn({"learned", "--try", "tried", "--models", "linear", "--json"});
    ASSERT_EQ(o.code, 0) << o.err;
    const double found = share(nlohmann::json::parse(o.out), "linear");
    if (predictable) {
      EXPECT_GT(found, 0.9);
    } else {
      EXPECT_LT(found, 0.1);
    }
  }
}

TEST_F(LearnResiduals, RefusesRoomsThatItHasSeenAndFilesThatAreNone) {
  ASSERT_EQ(collect("301-real", "learned").code, 0);
  Outcome o = learn({"learned", "--try", "learned"});
  EXPECT_EQ(o.code, 2);
  EXPECT_NE(o.err.find("301-real: in both"), std::string::npos) << o.err;
  o = learn({"nowhere", "--try", "learned"});
  EXPECT_NE(o.err.find("nowhere: no table"), std::string::npos) << o.err;
  std::filesystem::create_directory(folder_.path() / "bad");
  std::ofstream(folder_.path() / "bad" / "summer_x_1.csv") << "time,a\n2021-08-01T00:00:00,b\n";
  o = learn({"bad", "--try", "learned"});
  EXPECT_EQ(o.code, 2);
  EXPECT_NE(o.err.find("summer_x_1.csv"), std::string::npos) << o.err;
}

}  // namespace
}  // namespace airside::tools
