// Options that would change nothing are refused, and seeds in outputs are those that were typed.

#include <nlohmann/json.hpp>
#include <regex>
#include <set>

#include "input/program_desk.hpp"

namespace airside {
namespace {

constexpr const char* short_run = "simulate --plant rc --room 301-real --expert-days 0 --days 1 --log y.csv ";

bool names(const std::string& text, const std::string& part) { return text.find(part) != std::string::npos; }

struct Unheeded {
  const char* words;
  const char* option;
  const char* beside;
};

void expect_refused(const Desk& desk, const std::string& words, const Unheeded& u) {
  SCOPED_TRACE(words);
  const Outcome o = desk.run("airside", Desk::split(words));
  EXPECT_EQ(o.code, 1) << o.out;
  const Said said = complaint_in(o.err);
  EXPECT_TRUE(names(said.place, u.option)) << o.err;
  EXPECT_TRUE(names(said.found, u.beside)) << o.err;
  EXPECT_TRUE(names(said.remedy, "leave")) << o.err;
  EXPECT_FALSE(fs::exists(desk.path("y.csv"))) << "refused before anything is computed";
}

TEST(SimulateOptions, ThatNoMethodOfTheRunHeedsAreRefusedByNameOfOptionAndMethod) {
  const Desk desk;
  desk.write("f.csv", "begin_h,for_h,fault,signal,magnitude\n2,6,stuck,room_temp_2,\n");
  for (const Unheeded& u : {Unheeded{"--method expert --weights a.blob", "--weights a.blob", "--method expert"},
                            {"--method pid-tuned --transfer", "--transfer", "--method pid-tuned"},
                            {"--method mpc --preset paper", "--preset paper", "--method mpc"},
                            {"--method expert --steps 5", "--steps 5", "--method expert"},
                            {"--method expert --steps 3000", "--steps 3000", "--method expert"},
                            {"--weights a.blob --steps 5", "--steps 5", "without --transfer"},
                            {"--method constant-22.5 --history h.csv", "--history h.csv", "--method constant-22.5"},
                            {"--method expert --compare floor-full --history h.csv", "--history", "floor-full"},
                            {"--method floor-frozen --faults f.csv", "--faults f.csv", "--method floor-frozen"}}) {
    expect_refused(desk, short_run + std::string(u.words), u);
  }
}

TEST(SimulateOptions, AreTakenWhereOneMethodOfTheRunHeedsThem) {
  const Desk desk;
  desk.make("simulate --plant rc --room 301-real --method varied --expert-days 0 --days 2 --log h.csv");
  desk.write("f.csv", "begin_h,for_h,fault,signal,magnitude\n2,6,stuck,room_temp_2,\n");
  desk.make(short_run + std::string("--method arx-rls --history h.csv"));
  desk.make(short_run + std::string("--method expert --compare integral-tuned --history h.csv"));
  desk.make(short_run + std::string("--method expert --compare floor-frozen --faults f.csv"));
  desk.make(
      "simulate --plant rc --room 301-real --expert-days 2 --days 1 --method expert --compare ours --transfer "
      "--steps 1 --preset paper --log y.csv");
}

TEST(PlantOptions, ThatThePlantOrTheSiteDoesNotHeedAreRefused) {
  const Desk desk;
  desk.site();
  desk.weather();
  desk.write("site.toml", text_of_file(desk.path("site.toml")) + "[twin]\nmodel = \"rc\"\nweather = \"w.epw\"\n");
  const std::string expert = "simulate --method expert --expert-days 0 --days 1 --log y.csv ";
  for (const Unheeded& u : {Unheeded{"--plant rc --site site.toml --topology 3vav-0fcu-1power", "--topology", "--site"},
                            {"--plant energyplus --site site.toml --twin", "--twin", "--plant energyplus"},
                            {"--environment e.json --room 301-real", "--room", "--environment"}}) {
    expect_refused(desk, expert + u.words, u);
  }
}

// ---- Seeds

/// Every number behind "seed" in a text.
std::set<std::string> seeds_in(const std::string& text) {
  static const std::regex seed("seeds?\\W{1,4}(\\d+)");
  std::set<std::string> found;
  for (std::sregex_iterator i(text.begin(), text.end(), seed), end; i != end; ++i) found.insert((*i)[1]);
  return found;
}

TEST(Seeds, InOutputsReportsAndWeatherAreThoseThatWereTyped) {
  const Desk desk;
  const std::set<std::string> typed{"37"};
  const Outcome o = desk.run(
      "airside", Desk::split("simulate --plant rc --room 301-real --method expert --expert-days 0 --days 1 --seed 37 "
                             "--log log.csv --report rep --json"));
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_EQ(seeds_in(o.out), typed) << o.out;
  const auto j = nlohmann::json::parse(o.out);
  EXPECT_TRUE(names(j["weather"], "year of room 301-real, seed 37")) << j["weather"];
  EXPECT_TRUE(names(j["plant"], ", seed 37")) << j["plant"];
  const std::string page = text_of_file(desk.path("rep/index.html"));
  EXPECT_EQ(seeds_in(page.substr(0, page.find("<h1>"))), typed);
  EXPECT_TRUE(names(page, "seed 37")) << "in the subtitle";
  const std::string weather = text_of_file(desk.path("log.epw"));
  EXPECT_EQ(seeds_in(weather.substr(0, weather.find("DATA PERIODS"))), typed);
  const Outcome table = desk.run("airside", Desk::split("simulate --plant rc --topology 5vav-0fcu-2power --room "
                                                        "modulating-mild-2 --method expert --expert-days 0 --days 1 "
                                                        "--seed 37"));
  ASSERT_EQ(table.code, 0) << table.err;
  EXPECT_EQ(seeds_in(table.out), typed) << table.out;
  const Outcome trained =
      desk.run("airside", Desk::split("pretrain --plant rc --days 2 --updates 1 --seed 37 -o a.blob --json"));
  EXPECT_EQ(seeds_in(trained.out), typed) << trained.out;
}

// ---- What is typed, before what is missing; each file and each method once

struct Mistake {
  const char *words, *place, *found, *expected, *remedy;
};

TEST(SimulateOptions, ThatAreWrongAreSaidBeforeMissingWeightsAndNothingIsWritten) {
  const Desk desk;
  desk.make("simulate --plant rc --method varied --expert-days 0 --days 1 --log h.csv");
  fs::create_symlink("h.csv", desk.path("link.csv"));
  const std::string past = text_of_file(desk.path("h.csv"));
  const std::string run = "simulate --plant rc --room 301-real --days 1 ";
  for (const Mistake& m : {
           Mistake{"--start 2021-13-01", "--start", "2021-13-01", "a date", "correct"},
           {"--weather nix.epw", "nix.epw", "no readable file", "EPW", "check the path"},
           {"--history nix.csv", "nix.csv", "no file", "CSV log", "check the path"},
           {"--method expert --compare expert", "--compare expert", "runs anyway", "each method once", "leave it out"},
           {"--compare ours", "--compare ours", "runs anyway", "each method once", "leave it out"},
           {"--compare expert,mpc,expert", "--compare expert", "twice", "each method once", "leave it out"},
           {"--method expert --log y.csv --history-log y.csv", "--history-log y.csv", "--log (y.csv)", "its own",
            "another name"},
           {"--method expert --log y.csv --history-log ./no/../y.csv", "--history-log", "--log (y.csv)", "its own",
            "another name"},
           {"--method mpc --history h.csv --log link.csv", "--log link.csv", "--history (h.csv)", "its own",
            "another name"},
           {"--method expert --log y.csv --history-log y.epw", "made-up weather", "--history-log (y.epw)", "its own",
            "another name"},
           {"--method expert --expert-days 0 --history-log y.csv", "--history-log y.csv", "--expert-days 0", "1 to 60",
            "leave"},
       }) {
    SCOPED_TRACE(m.words);
    const Outcome o = desk.run("airside", Desk::split(run + m.words));
    EXPECT_EQ(o.code, 1) << o.out;
    const Said said = complaint_in(o.err);
    EXPECT_TRUE(names(said.place, m.place) && names(said.found, m.found)) << o.err;
    EXPECT_TRUE(names(said.expected, m.expected) && names(said.remedy, m.remedy)) << o.err;
    EXPECT_FALSE(names(o.err, "started")) << "refused before anything runs";
    EXPECT_FALSE(fs::exists(desk.path("y.csv")) || fs::exists(desk.path("y.epw")));
  }
  EXPECT_EQ(text_of_file(desk.path("h.csv")), past);
}

// ---- Which days ran

TEST(Simulate, NamesScenarioAndControlledDaysAndAStartThatReplacesTheScenarios) {
  const Desk desk;
  const std::string run = "simulate --plant rc --method expert --expert-days 1 --days 2 ";
  const Outcome plain = desk.run("airside", Desk::split(run));
  ASSERT_EQ(plain.code, 0) << plain.err;
  EXPECT_TRUE(names(plain.out, "from 2021-08-02 to 2021-08-03, after 1 day under the schedule, no scenario"))
      << plain.out;
  EXPECT_FALSE(names(plain.err, "replaces"));
  const Outcome own = desk.run("airside", Desk::split(run + "--scenario january --json"));
  ASSERT_EQ(own.code, 0) << own.err;
  const auto j = nlohmann::json::parse(own.out);
  EXPECT_EQ(j["scenario"], "january");
  EXPECT_FALSE(names(own.err, "replaces")) << own.err;
  const Outcome other = desk.run("airside", Desk::split(run + "--scenario january --start 2021-02-27"));
  ASSERT_EQ(other.code, 0) << other.err;
  EXPECT_TRUE(names(other.out, "from 2021-02-28 to 2021-03-01")) << other.out;
  EXPECT_TRUE(names(other.out, "scenario january")) << other.out;
  EXPECT_NE(j["from"], "2021-02-28");
  EXPECT_TRUE(names(other.err, "note: --start 2021-02-27 replaces 2021-")) << other.err;
}

// ---- A site by a serial line, served

TEST(Serve, SaysThatASiteIsRtuWhereItServesTcpUnasked) {
  const Desk desk;
  desk.site();
  desk.edit("site.toml", "transport = \"tcp\"", "transport = \"rtu\"");
  const auto served = [&desk](const std::string& words) {
    const Outcome o =
        desk.shell("timeout -s TERM 60 $airside serve --site site.toml --plant rc --ready ready " + words +
                   " & p=$!; i=0; while [ ! -e ready ] && [ $i -lt 300 ]; do sleep 0.1; i=$((i+1)); "
                   "done; kill $p; wait $p; exit 0");
    EXPECT_TRUE(fs::exists(desk.path("ready"))) << o.err;
    fs::remove(desk.path("ready"));
    return o.err;
  };
  const std::string unasked = served("");
  for (const char* word : {"note: the transport of", "site.toml is rtu", "Modbus TCP on 127.0.0.1:", "--pty"})
    EXPECT_TRUE(names(unasked, word)) << unasked;
  EXPECT_FALSE(names(served("--port 0"), "is rtu")) << "TCP was asked for";
  EXPECT_FALSE(names(served("--pty line"), "is rtu"));
}

}  // namespace
}  // namespace airside
