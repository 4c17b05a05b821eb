// tools/learn_posterior writes the posterior's formula a second time: both must say the same of the same verdict, and
// what it learns from cases must be better than what it began with.

#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>
#include <random>

#include "support/program.hpp"
#include "tools/gap/inference/posterior.hpp"
#include "tools/gap/verdict/verdict_json.hpp"

namespace airside::tools::gap {
namespace {

using Json = nlohmann::json;

std::string python_of_venv() {
  const char* venv = std::getenv("AIRSIDE_VENV");
  return (venv != nullptr ? std::string(venv) : std::string(AIRSIDE_SOURCE_DIR) + "/build/venv") + "/bin/python";
}

class LearnPosterior : public ::testing::Test {
 protected:
  LearnPosterior() {
    for (const char* name : {"leak", "sun", "mass"}) {
      sim::Effect e;
      e.name = name;
      e.low = -1;
      e.high = 2;
      e.null_value = 0;
      e.least = e.name == "mass" ? 0.3 : 0;
      effects_.push_back(e);
    }
    Json list = Json::array();
    for (const sim::Effect& e : effects_)
      list.push_back({{"name", e.name}, {"low", e.low}, {"high", e.high}, {"null", e.null_value}, {"least", e.least}});
    write("effects.json", {{"effects", list}});
    const PosteriorModel& m = PosteriorModel::learned();
    write("constants.json", {{"temperature", m.temperature},
                             {"temperature_gain", m.temperature_gain},
                             {"null_share", m.null_share},
                             {"place_share", m.place_share},
                             {"small_power", m.small_power},
                             {"too_small", m.too_small},
                             {"nothing", m.nothing},
                             {"other", m.other},
                             {"other_left", m.other_left},
                             {"shape_share", m.shape_share},
                             {"other_overlap", m.other_overlap},
                             {"locked_share", m.locked_share},
                             {"stray", m.stray}});
  }
  void SetUp() override {
    if (Outcome o = python({"-c", "import numpy, scipy"}); o.code != 0)
      GTEST_SKIP() << "NOT TESTED: numpy or scipy is missing; run tools/setup --for test, or set AIRSIDE_VENV";
  }

  void write(const std::string& name, const Json& content) const { std::ofstream(folder_.path() / name) << content; }
  Outcome python(std::vector<std::string> words) const {
    return run_program(python_of_venv(), std::move(words), folder_.path(), scratch_.path());
  }
  Outcome learn(std::vector<std::string> words) const {
    words.insert(words.begin(), std::string(AIRSIDE_SOURCE_DIR) + "/tools/learn_posterior");
    return python(std::move(words));
  }
  Alternatives tried(double leak, double sun, double mass) const {
    Alternatives all;
    all.residual_ratio = 1.4;
    all.residual_ratio_chance = 1.5;
    const double gains[] = {leak, sun, mass};
    for (std::size_t i = 0; i < 3; ++i) {
      Alternative a;
      a.at = {&effects_[i], 0};
      a.magnitude = i == 0 ? 0.05 : -0.2;
      a.sd = 0.1;
      a.log_likelihood_ratio = gains[i];
      a.of_reference = 3;
      a.residual_ratio = 1.2;
      a.overlap = i == 2 ? 0 : 0.6;
      a.places = i == 1 ? 5 : 1;
      a.simulated = true;
      a.locked = i != 2;
      a.locked_log_likelihood_ratio = gains[i] / 5;
      a.locked_expected = gains[i] / 4;
      all.list.push_back(a);
    }
    return all;
  }
  Json verdict_of(const Alternatives& all, const std::string& name) const {
    Verdict v;
    v.alternatives = {all};
    v.posteriors = {posterior_of(all)};
    return json_of(v, name, {}, {2, 0, 1});
  }

  std::vector<sim::Effect> effects_;
  TemporaryFolder folder_, scratch_;
};

TEST_F(LearnPosterior, SaysWhatTheProgramSaysOfTheSameVerdict) {
  Json verdicts = Json::array(), cases = Json::object();
  std::vector<Json> said;
  for (const auto& [leak, sun] : std::vector<std::pair<double, double>>{{0, 0}, {40, 31}, {300, 280}, {20, 4000}}) {
    const std::string name = "case-" + std::to_string(said.size());
    verdicts.push_back(verdict_of(tried(leak, sun, 25), name));
    said.push_back(verdicts.back()["posterior"][0]);
    cases[name] = {{"set", "single"}, {"ratio", 1}, {"hidden", Json::array({{{"id", "leak"}}})}};
  }
  write("verdicts.json", {{"verdicts", verdicts}});
  write("key.json", {{"cases", cases}});
  const Outcome o = learn({"effects.json", "--cases", "verdicts.json", "key.json", "--given", "constants.json"});
  ASSERT_EQ(o.code, 0) << o.err;
  const Json answers = Json::parse(o.out)["probabilities"];
  ASSERT_EQ(answers.size(), said.size());
  for (std::size_t i = 0; i < said.size(); ++i) {
    for (const char* name : {"nothing", "other"})
      EXPECT_NEAR(answers[i][name].get<double>(), said[i][name].get<double>(), 1e-12) << i << name;
    for (const Json& c : said[i]["candidates"])
      EXPECT_NEAR(answers[i][c["id"].get<std::string>()].get<double>(), c["probability"].get<double>(), 1e-12)
          << i << c;
  }
}

/// Cases in which a gain is worth a quarter of what it says: the best of two is the truth as often as that tells.
TEST_F(LearnPosterior, LearnsWhatAGainIsWorth) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> uniform(0, 1);
  Json verdicts = Json::array(), cases = Json::object();
  for (int i = 0; i < 60; ++i) {
    const double ahead = 60 * uniform(random);
    const bool leads = uniform(random) < 1 / (1 + std::exp(-ahead / 8));
    const std::string name = "case-" + std::to_string(i);
    verdicts.push_back(verdict_of(tried(100 + ahead, 100, 0), name));
    cases[name] = {{"set", "single"}, {"ratio", 1}, {"hidden", Json::array({{{"id", leads ? "leak" : "sun"}}})}};
  }
  write("verdicts.json", {{"verdicts", verdicts}});
  write("key.json", {{"cases", cases}});
  const Outcome o = learn({"effects.json", "--cases", "verdicts.json", "key.json", "--held-out", "verdicts.json",
                           "key.json", "--folds", "3"});
  ASSERT_EQ(o.code, 0) << o.err;
  const Json j = Json::parse(o.out);
  EXPECT_EQ(j["learned from"], j["held out"]);
  const Json& row = j["learned from"]["sets"]["single 1x"];
  EXPECT_EQ(row["questions"], 60);
  EXPECT_GE(row["set holds"].get<int>(), 51) << row;
  EXPECT_LE(row["wrong"].get<int>(), 3) << row;
}

TEST_F(LearnPosterior, SaysWhatIsWrongWithItsFiles) {
  write("verdicts.json", {{"verdicts", Json::array({verdict_of(tried(1, 2, 3), "case-1")})}});
  write("key.json", {{"cases", Json::object()}});
  const Outcome other = learn({"effects.json", "--cases", "verdicts.json", "key.json"});
  EXPECT_EQ(other.code, 1);
  EXPECT_NE(other.err.find("case-1, which key.json does not have; give the key"), std::string::npos) << other.err;
  const Outcome nowhere = learn({"effects.json", "--cases", "nowhere.json", "key.json"});
  EXPECT_EQ(nowhere.code, 1);
  EXPECT_NE(nowhere.err.find("nowhere.json"), std::string::npos) << nowhere.err;
  write("none.json", {{"verdicts", Json::array()}});
  EXPECT_NE(learn({"effects.json", "--cases", "none.json", "key.json"}).err.find("no posterior"), std::string::npos);
}

}  // namespace
}  // namespace airside::tools::gap
