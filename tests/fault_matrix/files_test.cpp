// Files that people and other programs write: what is broken is refused whole, and who runs goes on with what he has.

#include <gtest/gtest.h>

#include <fstream>

#include "support/bench.hpp"

namespace airside::fault_matrix {
namespace {

using closed_loop::Bench;
using closed_loop::Child;

class Files : public ::testing::Test {
 protected:
  /// Exit code of `airsided --check`, and what it said.
  std::pair<int, std::string> check() {
    Child child({bench.program("airsided"), "--site", bench.file("site.toml"), "--check"}, bench.file("check.txt"));
    const int code = child.wait(20).value_or(-1);
    return {code, child.said()};
  }
  void append(const std::string& name, const std::string& text) {
    std::ofstream(bench.file(name), std::ios::app | std::ios::binary) << text;
  }
  bool reach(std::size_t rows, Child& daemon) {
    for (int i = 0; i < 3000 && bench.logged_rows() < rows; ++i) {
      closed_loop::sleep_s(0.01);
      if (!daemon.running()) break;
    }
    return bench.logged_rows() >= rows;
  }

  Bench bench{{.name = "files", .plant = closed_loop::rc_room(), .expert_days = 1, .days = 1}};
};

TEST_F(Files, Row59HostileOnesAreRefusedWholeAndTheRunningDaemonGoesOn) {
  const closed_loop::LogText& expected = bench.expected();
  bench.start_server();
  const auto daemon = bench.start_daemon();
  ASSERT_TRUE(reach(5, *daemon));
  append("site.toml", std::string("\n[modbus]\nhost = \"\\u0000${HOME}\"\n[[[[") + std::string(100'000, '['));
  append("points.csv", std::string(70'000, ',') + "\n\"open quote,=cmd|' /C calc'!A0");
  append("history.csv", "NaN,,,,\xff\xfe\n");
  const auto [code, said] = check();
  EXPECT_EQ(code, 1) << said;
  EXPECT_NE(said.find("site.toml"), std::string::npos) << said;
  EXPECT_NE(said.find("expected"), std::string::npos) << said;
  Child second({bench.program("airsided"), "--site", bench.file("site.toml")}, bench.file("second.txt"));
  EXPECT_EQ(second.wait(20), 1);
  ASSERT_EQ(daemon->wait(100), 0);
  closed_loop::expect_same_rows(bench.log(), expected);
}

TEST_F(Files, Row59WithoutItTheSameFilesAreInOrder) {
  const auto [code, said] = check();
  EXPECT_EQ(code, 0) << said;
  EXPECT_NE(said.find("in order"), std::string::npos) << said;
}

}  // namespace
}  // namespace airside::fault_matrix
