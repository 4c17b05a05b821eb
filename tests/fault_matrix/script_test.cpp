// Fault scripts as a person uses them: `airside simulate --faults`, and a broken one.

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "support/child.hpp"
#include "support/test_folder.hpp"

namespace airside::fault_matrix {
namespace {

using closed_loop::Child;

class Script : public ::testing::Test {
 protected:
  int simulate(const std::string& script) {
    std::ofstream(folder.file("f.csv")) << "begin_h,for_h,fault,signal,magnitude\n" << script;
    Child child({AIRSIDE_BIN_DIR "/airside", "simulate", "--plant", "rc", "--room", "301-real", "--transfer", "--steps",
                 "100", "--days", "2", "--faults", folder.file("f.csv"), "--log", folder.file("log.csv"), "--json"},
                folder.file("said.txt"));
    const int code = child.wait(60).value_or(-1);
    said = child.said();
    std::ifstream in(folder.file("log.csv"));
    log.assign(std::istreambuf_iterator<char>(in), {});
    return code;
  }

  hal::TestFolder folder{"script"};
  std::string said, log;
};

TEST_F(Script, ShowsInTheLogWhatItDoes) {
  ASSERT_EQ(simulate("2,3,not_a_number,room_temp_1,\n14,0,setpoint_by_hand,,21.3\n"), 0) << said;
  EXPECT_NE(log.find(",signal lost,"), std::string::npos);
  EXPECT_NE(log.find(",overridden,"), std::string::npos);
  EXPECT_NE(said.find("\"dae_degc\""), std::string::npos) << "figures are of the room, whatever its sensors show";
}

TEST_F(Script, WithoutLinesNothingIsDisturbed) {
  ASSERT_EQ(simulate(""), 0) << said;
  EXPECT_EQ(log.find(",signal lost,"), std::string::npos);
  EXPECT_EQ(log.find(",overridden,"), std::string::npos);
}

TEST_F(Script, ABrokenLineIsRefusedBeforeAnythingRuns) {
  EXPECT_EQ(simulate("2,3,not_a_number,room_temp_9,\n"), 1);
  EXPECT_NE(said.find("f.csv:2: signal: found 'room_temp_9'; expected one of room_temp_1"), std::string::npos) << said;
  EXPECT_EQ(log, "");
}

}  // namespace
}  // namespace airside::fault_matrix
