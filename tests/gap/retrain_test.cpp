// airside gap retrain and airside gap --retrain as a person runs them: what a patched twin is worth to the controller.

#include "tools/gap/retrain/retrain.hpp"

#include <cmath>

#include "gap/gap_desk.hpp"
#include "hal/text/input_error.hpp"

namespace airside::tools::gap {
namespace {

/// The mean of `value` over the runs.
template <class Value>
double mean_over(const json& runs, const Value& value) {
  double sum = 0;
  for (const json& run : runs) sum += value(run);
  return sum / static_cast<double>(runs.size());
}

TEST(Retrain, ShowsWhatAnEffectInTheTwinIsWorthAndRepeatsItsFigures) {
  const GapDesk desk(2);
  const std::string words =
      "retrain --twin 301 --measured 301-real --effect occupancy_shift=2.25 --pretrain-days 10 --days 2 --json ";
  const Outcome o = desk.run(words + "--seeds 2");
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.err.find("2 twins x 2 seeds"), std::string::npos) << o.err;
  const json j = json::parse(o.out);
  EXPECT_EQ(j["seeds"], (json{1, 2}));
  EXPECT_EQ(j["preset"], "product");
  EXPECT_EQ(j["patched"]["changes"][0]["id"], "occupancy_shift");
  EXPECT_EQ(j["measured"]["changes"][0]["magnitude"], 2.25);
  EXPECT_EQ(j["patched_twin_stands_for_measured"], false);
  ASSERT_EQ(j["runs"].size(), 2U);
  for (const json& run : j["runs"]) {
    for (const char* when : {"before", "after"}) {
      const json& r = run[when];
      ASSERT_EQ(r["daily_dae_degc"].size(), 2U);
      const double one = r["daily_dae_degc"][0], two = r["daily_dae_degc"][1];
      EXPECT_NEAR(r["dae_degc"].get<double>(), (one + two) / 2, 1e-12);
      EXPECT_EQ(r["me_degc"].get<double>(), std::max(one, two));
      EXPECT_EQ(r["day1_dae_degc"].get<double>(), one);
      EXPECT_GT(r["darv_degc"].get<double>(), 0);
      EXPECT_LT(one, 1);
    }
    // People who come 2 h later: a controller that knows it is closer to target on the first day.
    EXPECT_LT(run["after"]["day1_dae_degc"].get<double>(), run["before"]["day1_dae_degc"].get<double>());
  }
  for (const char* key : {"dae_degc", "me_degc", "darv_degc", "day1_dae_degc"}) {
    const auto of = [key](const char* when) { return [=](const json& run) { return run[when][key].get<double>(); }; };
    const double before = mean_over(j["runs"], of("before")), after = mean_over(j["runs"], of("after"));
    EXPECT_NEAR(j["before"][key]["mean"].get<double>(), before, 1e-12);
    EXPECT_NEAR(j["after"][key]["mean"].get<double>(), after, 1e-12);
    EXPECT_NEAR(j["change"][key]["mean"].get<double>(), after - before, 1e-12);
    int lower = 0;
    for (const json& run : j["runs"]) lower += of("after")(run) < of("before")(run) ? 1 : 0;
    EXPECT_EQ(j["seeds_lower"][key], lower);
  }
  EXPECT_EQ(j["seeds_lower"]["day1_dae_degc"], 2);

  // A seed alone gives what it gave among others.
  const Outcome again = desk.run(words + "--seeds 1 --first-seed 2");
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(json::parse(again.out)["runs"][0], j["runs"][1]);
}

TEST(Retrain, ARoomFileWithNothingInItChangesNothing) {
  const GapDesk desk(2);
  desk.write("same.json", R"({"base": "301"})");
  const Outcome o = desk.run(
      "retrain --twin 301 --patched same.json --measured 301-real --seeds 1 --pretrain-days 3 --days 1 --preset paper");
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.out.find("+0.000 +- 0.000"), std::string::npos) << o.out;
  EXPECT_NE(o.out.find("DAE of the first day"), std::string::npos) << o.out;
  const Outcome figures = desk.run(
      "retrain --twin 301 --patched same.json --measured 301-real --seeds 1 --pretrain-days 3 --days 1 --json");
  ASSERT_EQ(figures.code, 0) << figures.err;
  const json run = json::parse(figures.out)["runs"][0];
  EXPECT_EQ(run["before"], run["after"]);
}

struct BadRooms {
  const char *words, *place, *part;
  int code = 1;
};

TEST(Retrain, SaysWhichRoomOrEffectIsWrong) {
  const GapDesk desk(2);
  desk.write("broken.json", R"({"base": "301", "gain_base_w_m2": )");
  desk.write("odd.json", R"({"base": "301", "gian_base_w_m2": 3})");
  desk.write("small.json", R"({"base": "rc", "vavs": 3, "fcus": 0, "powers": 1})");
  const auto before = desk.names();
  const std::vector<BadRooms> requests{
      {"--measured 301-real --patched odd.json", "", "--twin", 2},
      {"--twin 301 --measured 301-real", "--patched", "--effect ID=MAGNITUDE"},
      {"--twin 301 --measured 301-real --patched odd.json --effect infiltration=1", "--patched", "one of the two"},
      {"--twin 309 --measured 301-real --effect infiltration=1", "room", "309"},
      {"--twin 301 --measured none.json --effect infiltration=1", "none.json", "no readable file"},
      {"--twin 301 --measured 301-real --patched broken.json", "broken.json", "JSON"},
      {"--twin 301 --measured 301-real --patched odd.json", "odd.json", "gian_base_w_m2"},
      {"--twin 301 --measured 301-real --patched small.json", "small.json", "3 VAV"},
      {"--twin 301 --measured 301-real --effect infiltration", "--effect infiltration", "vav_flow@2=0.5"},
      {"--twin 301 --measured 301-real --effect infiltration=much", "--effect infiltration=much", "no number"},
      {"--twin 301 --measured 301-real --effect infiltration=99", "--effect infiltration=99", "-0.2 to 2.5 1/h"},
      {"--twin 301 --measured 301-real --effect vav_flow@6=0.5", "--effect vav_flow@6=0.5", "no such effect or place"},
      {"--twin 301 --measured 301-real --effect room_sensor_bias@1=1", "--effect room_sensor_bias@1=1", "sensors"},
      {"--twin 301 --measured 301-real --effect infiltration=1 --weather none.epw", "none.epw", "no readable file"},
      {"--twin 301 --measured 301-real --effect infiltration=1 --seeds 0", "", "--seeds", 2},
  };
  for (const BadRooms& r : requests) {
    const Outcome o = desk.run(std::string("retrain --pretrain-days 2 --days 1 ") + r.words);
    EXPECT_EQ(o.code, r.code) << r.words << "\n" << o.err;
    EXPECT_EQ(o.out, "") << r.words;
    EXPECT_NE(o.err.find(r.place), std::string::npos) << r.words << "\n" << o.err;
    EXPECT_NE(o.err.find(r.part), std::string::npos) << r.words << "\n" << o.err;
    EXPECT_EQ(o.err.find("2 twins"), std::string::npos) << "computed before it complained: " << r.words;
  }
  EXPECT_EQ(desk.names(), before);
}

/// The room in which the desk's logs were measured, as a file.
constexpr const char* hidden_room =
    R"({"base": "rc", "vavs": 3, "fcus": 0, "powers": 1, "vav_flow_calibration": [1, 0.5, 1]})";

TEST(Retrain, EndsTheWorkflowWithTheControllersFigures) {
  const GapDesk desk;
  desk.write("real.json", hidden_room);
  const std::string retrain = " --retrain --seeds 2 --pretrain-days 3 --control-days 2";
  const Outcome o = desk.run(std::string(usual_words) + retrain + " --measured-room real.json --out out --json");
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.err.find("pretraining on 2 twins x 2 seeds"), std::string::npos) << o.err;
  const json j = json::parse(o.out);
  ASSERT_EQ(j["verdict"], "named");
  EXPECT_EQ(j, desk.read("out/gap.json"));
  const json& r = j["retraining"];
  EXPECT_EQ(r["patched"]["room"], "out/patched-room.json");
  EXPECT_EQ(r["measured"]["room"], "real.json");
  EXPECT_EQ(r["patched_twin_stands_for_measured"], false);
  EXPECT_EQ(r["days"], 2);
  EXPECT_EQ(r["runs"].size(), 2U);
  EXPECT_NE(r["runs"][0]["before"], r["runs"][0]["after"]);
  const std::string page = text_of_file(desk.path("out/index.html"));
  for (const char* promised : {"What that is worth to the controller", "DAE day by day", "weights of the patched twin",
                               "room real.json", "seeds lower", "DAE, weights of the patched twin"}) {
    EXPECT_NE(page.find(promised), std::string::npos) << promised;
  }

  // The same figures from the files that it left, by the other command.
  const Outcome alone = desk.run(
      "retrain --site site.toml --twin rc --patched out/patched-room.json --measured real.json --weather w.epw "
      "--seeds 2 --pretrain-days 3 --days 2 --json");
  ASSERT_EQ(alone.code, 0) << alone.err;
  EXPECT_EQ(json::parse(alone.out)["runs"], r["runs"]);
}

TEST(Retrain, SaysThatThePatchedTwinPlaysTheRoomAndRetrainsOnTheFileThatWasApplied) {
  const GapDesk desk;
  const Outcome o = desk.run(std::string(usual_words) +
                             " --retrain --seeds 1 --pretrain-days 2 --control-days 1 --out out --apply patched.json");
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.out.find("weights of the twin"), std::string::npos) << o.out;
  EXPECT_NE(o.out.find("The patched twin plays the measured room"), std::string::npos) << o.out;
  const json r = desk.read("out/gap.json")["retraining"];
  EXPECT_EQ(r["patched"]["room"], "patched.json");
  EXPECT_EQ(r["measured"]["room"], "patched.json");
  EXPECT_EQ(r["patched_twin_stands_for_measured"], true);
  EXPECT_FALSE(fs::exists(desk.path("out/patched-room.json")));
  EXPECT_NE(text_of_file(desk.path("out/index.html")).find("The patched twin plays the measured room"),
            std::string::npos);
}

TEST(Retrain, ComplainsOfTheMeasuredRoomBeforeTheWorkAndOfNothingToRetrainAfterIt) {
  const GapDesk desk(6);
  desk.write("five.json", R"({"base": "301"})");
  const auto before = desk.names();
  const std::string words =
      "--site site.toml --measured reference.csv --reference-days 3 --effects effects --out out --retrain ";
  for (const auto& [room, part] : {std::pair{"five.json", "3 VAV"}, {"none.json", "no readable file"}}) {
    const Outcome o = desk.run(words + "--measured-room " + room);
    EXPECT_EQ(o.code, 1) << o.err;
    EXPECT_NE(o.err.find(room), std::string::npos) << o.err;
    EXPECT_EQ(o.err.find("simulating every effect"), std::string::npos) << o.err;
    EXPECT_EQ(desk.names(), before);
  }
  EXPECT_EQ(desk.run("--site site.toml --measured m.csv --measured-room 301").code, 2);
  const Outcome o = desk.run(words + "--seeds 1");
  EXPECT_EQ(o.code, 1) << o.out;
  EXPECT_EQ(complaint_in(o.err).place, "airside: --retrain") << o.err;
  EXPECT_TRUE(desk.read("out/gap.json")["retraining"].is_null());
}

}  // namespace
}  // namespace airside::tools::gap
