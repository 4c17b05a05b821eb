// What `airside study adopted` refuses before anything runs; it needs no engine for that.

#include <gtest/gtest.h>

#include <fstream>

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

}  // namespace
}  // namespace airside::sim
