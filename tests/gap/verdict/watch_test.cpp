// airside gap watch: a verdict every night, an alarm only where the same name comes again and again.

#include <gtest/gtest.h>

#include <map>

#include "gap/gap_desk.hpp"
#include "hal/text/civil_text.hpp"
#include "tools/gap/run/watch.hpp"

namespace airside::tools::gap {
namespace {

Night night_of(int day, const std::string& verdict, const std::string& effect) {
  return {{sim::civil_midnight(2021, 7, 1).seconds + day * seconds_per_day}, verdict, effect, "", false};
}

std::vector<bool> alarms(std::vector<Night> nights) {
  set_alarms(nights, 3);
  std::vector<bool> list;
  for (const Night& night : nights) list.push_back(night.alarm);
  return list;
}

TEST(GapWatch, AlarmsWhereTheSameNameStandsForNightsInARowAndNowhereElse) {
  const auto named = [](int day, const char* effect) { return night_of(day, "named", effect); };
  EXPECT_EQ(alarms({named(1, "a"), named(2, "a"), named(3, "a"), named(4, "a")}),
            (std::vector<bool>{false, false, true, true}));
  EXPECT_EQ(alarms({named(1, "a"), named(2, "b"), named(3, "a"), named(4, "a")}), std::vector<bool>(4, false));
  EXPECT_EQ(alarms({named(1, "a"), named(2, "a"), named(4, "a")}), std::vector<bool>(3, false)) << "a night is missing";
  EXPECT_EQ(alarms({named(1, "a"), night_of(2, "ambiguous", "a"), named(3, "a"), named(4, "a")}),
            std::vector<bool>(4, false));
}

TEST(GapWatch, ReadsBackWhatItWrote) {
  const Night night = night_of(3, "named", "vav_flow@2");
  const Night back = night_from(json_of(night), "file");
  EXPECT_EQ(back.end.seconds, night.end.seconds);
  EXPECT_EQ(back.effect, night.effect);
  EXPECT_THROW(night_from({{"end", "yesterday"}, {"verdict", ""}, {"effect", ""}, {"sentence", ""}}, "file"),
               hal::InputError);
  EXPECT_THROW(night_from({{"verdict", ""}}, "file"), hal::InputError);
}

TEST(GapWatch, FindsABoxAtHalfItsFlowAndKeepsItsNightsFromRunToRun) {
  const GapDesk desk;
  ASSERT_EQ(desk.run(std::string(usual_words) + " --out report").code, 0);
  const Outcome first =
      desk.run("watch measured.csv --report report --days 6 --nights 2 --stands 2 -o nights.json --json");
  ASSERT_EQ(first.code, 0) << first.err;
  const json j = json::parse(first.out);
  ASSERT_EQ(j["nights"].size(), 2U);
  EXPECT_EQ(j["nights"][1]["end"], "2021-07-17T00:00:00");
  for (const json& night : j["nights"]) EXPECT_EQ(night["effect"], "vav_flow@2") << night.dump();
  EXPECT_FALSE(j["nights"][0]["alarm"]);
  EXPECT_TRUE(j["alarm"]);
  EXPECT_EQ(j["alarms"], 1);
  EXPECT_EQ(desk.read("nights.json"), j);
  // Without that earlier night nothing would stand yet.
  const Outcome again = desk.run("watch measured.csv --report report --days 6 --stands 2 -o nights.json --json");
  ASSERT_EQ(again.code, 0) << again.err;
  EXPECT_EQ(json::parse(again.out), j);
  const Outcome fresh = desk.run("watch measured.csv --report report --days 6 --stands 2 -o fresh.json");
  EXPECT_NE(fresh.out.find("1 nights, 0 alarms; no alarm tonight"), std::string::npos) << fresh.out;
}

/// A log as a box keeps it: a file a day.
void write_daily(const GapDesk& desk, const std::string& log, const std::string& folder) {
  fs::create_directory(desk.path(folder));
  std::istringstream in(text_of_file(desk.path(log)));
  std::string header, line;
  std::getline(in, header);
  std::map<std::string, std::string> days;
  while (std::getline(in, line)) days[line.substr(0, 10)] += line + "\n";
  for (const auto& [day, rows] : days) desk.write(folder + "/" + day + ".csv", header + "\n" + rows);
}

TEST(GapWatch, SaysNothingOfDaysLikeTheReference) {
  const GapDesk desk;
  ASSERT_EQ(desk.run(std::string(usual_words) + " --out report").code, 0);
  write_daily(desk, "reference.csv", "daily");
  const Outcome o = desk.run("watch daily --report report --days 6 --nights 2 --stands 1 -o nights.json --json");
  ASSERT_EQ(o.code, 0) << o.err;
  const json j = json::parse(o.out);
  EXPECT_EQ(j["nights"].size(), 2U);
  EXPECT_EQ(j["alarms"], 0) << o.out;
}

TEST(GapWatch, RefusesTooShortALogAndAFileThatIsNoneOfItsOwn) {
  const GapDesk desk;
  ASSERT_EQ(desk.run(std::string(usual_words) + " --out report").code, 0);
  EXPECT_EQ(complaint_in(desk.run("watch measured.csv --report report --days 14 -o n.json").err).expected,
            "14 whole days at least");
  EXPECT_FALSE(fs::exists(desk.path("n.json")));
  desk.write("other.json", "{}");
  const Outcome o = desk.run("watch measured.csv --report report --days 6 -o other.json");
  EXPECT_EQ(o.code, 1);
  EXPECT_EQ(complaint_in(o.err).expected, "what airside gap watch wrote") << o.err;
  EXPECT_EQ(desk.read("other.json"), json::object());
}

}  // namespace
}  // namespace airside::tools::gap
