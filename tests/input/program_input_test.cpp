// Broken input given to the built programs: each is refused with exit code 1 and a complaint that says where, what
// was found, what was expected and what to do; nothing but JSON on standard output with --json; no file left behind.

#include <nlohmann/json.hpp>

#include "input/program_input_cases.hpp"
#include "sim/energyplus/install.hpp"

namespace airside {
namespace {

using broken::Case;
using hal::Complaint;

const std::vector<Case>& cases() {
  static const std::vector<Case> all = [] {
    std::vector<Case> list;
    for (const auto& part : {broken::sites, broken::point_maps, broken::wrong_words, broken::logs,
                             broken::weather_files, broken::engine_weather, broken::rooms, broken::models,
                             broken::foreign_models, broken::blobs, broken::blobs_of_wrong_content}) {
      const std::vector<Case> more = part();
      list.insert(list.end(), more.begin(), more.end());
    }
    return list;
  }();
  return all;
}

void expect_said(const Complaint& want, const Said& said, const std::string& all) {
  EXPECT_FALSE(said.place.empty() || said.found.empty() || said.expected.empty() || said.remedy.empty()) << all;
  EXPECT_NE(said.place.find(want.place), std::string::npos) << all;
  EXPECT_NE(said.found.find(want.found), std::string::npos) << all;
  EXPECT_NE(said.expected.find(want.expected), std::string::npos) << all;
  EXPECT_NE(said.remedy.find(want.remedy), std::string::npos) << all;
}

class ProgramInput : public testing::TestWithParam<Case> {};

TEST_P(ProgramInput, IsRefusedWithACompleteComplaintAndLeavesNoFile) {
  const Case& c = GetParam();
  if (c.engine && !sim::have_energyplus()) {
    GTEST_SKIP() << "NOT CHECKED: EnergyPlus is not installed, its schema is needed; run tools/setup";
  }
  const Desk desk;
  c.prepare(desk);
  if (HasFatalFailure()) return;
  std::vector<std::string> words = Desk::split(c.command);
  const std::string program = words.front() == "airsided" ? "airsided" : "airside";
  if (program == "airsided") words.erase(words.begin());
  const std::set<std::string> before = names_in(desk.folder());

  const Outcome plain = desk.run(program, words);
  EXPECT_EQ(plain.code, 1) << plain.err;
  // `check` prints its list, complaints included, on standard output.
  expect_said(c.want, complaint_in(plain.err.find(": found ") == std::string::npos ? plain.out : plain.err),
              plain.out + plain.err);
  EXPECT_EQ(names_in(desk.folder()), before);
  if (program == "airsided") return;

  words.push_back("--json");
  const Outcome machine = desk.run(program, words);
  EXPECT_EQ(machine.code, 1) << machine.err;
  EXPECT_EQ(names_in(desk.folder()), before);
  if (machine.out.empty()) return;
  const auto object = nlohmann::json::parse(machine.out, nullptr, false);
  ASSERT_TRUE(object.is_object()) << machine.out;
  EXPECT_FALSE(object.value("ok", true)) << machine.out;
}

INSTANTIATE_TEST_SUITE_P(Table, ProgramInput, testing::ValuesIn(cases()),
                         [](const auto& test) { return std::string(test.param.name); });

TEST(TwinOfASite, IsNotDroppedWhereThereIsNoEngine) {
  const Desk desk;
  desk.site();
  desk.write("site.toml", text_of_file(desk.path("site.toml")) + "[twin]\nmodel = \"m.epJSON\"\n");
  const std::string without = "AIRSIDE_ENERGYPLUS=/nonexistent exec $airside pretrain --days 2 --updates 1 ";
  const std::set<std::string> before = names_in(desk.folder());
  const Outcome by_option = desk.shell(without + "--twin m.epJSON -o x.blob");
  EXPECT_EQ(by_option.code, 1);
  expect_said({"--twin m.epJSON", "no EnergyPlus", "EnergyPlus 25.2", "run tools/setup"}, complaint_in(by_option.err),
              by_option.err);
  const Outcome by_site = desk.shell(without + "--site site.toml -o x.blob");
  EXPECT_EQ(by_site.code, 1);
  expect_said({"site.toml: [twin]", "no EnergyPlus", "EnergyPlus 25.2", "--room"}, complaint_in(by_site.err),
              by_site.err);
  EXPECT_EQ(names_in(desk.folder()), before);
  EXPECT_EQ(desk.shell(without + "--site site.toml --room 301 -o x.blob").code, 0);
}

TEST(EngineOfAProgramElsewhere, IsSaidToBeLookedForAboveIt) {
  const Desk desk;
  fs::create_directories(desk.path("away/bin"));
  fs::copy_file(fs::path(AIRSIDE_BIN_DIR) / "airside", desk.path("away/bin/airside"));
  const Outcome o = desk.shell("unset AIRSIDE_VENV AIRSIDE_ENERGYPLUS; AIRSIDE_MODELS=" + sim::find_models().string() +
                               " exec away/bin/airside pretrain --plant energyplus --days 2 --updates 1 -o x.blob");
  if (o.code == 0) GTEST_SKIP() << "NOT CHECKED: this build has the path of its sources in the program";
  EXPECT_EQ(o.code, 1);
  expect_said({"EnergyPlus engine", "away/bin", "the engine of EnergyPlus 25.2", "run tools/setup"},
              complaint_in(o.err), o.err);
}

/// What `airside pretrain --json` says it trained on.
std::string trained_on(const Desk& desk, const std::string& words) {
  const Outcome o = desk.shell("exec $airside pretrain --days 2 --updates 1 -o x.blob --json " + words);
  const auto object = nlohmann::json::parse(o.out, nullptr, false);
  return object.is_object() ? object.value("plant", "") : o.err;
}

TEST(TwinOfASite, IsWhatPretrainingTakes) {
  const Desk desk;
  desk.site();
  const std::string site = text_of_file(desk.path("site.toml"));
  desk.weather();
  desk.write("site.toml", site + "[twin]\nmodel = \"rc\"\nweather = \"w.epw\"\n");
  const std::string rc = trained_on(desk, "--site site.toml");
  EXPECT_NE(rc.find("RC room"), std::string::npos) << rc;
  EXPECT_NE(rc.find("w.epw"), std::string::npos) << rc;
  if (!sim::have_energyplus()) GTEST_SKIP() << "NOT CHECKED: EnergyPlus is not installed; run tools/setup";
  fs::copy_file(sim::find_models() / "twin.epJSON", desk.path("own.epJSON"));
  desk.write("p.json", "{\"Building\": {\"Airside Twin\": {\"north_axis\": 10}}}");
  desk.write("site.toml", site + "[twin]\nmodel = \"own.epJSON\"\npatches = [\"p.json\"]\nweather = \"w.epw\"\n");
  const std::string own = trained_on(desk, "--site site.toml");
  EXPECT_NE(own.find("EnergyPlus 25.2, twin (own.epJSON + "), std::string::npos) << own;
  EXPECT_NE(own.find("p.json), weather w.epw"), std::string::npos) << own;
  const std::string other = trained_on(desk, "--site site.toml --room 401");
  EXPECT_EQ(other.find("own.epJSON"), std::string::npos) << other;
  EXPECT_NE(other.find("room_401.patch.json), weather w.epw"), std::string::npos) << other;
}

constexpr const char* simulated = "simulate --plant rc --method expert --expert-days 0 --days 2";

TEST(LostOutput, IsNoSuccess) {
  const Desk desk;
  for (const std::string words : {"footprint", "footprint --json", "gap effects --json"}) {
    const Outcome o = desk.shell("exec $airside " + words + " >/dev/full");
    EXPECT_EQ(o.code, 1) << words << o.err;
    EXPECT_NE(o.err.find("No space left on device"), std::string::npos) << words << o.err;
  }
  const Outcome help = desk.shell("exec $airside --help >/dev/full");
  EXPECT_EQ(help.code, 1);
  EXPECT_NE(help.err.find("standard output"), std::string::npos) << help.err;
  const Outcome o = desk.shell(std::string("exec $airside ") + simulated + " --json >/dev/full");
  EXPECT_EQ(o.code, 1);
  expect_said({"standard output", "full", "the whole answer", "run again"}, complaint_in(o.err), o.err);
}

TEST(LostOutput, IsSeenBeforeALongRun) {
  const Desk desk;
  for (const char* words :
       {"pretrain --plant rc --days 300 -o no/x.blob", "pretrain --plant rc --days 300 -o /dev/null",
        "pretrain --plant rc --days 300 -o x.blob --log no/y.csv",
        "simulate --plant rc --method expert --days 300 --log no/y.csv"}) {
    const Outcome o = desk.shell(std::string("exec $airside ") + words);
    EXPECT_EQ(o.code, 1) << words;
    EXPECT_EQ(o.err.find("started"), std::string::npos) << words << o.err;
    EXPECT_TRUE(o.err.find("no/") != std::string::npos || o.err.find("/dev/null") != std::string::npos) << o.err;
    EXPECT_TRUE(names_in(desk.folder()).empty()) << words;
  }
}

TEST(LostOutput, LeavesNoLogThatIsCut) {
  const Desk desk;
  desk.write("y.csv", "time, of before\n");
  const Outcome o = desk.shell(std::string("ulimit -f 50; exec $airside ") + simulated + " --log y.csv");
  EXPECT_EQ(o.code, 1) << o.err;
  expect_said({"y.csv", "cannot be written: File too large", "free space", "make room"}, complaint_in(o.err), o.err);
  EXPECT_EQ(text_of_file(desk.path("y.csv")), "time, of before\n");
  EXPECT_EQ(names_in(desk.folder()), std::set<std::string>{"y.csv"});
}

TEST(LostOutput, LeavesNoStudyThatIsCut) {
  const Desk desk;
  const std::string study =
      "exec $airside study rooms --plant rc --rooms 301 --seeds 1 --methods expert,floor-frozen --no-paper "
      "--pretrain-days 2 --expert-days 1 --days 1 --updates 1 --steps 1 -o s.json";
  const Outcome o = desk.shell("ulimit -f 4; " + study);
  EXPECT_EQ(o.code, 1) << o.err;
  EXPECT_NE(o.err.find("File too large"), std::string::npos) << o.err;
  EXPECT_TRUE(names_in(desk.folder()).empty());
  EXPECT_EQ(desk.shell(study).code, 0);
  EXPECT_EQ(names_in(desk.folder()), std::set<std::string>{"s.json"});
  EXPECT_TRUE(nlohmann::json::parse(text_of_file(desk.path("s.json")), nullptr, false).is_object());
}

TEST(Serve, SaysInOneObjectWhatItServesAndWhere) {
  const Desk desk;
  const Outcome o = desk.shell(
      "$airside serve --plant rc --days 1 --port 0 --ready r --json & server=$!; n=0; "
      "while [ ! -e r ] && [ $n -lt 200 ]; do sleep 0.05; n=$((n + 1)); done; kill $server; wait $server");
  EXPECT_EQ(o.code, 0) << o.err;
  const auto object = nlohmann::json::parse(o.out, nullptr, false);
  ASSERT_TRUE(object.is_object()) << o.out << o.err;
  EXPECT_EQ(object.value("address", "") + "\n", text_of_file(desk.path("r")));
  EXPECT_EQ(object.value("from", ""), "2021-08-01T00:00:00");
  EXPECT_EQ(names_in(desk.folder()), std::set<std::string>{"r"});
}

TEST(Demo, RefusesWordsThatItDoesNotKnow) {
  const Desk desk;
  for (const std::string words : {"--plnat rc", "--plant mars", "--plant", "rc", "--plant rc twice"}) {
    // Without tools on its path it could not begin to install or build.
    const Outcome o = desk.shell("PATH=/nonexistent exec /bin/bash " AIRSIDE_SOURCE_DIR "/tools/demo " + words);
    EXPECT_EQ(o.code, 2) << words << o.out << o.err;
    EXPECT_NE(o.err.find("usage: tools/demo [--plant rc|energyplus]"), std::string::npos) << words << o.err;
  }
}

TEST(ProgramInputTable, HasAtLeastSixtyCases) { EXPECT_GE(cases().size(), 60u); }

TEST(ProgramInputTable, TheFilesThatCasesBreakAreAcceptedWhole) {
  const Desk desk;
  desk.site();
  desk.blob();
  desk.weather();
  desk.write("room.json", "{\"shgc\": 0.4}");
  const Outcome o = desk.run("airside", Desk::split("check site.toml --log log.csv --weights a.blob --weather w.epw "
                                                    "--room-file room.json --json"));
  EXPECT_EQ(o.code, 0) << o.out << o.err;
  const auto object = nlohmann::json::parse(o.out);
  EXPECT_TRUE(object["ok"]);
  EXPECT_EQ(object["checked"].size(), 8u);
}

}  // namespace
}  // namespace airside
