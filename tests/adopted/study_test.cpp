// What `airside study adopted` refuses before anything runs; it needs no engine for that.

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "support/program.hpp"

namespace airside::sim {
namespace {

class StudyOfAdopted : public testing::Test {
 protected:
  void write_site(const std::string& twin) const {
    std::ofstream(folder_.path() / "site.toml") << "[site]\nname = \"Haus\"\ntopology = \"1vav-0fcu-0power\"\n" << twin;
  }
  std::string refusal(std::vector<std::string> more) const {
    std::vector<std::string> command = {"study", "adopted", "site.toml"};
    command.insert(command.end(), more.begin(), more.end());
    const Outcome outcome = run_program("airside", command, folder_.path(), scratch_.path());
    EXPECT_EQ(outcome.code, 1) << outcome.err;
    EXPECT_EQ(outcome.err.find("started"), std::string::npos) << "nothing has run: " << outcome.err;
    return outcome.err;
  }
  TemporaryFolder folder_, scratch_;
};

constexpr const char* own_twin =
    "[twin]\nmodel = \"m.epJSON\"\ncontrol = \"own\"\n[twin.names]\n"
    "supply_setpoint_schedule = \"s\"\nsupply_air_node = \"n\"\nzones = [\"Saal\"]\n";

TEST_F(StudyOfAdopted, ASiteThatWasNotAdoptedIsRefused) {
  write_site("");
  const std::string said = refusal({});
  for (const char* part : {"site.toml: [twin]", "no model with a control of its own", "airside adopt"})
    EXPECT_NE(said.find(part), std::string::npos) << said;
}

TEST_F(StudyOfAdopted, DaysThatLeaveTheEnginesYearAreRefused) {
  write_site(own_twin);
  for (const char* start : {"2021-01-11", "2021-12-01"}) {
    const std::string said = refusal({"--starts", start});
    EXPECT_NE(said.find(std::string("--starts: found ") + start), std::string::npos) << said;
    EXPECT_NE(said.find("fewer --seeds"), std::string::npos) << said;
  }
}

nlohmann::json run_of(double kwh, double above) {
  return {{"dae_degc", 0.3},
          {"above_degch", above},
          {"below_degch", 0.0},
          {"saturated_h", 0.0},
          {"setpoint_degc", 14.25},
          {"darv_degc", 0.5},
          {"kwh_per_day", {1.0, kwh - 1.0}}};
}

nlohmann::json method_of(const char* name, const char* kind, double value, double kwh, double above) {
  return {{"method", name}, {"kind", kind}, {"value", value}, {"runs", {run_of(kwh, above), run_of(kwh + 2, above)}}};
}

/// Four zones with the objective "band": the cheapest constant and MPC leave the band too often, or need what a
/// simple method has not.
nlohmann::json stored_table(double our_above) {
  return {{"site", "sites/haus/site.toml"},
          {"start", "2021-07-05"},
          {"meters", {"Fans", "Cooling"}},
          {"objective", "band"},
          {"zones", 4},
          {"constant_of_other_days", "constant 14.0"},
          {"integral_gain_per_h", nullptr},
          {"methods",
           {method_of("own control", "own", 0, 120, 0.1), method_of("constant 14.0", "constants", 14, 110, 0.25),
            method_of("constant 16.0", "constants", 16, 80, 0.35), method_of("mpc", "mpc", 0, 100, 0.3),
            method_of("ours, band", "ours", 0, 99, our_above)}}};
}

TEST_F(StudyOfAdopted, TablesOfEarlierRunsArePrintedAgain) {
  const auto printed = [&](double our_above) {
    std::ofstream(folder_.path() / "t.json") << nlohmann::json{{"tables", {stored_table(our_above)}}}.dump();
    const Outcome outcome =
        run_program("airside", {"study", "adopted", "--from", "t.json"}, folder_.path(), scratch_.path());
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.out;
  };
  const std::string sound = printed(0.2);
  for (const char* part :
       {"#### haus, from 2021-07-05",
        "| constant 14.0 (chosen on other days) | 111.0 ± 1.4 | 1.0 | 110.0 | 0.25 ± 0.00",
        "best simple method:\n  -9.9 ± 0.1 %, -0.05 ± 0.00 degree-hours (constant 14.0)",
        "best of all:\n  -1.0 ± 0.0 %, -0.10 ± 0.00 degree-hours (mpc)", "| haus, 2021-07-05 | 100.0 ± 1.4 / 0.20 |"})
    EXPECT_NE(sound.find(part), std::string::npos) << part << "\n" << sound;
  EXPECT_NE(printed(0.4).find("with more than the 0.30 that the others may have"), std::string::npos);
}

TEST_F(StudyOfAdopted, WhatIsNoTableOfThisStudyIsRefused) {
  std::ofstream(folder_.path() / "t.json") << R"({"tables": [{"site": "a"}]})";
  Outcome outcome = run_program("airside", {"study", "adopted", "--from", "t.json"}, folder_.path(), scratch_.path());
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("what `airside study adopted -o` wrote"), std::string::npos) << outcome.err;
  outcome = run_program("airside", {"study", "adopted"}, folder_.path(), scratch_.path());
  EXPECT_EQ(outcome.code, 1);
  EXPECT_NE(outcome.err.find("name site files, or tables of earlier runs"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace airside::sim
