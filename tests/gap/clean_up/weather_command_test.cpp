// What `airside gap` says where the weather beside a log is that of other days.

#include "gap/gap_desk.hpp"

namespace airside::tools::gap {
namespace {

/// Made-up years of other seeds; their spells of warm and cool days differ by `spells_k`.
void other_year(const GapDesk& desk, std::uint64_t seed, double spells_k) {
  sim::Climate climate;
  climate.day_temp_sd_k = spells_k;
  sim::write_epw(desk.path("other.epw").string(), *sim::synthetic_weather(seed, climate), 2021);
}

/// The remark on the weather; null where there is none.
json of_weather(const json& log) {
  for (const json& r : log["remarks"])
    if (r["defect"] == "other weather") return r;
  return nullptr;
}

bool said_in(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

TEST(GapWeather, OfAnotherYearIsAWarningOnTheTerminalInTheTableTheSentenceAndTheReport) {
  const GapDesk desk;
  other_year(desk, 9, 0.9);
  const Outcome o = desk.run(std::string(usual_words) + " --weather other.epw --buildings 0 --out out --json");
  ASSERT_EQ(o.code, 0) << o.err;
  const std::string warned = "outdoor temperatures of the log and of other.epw differ by ";
  EXPECT_TRUE(said_in(o.err, "measured.csv: " + warned)) << o.err;
  const json found = desk.read("out/gap.json");
  const json& log = found["clean_up"].back();
  const json remark = of_weather(log);
  ASSERT_TRUE(remark.is_object()) << log.dump(1);
  EXPECT_EQ(remark["action"], "warning");
  EXPECT_TRUE(said_in(remark["text"], "another year or another place?")) << remark["text"];
  EXPECT_TRUE(log["outdoor_difference"]["other_weather"].get<bool>());
  EXPECT_GT(log["outdoor_difference"]["rms_k"].get<double>(), 0.4);
  EXPECT_TRUE(said_in(found["sentence"], "other.epw is hardly the weather of the days of the log"))
      << found["sentence"];
  const std::string page = text_of_file(desk.path("out/index.html"));
  EXPECT_TRUE(said_in(page, warned)) << "the table";
  EXPECT_TRUE(said_in(page, "its sun, humidity and wind may be those of other days")) << "the headline";
}

TEST(GapWeather, OfItsOwnDaysIsNoWarningAndItsDifferenceIsInTheFile) {
  const GapDesk desk;
  const Outcome o = desk.run(std::string(usual_words) + " --buildings 0 --out out --json");
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_FALSE(said_in(o.err, "outdoor temperatures of the log"));
  const json found = desk.read("out/gap.json");
  for (const json& log : found["clean_up"]) {
    EXPECT_TRUE(of_weather(log).is_null()) << log.dump(1);
    EXPECT_LT(log["outdoor_difference"]["rms_k"].get<double>(), 0.1);
    EXPECT_FALSE(log["outdoor_difference"]["other_weather"].get<bool>());
  }
  EXPECT_FALSE(said_in(found["sentence"], "hardly the weather"));
}

TEST(GapWeather, OfDaysThatHaveNothingInCommonIsRefusedWithTheOption) {
  const GapDesk desk;
  other_year(desk, 9, 4);
  const Outcome o = desk.run(std::string(usual_words) + " --weather other.epw --out out");
  EXPECT_EQ(o.code, 1) << o.out;
  EXPECT_TRUE(said_in(o.err, "refused   other weather    outdoor_temp_degc")) << o.err;
  EXPECT_TRUE(said_in(o.err, "(--weather)")) << o.err;
  EXPECT_FALSE(fs::exists(desk.path("out/index.html")));
}

}  // namespace
}  // namespace airside::tools::gap
