// airside gap fit as a person runs it: a log and a site file in, a room file out; and what it says when it cannot.

#include <cmath>

#include "gap/gap_desk.hpp"
#include "sim/rc/rc_room_file.hpp"

namespace airside::tools::gap {
namespace {

TEST(FitCommand, WritesARoomThatFollowsTheLogBetterThanTheOneItStartedFrom) {
  const GapDesk desk(8);
  const Outcome o =
      desk.run("fit --site site.toml --measured measured.csv --weather w.epw -o room.json --locked-days 1 --json");
  ASSERT_EQ(o.code, 0) << o.err;
  const json j = json::parse(o.out);
  EXPECT_EQ(j["room"], "room.json");
  EXPECT_EQ(j["fitted_days"], 7);
  EXPECT_EQ(j["locked_days"], 1);
  EXPECT_LT(j["room_temp_locked_rmse_k"].get<double>(), 0.5 * j["room_temp_locked_rmse_start_k"].get<double>());
  ASSERT_GT(j["parameters"].size(), 10U);
  for (const json& p : j["parameters"]) {
    EXPECT_LE(p["interval"][0].get<double>(), p["estimate"].get<double>()) << p;
    EXPECT_GE(p["interval"][1].get<double>(), p["estimate"].get<double>()) << p;
    EXPECT_GE(p["told"].get<double>(), -1e-9) << p;
    EXPECT_LE(p["told"].get<double>(), 1) << p;
  }
  ASSERT_FALSE(j["channels"].empty());
  for (const json& c : j["channels"]) EXPECT_FALSE(c["unit"].get<std::string>().empty() && c["channel"] == "");

  // Half the flow of box 2 is in the log; the file is a room of the site's shape that has it.
  const sim::RcRoom room = sim::load_room(desk.path("room.json").string());
  EXPECT_EQ(room.vavs, 3);
  const auto flow = [&room](std::size_t i) { return room.vav_flow_m3_s[i] * room.vav_flow_calibration[i]; };
  EXPECT_LT(flow(1), 0.75 * flow(0));
  EXPECT_LT(flow(1), 0.75 * flow(2));
  EXPECT_NE(text_of_file(desk.path("room.json")).find("fitted to measured.csv"), std::string::npos);
}

TEST(FitCommand, StartsFromARoomAndPrintsATableForPeople) {
  const GapDesk desk(8);
  desk.write("start.json", R"({"base": "rc", "vavs": 3, "fcus": 0, "powers": 1, "gain_base_w_m2": 14})");
  const Outcome o = desk.run(
      "fit --site site.toml --measured measured.csv --weather w.epw -o room.json --locked-days 1 --start-room "
      "start.json");
  ASSERT_EQ(o.code, 0) << o.err;
  for (const char* promised : {"from the data", "locked start", "W/m2", "7 days fitted, 1 locked away", "room.json"}) {
    EXPECT_NE(o.out.find(promised), std::string::npos) << o.out;
  }
  EXPECT_EQ(sim::load_room(desk.path("room.json").string()).vavs, 3);
}

struct BadFit {
  const char *words, *place, *part;
  int code = 1;
};

TEST(FitCommand, RefusesWhatItCannotFitAndWritesNothing) {
  const GapDesk desk(5);
  desk.write("empty.csv", "");
  desk.write("file.txt", "x");
  const std::string whole = text_of_file(desk.path("measured.csv"));
  std::size_t end = 0;
  for (int line = 0; line < 2 * 240 + 5; ++line) end = whole.find('\n', end) + 1;
  desk.write("short.csv", whole.substr(0, end));
  desk.exchange("measured.csv", "room_temp_2_degc", "vav_on_1");  // after the short one was cut from it
  const auto before = desk.names();
  const std::string good = "--site site.toml --measured reference.csv --weather w.epw ";
  const std::vector<BadFit> requests{
      {"--site site.toml --weather w.epw", "", "--measured", 2},
      {"--site site.toml --measured reference.csv", "", "--weather", 2},
      {"--site site.toml --measured none.csv --weather w.epw", "none.csv", "no file that can be read"},
      {"--site site.toml --measured empty.csv --weather w.epw", "empty.csv", "expected"},
      {"--site site.toml --measured file.txt --weather w.epw", "file.txt", "expected"},
      {"--site site.toml --measured measured.csv --weather w.epw", "measured.csv", "each column under its own name"},
      {"--site site.toml --measured short.csv --weather w.epw", "short.csv", "log for longer"},
      {"--site site.toml --measured reference.csv --weather none.epw", "none.epw", "no readable file"},
      {"--site site.toml --measured reference.csv --weather w.epw -o room.txt", "--out room.txt", ".json"},
      {"--site site.toml --measured reference.csv --weather w.epw --start-room 301", "--start-room 301", "5 VAVs"},
      {"--site site.toml --measured reference.csv --weather w.epw --start-room 399", "399", "expected"},
      {"--site none.toml --measured reference.csv --weather w.epw", "none.toml", "no file that can be read"},
      {"--site site.toml --measured reference.csv --weather w.epw --locked-days 4", "reference.csv", "at least"},
  };
  for (const BadFit& r : requests) {
    const Outcome o = desk.run(std::string("fit ") + r.words);
    EXPECT_EQ(o.code, r.code) << r.words << "\n" << o.err;
    EXPECT_EQ(o.out, "") << r.words;
    EXPECT_NE(o.err.find(r.place), std::string::npos) << r.words << "\n" << o.err;
    EXPECT_NE(o.err.find(r.part), std::string::npos) << r.words << "\n" << o.err;
    EXPECT_EQ(desk.names(), before) << r.words;
  }
}

}  // namespace
}  // namespace airside::tools::gap
