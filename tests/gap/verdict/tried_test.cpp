// airside gap --try: a user's own suspicion, true, false, of the wrong size, or too small to be seen.

#include <gtest/gtest.h>

#include <algorithm>

#include "gap/gap_desk.hpp"

namespace airside::tools::gap {
namespace {

/// Box 2 has half its flow.
json tried(const json& j, const std::string& id) {
  const auto found = std::find_if(j["tried"].begin(), j["tried"].end(), [&](const json& t) { return t["id"] == id; });
  return found == j["tried"].end() ? json() : *found;
}

TEST(GapTry, SpeaksForATrueSuspicionAgainstAFalseOneAndCannotTellOneThatWouldNotShow) {
  const GapDesk desk;
  const Outcome o = desk.run(std::string(usual_words) +
                             " --out out --json --try vav_flow@2=0.5 room_sensor_bias@1=1 infiltration=0.002");
  ASSERT_EQ(o.code, 0) << o.err;
  const json j = json::parse(o.out);
  ASSERT_EQ(j["tried"].size(), 3U);

  const json right = tried(j, "vav_flow@2");
  EXPECT_EQ(right["answer"], "for") << right.dump(1);
  EXPECT_GT(right["gain"].get<double>(), right["gain_limit"].get<double>());
  EXPECT_NEAR(right["gain"].get<double>(), j["effects"][0]["gain"].get<double>(), 40) << "the findings' yardstick";
  EXPECT_LE(right["best"]["interval"][0].get<double>(), 0.5);
  EXPECT_GE(right["best"]["interval"][1].get<double>(), 0.5);
  for (const char* days : {"fitted_days", "locked_days"}) {
    for (const char* figure : {"temp_rmse_k", "room_temp_cv_rmse_percent"}) {
      EXPECT_LT(right["with"][days][figure].get<double>(), 0.5 * right["without"][days][figure].get<double>())
          << days << figure;
      EXPECT_NEAR(right["with"][days][figure].get<double>(), right["found"][days][figure].get<double>(),
                  0.3 * right["without"][days][figure].get<double>());
    }
  }

  const json wrong = tried(j, "room_sensor_bias@1");
  EXPECT_EQ(wrong["answer"], "against") << wrong.dump(1);
  EXPECT_LT(wrong["gain"].get<double>(), 0);

  const json unseen = tried(j, "infiltration");
  EXPECT_EQ(unseen["answer"], "cannot tell") << unseen.dump(1);
  EXPECT_LT(unseen["gain_if_true"].get<double>(), unseen["gain_limit"].get<double>());

  EXPECT_EQ(j, desk.read("out/gap.json"));
  EXPECT_NE(j["command"].get<std::string>().find("--try vav_flow@2=0.5"), std::string::npos);
  const std::string page = text_of_file(desk.path("out/index.html"));
  for (const char* promised :
       {"You asked: vav_flow@2 = 0.5", "the log speaks for it", "the log speaks against it", "the log cannot tell"}) {
    EXPECT_NE(page.find(promised), std::string::npos) << promised;
  }
}

TEST(GapTry, RefusesTheWrongSizeOfTheRightEffectAndSaysWhichFits) {
  const GapDesk desk;
  const Outcome o = desk.run(std::string(usual_words) + " --out out --json --try vav_flow@2=0.9");
  ASSERT_EQ(o.code, 0) << o.err;
  const json t = tried(json::parse(o.out), "vav_flow@2");
  EXPECT_EQ(t["answer"], "against") << t.dump(1);
  EXPECT_GT(t["gain"].get<double>(), t["gain_limit"].get<double>()) << "half of the way is better than none of it";
  EXPECT_NEAR(t["best"]["magnitude"].get<double>(), 0.5, 0.05);
  EXPECT_LT(t["best"]["interval"][1].get<double>(), 0.9);
  EXPECT_NE(t["sentence"].get<std::string>().find("not at this size"), std::string::npos) << t["sentence"];
}

struct BadTry {
  const char *words, *found, *expected, *remedy;  ///< parts of the complaint
};

TEST(GapTry, PrintsEachSuspicionBesideNothingAndBesideWhatWasFound) {
  const GapDesk desk;
  const Outcome o = desk.run(std::string(usual_words) + " --out out --try vav_flow@2=0.5 infiltration=0.002");
  ASSERT_EQ(o.code, 0) << o.err;
  for (const char* promised :
       {"tried vav_flow@2 = 0.5: the log speaks for it: ", "\n  nothing ", "\n  what was found ",
        "\n  the size that fits best: ", "tried infiltration = 0.002 1/h: the log cannot tell: "}) {
    EXPECT_NE(o.out.find(promised), std::string::npos) << promised << " in\n" << o.out;
  }
}

TEST(GapTry, SaysWhatIsAllowedAndWhatIsNearest) {
  const GapDesk desk(4);
  const auto before = desk.names();
  const std::vector<BadTry> tries{
      {"vav_flwo@2=0.5", "no effect \"vav_flwo\"", "5 effects of rc room", "did you mean vav_flow?"},
      {"vav_flow@4=0.5", "place \"4\"", "vav_flow@1, vav_flow@2, vav_flow@3", "did you mean vav_flow@"},
      {"vav_flow=0.5", "no place", "vav_flow@1, vav_flow@2", "vav_flow@1"},
      {"infiltration@1=0.5", "place \"1\"", "infiltration", "did you mean infiltration?"},
      {"vav_flow@2", "no =", "EFFECT@PLACE=MAGNITUDE", "airside gap effects"},
      {"vav_flow@2=half", "no number", "EFFECT@PLACE=MAGNITUDE", "airside gap effects"},
      {"vav_flow@2=9", "9", "but not 1", "within bounds"},
      {"vav_flow@2=nan", "nan", "but not 1", "within bounds"},
      {"vav_flow@2=1", "changes nothing", "but not 1", "the size that you suspect"},
  };
  for (const BadTry& t : tries) {
    const Outcome o = desk.run(std::string(usual_words) + " --out out --try " + t.words);
    EXPECT_EQ(o.code, 1) << t.words;
    const Said c = complaint_in(o.err);
    EXPECT_EQ(c.place, std::string("airside: --try ") + t.words) << o.err;
    EXPECT_NE(c.found.find(t.found), std::string::npos) << o.err;
    EXPECT_NE(c.expected.find(t.expected), std::string::npos) << o.err;
    EXPECT_NE(c.remedy.find(t.remedy), std::string::npos) << o.err;
    EXPECT_EQ(desk.names(), before) << t.words;
  }
}

}  // namespace
}  // namespace airside::tools::gap
