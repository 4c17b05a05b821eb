// Blind cases in which the proposed test is done: on the hidden room, within the site's envelope, without a word of
// what is hidden to whoever judges, and with a second verdict beside the first.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gap/gap_desk.hpp"
#include "support/default_cycle.hpp"
#include "tools/gap/blind/blind_cases.hpp"
#include "tools/gap/blind/blind_tests.hpp"
#include "tools/gap/blind/test_commands.hpp"
#include "tools/gap/case/case_tests.hpp"
#include "tools/gap/score/score.hpp"

namespace airside::tools::gap {
namespace {

constexpr sim::Channels tested_channels{5, 5, 2};
const CivilTime test_monday = sim::civil_midnight(2021, 6, 28);

SafetyEnvelope envelope_of(double min_degc, double max_degc, double change_k) {
  ControllerSettings settings = built_in_site().settings;
  settings.limit_min_degc = min_degc;
  settings.limit_max_degc = max_degc;
  settings.limit_change_k = change_k;
  return SafetyEnvelope(settings);
}

TEST(TestCommands, KeepTheEnvelopeWhateverPlanAndOperatorWant) {
  const auto effects = sim::load_effects(sim::find_effects());
  const SafetyEnvelope envelope = envelope_of(21, 25, 0.5);
  for (const TestPlan& plan : all_plans(tested_channels, effects)) {
    const TestDays days = next_days(plan, test_monday);
    const TestCommands commands({days}, envelope, test_monday);
    double last = 24, coldest = 50, warmest = 0;
    for (CivilTime t = test_monday; t < days.to; t.seconds += cycle_s) {
      const double usual = t.second_of_day() < 43200 ? 12.0 : 40.0;  // no operator is to be trusted
      const double sent = commands.setpoint_degc(t, usual, last);
      EXPECT_LE(std::abs(sent - last), 0.5 + 1e-9) << plan.name;
      coldest = std::min(coldest, sent);
      warmest = std::max(warmest, sent);
      last = sent;
    }
    EXPECT_EQ(coldest, 21) << plan.name;
    EXPECT_EQ(warmest, 25) << plan.name;
    EXPECT_EQ(commands.setpoint_degc({test_monday.seconds - cycle_s}, 12, 24), 12) << "before: the operator's own";
  }
}

TEST(TestCommands, CommandWhatThePlanSaysInItsHoursAndNothingElse) {
  const auto effects = sim::load_effects(sim::find_effects());
  const SafetyEnvelope wide = envelope_of(10, 40, 50);
  const TestDays purge = next_days(named_plan("night_purge", tested_channels, effects), test_monday);
  EXPECT_EQ(purge.from.seconds, test_monday.seconds + 2 * seconds_per_day);
  const TestCommands night({purge}, wide, test_monday);
  const auto at = [&purge](int day, int hour) {
    return CivilTime{purge.from.seconds + day * seconds_per_day + hour * 3600};
  };
  EXPECT_EQ(night.setpoint_degc(at(0, 21), 23, 23), 20);
  EXPECT_EQ(night.box(3, at(0, 21)), true);
  EXPECT_EQ(night.setpoint_degc(at(1, 3), 23, 23), 20);
  for (const CivilTime idle : {at(0, 3), at(1, 12), at(3, 3)}) {
    EXPECT_EQ(night.setpoint_degc(idle, 23, 23), 23);
    EXPECT_EQ(night.box(3, idle), std::nullopt);
  }
  const TestDays closed = next_days(named_plan("weekend_closed", tested_channels, effects), test_monday);
  EXPECT_EQ(closed.from.weekday(), 5);
  EXPECT_EQ(closed.to.seconds - closed.from.seconds, 2 * seconds_per_day);
  const TestCommands weekend({closed}, wide, test_monday);
  EXPECT_EQ(weekend.box(0, closed.from), false);
  EXPECT_EQ(weekend.fan_coil(4, closed.from), false);
  EXPECT_EQ(weekend.box(0, closed.to), std::nullopt);
  const TestCommands one({next_days(named_plan("fcu_on_night@3", tested_channels, effects), test_monday)}, wide,
                         test_monday);
  EXPECT_EQ(one.fan_coil(2, at(0, 21)), true);
  EXPECT_EQ(one.fan_coil(1, at(0, 21)), std::nullopt);
}

/// Two sealed cases of eight days, judged by a few effects.
class TestedDesk : public Desk {
 public:
  TestedDesk() {
    fs::create_directory(path("effects"));
    for (const char* name :
         {"gain_base", "gain_occupied", "infiltration", "envelope_u", "vav_flow", "duct_heat_gain"}) {
      fs::copy_file(sim::find_effects() / (std::string(name) + ".json"),
                    path("effects") / (std::string(name) + ".json"));
    }
    write("site.toml",
          "[site]\nname = \"Careful\"\ntopology = \"5vav-5fcu-2power\"\n[setpoint]\nmin_degc = 20\nmax_degc = "
          "26\nmax_change_k = 0.8\n");
    must(
        "blind --cases 2 --only single --hide infiltration,envelope_u --ratio 3 --seed 33 --days 8 --rough "
        "--window 3 --effects effects -o cases --key key.json");
  }
  json must(const std::string& words) const {
    const Outcome o = run(words + " --json");
    EXPECT_EQ(o.code, 0) << words << "\n" << o.err;
    return json::parse(o.out, nullptr, false);
  }
  std::map<std::string, std::string> files_of_cases() const {
    std::map<std::string, std::string> files;
    for (const auto& entry : fs::recursive_directory_iterator(path("cases"))) {
      if (entry.is_regular_file())
        files[fs::relative(entry.path(), path("cases")).string()] = text_of_file(entry.path());
    }
    return files;
  }
};

constexpr const char* do_tests = "test-cases cases --key key.json --effects effects --site site.toml";
constexpr const char* judge_again = "run-cases cases --effects effects --after-tests";

void expect_setpoints_within(const std::string& log, double low, double high, double most_change_k) {
  const hal::Log read = hal::read_log(log, {"", 5, 5, 2}, {hal::default_log_limits, true});
  double change = 0;
  for (std::size_t row = 0; row < read.rows.size(); ++row) {
    EXPECT_GE(read.rows[row].setpoint_degc, low) << log;
    EXPECT_LE(read.rows[row].setpoint_degc, high) << log;
    if (row > 0) change = std::max(change, std::abs(read.rows[row].setpoint_degc - read.rows[row - 1].setpoint_degc));
  }
  EXPECT_LE(change, most_change_k + 1e-9) << log;
  EXPECT_GT(change, 0.5 * most_change_k) << log << ": the limit was in the way";
}

void expect_nothing_betrayed(const TestedDesk& desk, const std::map<std::string, std::string>& before) {
  std::set<fs::file_time_type> times;
  for (const auto& entry : fs::recursive_directory_iterator(desk.path("cases"))) times.insert(entry.last_write_time());
  EXPECT_EQ(times.size(), 1U) << "the order of writing";
  for (const auto& [name, text] : desk.files_of_cases()) {
    if (before.contains(name)) {
      EXPECT_EQ(text, before.at(name)) << name;
      continue;
    }
    EXPECT_TRUE(name.ends_with("tests.json") || name.ends_with("test-1.csv")) << name;
    for (const char* word : {"infiltration", "duct_heat", "hidden", "seed", "ratio", "magnitude"})
      EXPECT_EQ(text.find(word), std::string::npos) << name << " says " << word;
    if (!name.ends_with("tests.json")) continue;
    const json tests = json::parse(text);
    EXPECT_EQ(tests["tests"].size(), 1U);
    EXPECT_EQ(tests["tests"][0].size(), 3U) << text;
  }
}

// One test, since each test is a process and would judge the cases again.
TEST(TestedCases, AreTestedWithinTheEnvelopeJudgedAnewAndScoredOnceEach) {
  const TestedDesk desk;
  desk.must("run-cases cases --effects effects --propose");
  const json first = desk.read("verdicts.json");
  const auto files = desk.files_of_cases();
  const json done = desk.must(do_tests);
  ASSERT_GE(done["tests"].size(), 1U) << done.dump() << first.dump();
  expect_nothing_betrayed(desk, files);
  const std::string tested = done["tests"][0]["case"];
  expect_setpoints_within(desk.path("cases/" + tested + "/test-1.csv").string(), 20, 26, 0.8);
  const auto tests = read_case_tests(desk.path("cases/" + tested));
  ASSERT_EQ(tests.size(), 1U);
  EXPECT_EQ(tests[0].name, done["tests"][0]["test"]);

  // A run that was ended goes on: what was done stays.
  const auto after_first = desk.files_of_cases();
  EXPECT_TRUE(desk.must(do_tests)["done"].empty());
  EXPECT_EQ(desk.files_of_cases(), after_first);

  desk.must(judge_again);
  json second = desk.read("verdicts.json");
  for (std::size_t i = 0; i < second["verdicts"].size(); ++i) {
    json one = second["verdicts"][i];
    const bool was_tested = fs::exists(desk.path("cases/" + one["case"].get<std::string>() + "/tests.json"));
    ASSERT_EQ(one.contains("after_tests"), was_tested);
    if (was_tested) {
      EXPECT_EQ(one["after_tests"].size(), 1U);
      EXPECT_EQ(one["after_tests"][0]["tests"].size(), 1U);
      EXPECT_NE(one["after_tests"][0]["verdict"], "refused") << one["after_tests"][0].dump();
      EXPECT_NE(one["after_tests"][0]["best_gain"], one["best_gain"]) << "the days of the test count";
      one.erase("after_tests");
    }
    EXPECT_EQ(one, first["verdicts"][i]) << "the first verdict stays as it was";
  }
  for (json& one : second["verdicts"]) {
    if (one.contains("after_tests")) one["after_tests"][0]["reason"] = "as it was";
  }
  desk.write("verdicts.json", second.dump());
  desk.must(judge_again);
  EXPECT_EQ(desk.read("verdicts.json"), second);
  EXPECT_TRUE(desk.must(do_tests)["done"].empty()) << "one test a case, unless more are asked for";

  const json scored = desk.must("score verdicts.json key.json");
  ASSERT_FALSE(scored["tests"].empty());
  const auto row = [&scored](const std::string& measure) {
    for (const json& one : scored["counts"]) {
      if (one["set"] == "single" && one["measure"] == measure && one["slice"] == "ratio 3") return one;
    }
    return json();
  };
  EXPECT_EQ(row("exact, 1 test")["n"], 2);
  EXPECT_GE(row("exact, 1 test")["k"], row("exact")["k"]);
  EXPECT_NE(desk.run("score verdicts.json key.json").out.find("without and with executed tests"), std::string::npos);
}

struct BadTests {
  const char *words, *place, *part;
};

TEST(TestedCases, RefuseMissingAndForeignKeysAndCasesThatWereNotJudged) {
  const TestedDesk desk;
  json open = {{"format", 1}, {"verdicts", json::array()}}, some = open, closed = open;
  for (const char* name : {"case-0001", "case-0002"}) {
    const json proposal = {{"name", "night_purge"}, {"comfortable", true}, {"power", 0.9}};
    open["verdicts"].push_back({{"case", name}, {"verdict", "ambiguous"}, {"experiments", {proposal}}});
    closed["verdicts"].push_back({{"case", name}, {"verdict", "ambiguous"}});
  }
  some["verdicts"].push_back(open["verdicts"][0]);
  desk.write("open.json", open.dump());
  desk.write("some.json", some.dump());
  desk.write("closed.json", closed.dump());
  json other = desk.read("key.json");
  other["seed"] = 32;
  desk.write("other.json", other.dump());
  other["cases"].erase("case-0002");
  desk.write("fewer.json", other.dump());
  const auto before = desk.files_of_cases();
  for (const BadTests& b : std::vector<BadTests>{
           {"test-cases cases --verdicts open.json --key no.json", "no.json", ""},
           {"test-cases cases --verdicts open.json --key open.json", "--key", "an answer key"},
           {"test-cases cases --verdicts open.json --key other.json", "case-000", "not those of the measured log"},
           {"test-cases cases --verdicts open.json --key fewer.json", "case-0002", "no such case"},
           {"test-cases cases --verdicts some.json --key key.json", "case-0002", "run-cases --propose --continue"},
           {"test-cases cases --verdicts closed.json --key key.json", "case-0001", "run-cases --propose"},
           {"test-cases cases --verdicts no.json --key key.json", "no.json", ""},
           {"run-cases cases -o no.json --after-tests", "no.json", "judge them first"},
       }) {
    const Outcome o = desk.run(std::string(b.words) + " --effects effects --json");
    EXPECT_EQ(o.code, 1) << b.words << "\n" << o.err;
    EXPECT_EQ(o.out, "") << b.words;
    EXPECT_NE(o.err.find(b.place), std::string::npos) << b.words << "\n" << o.err;
    EXPECT_NE(o.err.find(b.part), std::string::npos) << b.words << "\n" << o.err;
    EXPECT_EQ(desk.files_of_cases(), before) << b.words;
  }
  // Limits that the test would have to leave: it is passed over, and never done by half.
  desk.write("site.toml",
             "[site]\nname = \"Warm\"\ntopology = \"5vav-5fcu-2power\"\n[setpoint]\nmin_degc = 22\nmax_degc = 26\n");
  const json none =
      desk.must("test-cases cases --verdicts open.json --key key.json --effects effects --site site.toml");
  EXPECT_EQ(none["left"], (json{{"beyond the site's limits", 2}}));
  EXPECT_EQ(desk.files_of_cases(), before);
}

TEST(Score, CountsAfterAtMostOneExecutedTestBesideThePassiveVerdict) {
  const json passive = {{"case", "a"},
                        {"verdict", "ambiguous"},
                        {"effects", {{{"id", "infiltration"}, {"magnitude", 1}, {"margin", 1}}}}};
  json named = passive, wrong = passive;
  named["verdict"] = "named";
  named["tests"] = {"night_purge"};
  json after = passive;
  after["after_tests"] = {named};
  wrong["case"] = "b";
  wrong["after_tests"] = {{{"case", "b"},
                           {"verdict", "named"},
                           {"tests", {"night_purge"}},
                           {"effects", {{{"id", "gain_base"}, {"magnitude", 1}, {"margin", 1}}}}}};
  json untested = named;
  untested["case"] = "c";
  untested.erase("tests");
  json key = {{"format", 1}, {"cases", json::object()}};
  for (const char* name : {"a", "b", "c"})
    key["cases"][name] = {
        {"set", "single"}, {"engine", "rc"}, {"ratio", 3}, {"hidden", {{{"id", "infiltration"}, {"magnitude", 0.5}}}}};
  const std::map<std::string, double> null_of{{"infiltration", 0}, {"gain_base", 0}};
  const auto count = [](const ScoreTable& table, const std::string& measure) {
    for (const CountRow& row : table.counts) {
      if (row.set == "single" && row.measure == measure && row.slice == "ratio 3") return std::pair(row.k, row.n);
    }
    return std::pair(-1, -1);
  };
  const ScoreTable table = score({{"format", 1}, {"verdicts", {after, wrong, untested}}}, key, null_of);
  EXPECT_EQ(count(table, "exact"), std::pair(1, 3));
  EXPECT_EQ(count(table, "exact, 1 test"), std::pair(2, 3));
  EXPECT_EQ(count(table, "wrong name"), std::pair(0, 3));
  EXPECT_EQ(count(table, "wrong name, 1 test"), std::pair(1, 3));
  ASSERT_EQ(table.tests.size(), 1U);
  EXPECT_EQ(table.tests[0].test, "night_purge");
  EXPECT_EQ(table.tests[0].cases, 2);
  EXPECT_EQ(table.tests[0].exact, 1);
  EXPECT_EQ(table.tests[0].wrong, 1);
  after.erase("after_tests");
  wrong.erase("after_tests");
  const ScoreTable without = score({{"format", 1}, {"verdicts", {after, wrong, untested}}}, key, null_of);
  EXPECT_EQ(count(without, "exact, 1 test"), std::pair(-1, -1)) << "no test, no column";
}

}  // namespace
}  // namespace airside::tools::gap
