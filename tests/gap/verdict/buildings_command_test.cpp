// --buildings as a person gives it: to airside gap, to the cases of a folder, and to a report that is continued.

#include <gtest/gtest.h>

#include "gap/gap_desk.hpp"

namespace airside::tools::gap {
namespace {

/// The desk, with the last days of its log in a file of their own.
class BuildingsDesk : public GapDesk {
 public:
  static constexpr int first_days = 6;

  BuildingsDesk() : GapDesk(8) {
    const std::string all = text_of_file(path("measured.csv"));
    const auto header = all.find('\n') + 1;
    auto split = header;
    for (int row = 0; row < first_days * rows_per_day; ++row) split = all.find('\n', split) + 1;
    write("measured.csv", all.substr(0, split));
    write("more.csv", all.substr(0, header) + all.substr(split));
    fs::create_directories(path("cases/case-1"));
    write("cases/case-1/case.json", R"({"format": 1, "engine": "rc", "model": "rc", "weather": "../../w.epw",
      "reference": "../../reference.csv", "measured": "../../measured.csv", "topology": "3vav-0fcu-1power"})");
  }
};

void expect_drawn(const json& judged, int drawn) {
  ASSERT_TRUE(judged.contains("buildings"));
  const json& buildings = judged["buildings"];
  ASSERT_EQ(buildings["drawn"], drawn);
  EXPECT_GT(buildings["add"].get<double>(), 0);
  EXPECT_LT(buildings["add"].get<double>(), buildings["add_alone"].get<double>())
      << "what one building leaves, others foretell in part";
}

TEST(GapBuildings, CountInTheReportAndInEachThatContinuesIt) {
  const BuildingsDesk desk;
  const Outcome plain = desk.run(std::string(usual_words) + " --buildings 0 --out plain --json");
  ASSERT_EQ(plain.code, 0) << plain.err;
  EXPECT_EQ(json::parse(plain.out)["inputs"]["buildings"], 0);
  EXPECT_TRUE(json::parse(plain.out)["buildings"].is_null());

  const Outcome first = desk.run(std::string(usual_words) + " --buildings 6 --out first --json");
  ASSERT_EQ(first.code, 0) << first.err;
  const json judged = json::parse(first.out);
  EXPECT_EQ(judged["inputs"]["buildings"], 6);
  expect_drawn(judged, 6);
  EXPECT_EQ(judged["effects"][0]["id"], "vav_flow@2");
  EXPECT_NE(judged["best_gain"], json::parse(plain.out)["best_gain"]) << "they count";

  const Outcome next = desk.run("next first --measured more.csv --out second --json");
  ASSERT_EQ(next.code, 0) << next.err;
  const json continued = json::parse(next.out);
  EXPECT_EQ(continued["inputs"]["buildings"], 6);
  expect_drawn(continued, 6);
  EXPECT_EQ(continued["measured"]["days"], 8);
}

TEST(GapBuildings, AreDrawnOnAnRcRoomWithoutBeingAskedFor) {
  const BuildingsDesk desk;
  const Outcome o = desk.run(std::string(usual_words) + " --out usual --json");
  ASSERT_EQ(o.code, 0) << o.err;
  const json judged = json::parse(o.out);
  EXPECT_EQ(judged["inputs"]["buildings"], 96);
  expect_drawn(judged, 96);
  ASSERT_EQ(judged["posterior"].size(), 1U);
}

TEST(GapBuildings, CountInTheVerdictsOnCases) {
  const BuildingsDesk desk;
  const Outcome plain = desk.run("run-cases cases --buildings 0 -o plain.json --effects effects --json");
  ASSERT_EQ(plain.code, 0) << plain.err;
  EXPECT_TRUE(desk.read("plain.json")["verdicts"][0]["buildings"].is_null());
  const Outcome o = desk.run("run-cases cases --buildings 4 -o verdicts.json --effects effects --json");
  ASSERT_EQ(o.code, 0) << o.err;
  expect_drawn(desk.read("verdicts.json")["verdicts"][0], 4);
}

TEST(GapBuildings, LetThePosteriorDrawTheVerdict) {
  const BuildingsDesk desk;
  const Outcome o = desk.run("run-cases cases --buildings 4 -o verdicts.json --effects effects --json");
  ASSERT_EQ(o.code, 0) << o.err;
  const json judged = desk.read("verdicts.json")["verdicts"][0];
  EXPECT_EQ(judged["effects"][0]["id"], "vav_flow@2");
  const json& posterior = judged["posterior"][0];
  EXPECT_EQ(judged["verdict"] == "named", posterior["sure"].get<bool>());
  const std::string reason = judged["reason"];
  EXPECT_EQ(reason.rfind(posterior["sure"] ? "no other explanation is probable" : "not sure: vav_flow@2 ", 0), 0U)
      << reason;
}

TEST(GapBuildings, AreACountOfAThousandAtMost) {
  const BuildingsDesk desk;
  for (const char* bad : {"-1", "1001", "2.5", "many"}) {
    for (const std::string& words :
         {std::string(usual_words) + " --out out", std::string("run-cases cases -o v.json --effects effects")}) {
      const Outcome o = desk.run(words + " --buildings " + bad);
      EXPECT_NE(o.code, 0) << words << bad;
      EXPECT_NE(o.err.find("--buildings"), std::string::npos) << o.err;
      EXPECT_NE(o.err.find(bad), std::string::npos) << o.err;
    }
    EXPECT_FALSE(fs::exists(desk.path("out")));
    EXPECT_FALSE(fs::exists(desk.path("v.json")));
  }
}

}  // namespace
}  // namespace airside::tools::gap
