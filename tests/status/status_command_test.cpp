// `airside status`: a word and an exit code for what runs, has stopped in order, is old, or has an alarm; and no
// permission is not taken for a daemon that does not run.

#include <gtest/gtest.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>

#include "support/bench.hpp"
#include "support/program.hpp"

namespace airside::status {
namespace {

using closed_loop::Bench;
using closed_loop::Child;
using nlohmann::json;

class StatusCommand : public ::testing::Test {
 protected:
  Outcome look(const std::string& option = {}) const {
    std::vector<std::string> words{"status", bench.file("state").string()};
    if (!option.empty()) words.push_back(option);
    return run_program("airside", words, bench.file(""), scratch.path());
  }
  json snapshot() const {
    std::ifstream in(status);
    return json::parse(in, nullptr, false);
  }
  void change(const char* member, const json& value) const {
    json all = snapshot();
    all[member] = value;
    std::ofstream(status, std::ios::trunc) << all;
  }
  void make_old() const { fs::last_write_time(status, fs::file_time_type::clock::now() - std::chrono::hours(2)); }
  /// A daemon that has done its rows and was told to stop.
  void run_and_stop() {
    bench.start_server();
    const auto daemon = bench.start_daemon();
    while (bench.logged_rows() < 10 && daemon->running()) closed_loop::sleep_s(0.001);
    daemon->signal(SIGTERM);
    ASSERT_EQ(daemon->wait(30), 0) << daemon->said();
  }
  Bench bench{{.name = "status_command",
               .plant = closed_loop::rc_room(),
               .expert_days = 1,
               .days = 20,
               .more_site = closed_loop::brief_learning}};
  TemporaryFolder scratch;
  const fs::path status = bench.file("state") / "status.json";
};

TEST_F(StatusCommand, SaysThatADaemonRunsAndThatItHasStoppedInOrder) {
  bench.start_server();
  const auto daemon = bench.start_daemon();
  while (bench.logged_rows() < 10 && daemon->running()) closed_loop::sleep_s(0.001);
  const Outcome runs = look("--json");
  EXPECT_EQ(runs.code, 0) << runs.out << runs.err;
  EXPECT_EQ(json::parse(runs.out)["condition"], "running");
  EXPECT_EQ(json::parse(runs.out)["stopped"], false);
  daemon->signal(SIGTERM);
  ASSERT_EQ(daemon->wait(30), 0) << daemon->said();
  const Outcome has_stopped = look();
  EXPECT_EQ(has_stopped.code, 3) << has_stopped.out;
  EXPECT_NE(has_stopped.out.find("airsided has stopped in order, at 2021-08-0"), std::string::npos) << has_stopped.out;
  EXPECT_EQ(has_stopped.out.find("It controls"), std::string::npos) << has_stopped.out;
  EXPECT_EQ(json::parse(look("--json").out)["condition"], "stopped");
  EXPECT_EQ(snapshot()["stopped"], true);
  EXPECT_GE(snapshot()["stopped_at"], snapshot()["time"]);
  make_old();
  EXPECT_EQ(look().code, 3) << "and that stays so";
}

TEST_F(StatusCommand, SaysWhatItExpectsAndWhatTheResidualNetworkAdds) {
  run_and_stop();
  change("expected_held_degc", 25.5);
  change("expected_error_k", 0.0441);
  change("residual_forecast_k", -0.03);
  change("residual_share", 0.5);
  const std::string text = look().out;
  EXPECT_NE(text.find("it expects them at 25.50 degC by the end of the cycle (lately wrong by 0.04 K). The residual "
                      "network expects 0.03 K less than the room head does; half of it counts."),
            std::string::npos)
      << text;
  json older = snapshot();
  for (const char* name : {"expected_error_k", "residual_forecast_k", "residual_share"}) older.erase(name);
  std::ofstream(status, std::ios::trunc) << older;
  const Outcome of_older = look();
  EXPECT_EQ(of_older.code, 3) << of_older.err;
  EXPECT_NE(of_older.out.find("by the end of the cycle."), std::string::npos) << of_older.out;
  EXPECT_EQ(of_older.out.find("residual"), std::string::npos) << of_older.out;
}

TEST_F(StatusCommand, TellsAnOldStatusAndAnAlarmFromOneThatRuns) {
  run_and_stop();
  change("stopped", false);
  EXPECT_EQ(look().code, 0);
  change("alarms", json::array({{{"reason", "storage failed"}, {"since", "2021-08-01T00:00:00"}}}));
  const Outcome alarmed = look();
  EXPECT_EQ(alarmed.code, 5);
  EXPECT_NE(alarmed.out.find("Alarms: storage failed"), std::string::npos) << alarmed.out;
  EXPECT_EQ(json::parse(look("--json").out)["condition"], "alarm");
  make_old();
  const Outcome old = look();
  EXPECT_EQ(old.code, 4);
  EXPECT_NE(old.out.find("This is old"), std::string::npos) << old.out;
  EXPECT_EQ(old.out.find("It controls"), std::string::npos) << "nobody knows: " << old.out;
  EXPECT_EQ(json::parse(look("--json").out)["condition"], "stale");
  fs::last_write_time(status, fs::file_time_type::clock::now() + std::chrono::hours(2));
  EXPECT_EQ(look().code, 4) << "a clock was set";
}

TEST_F(StatusCommand, OfADaemonThatWaitsForItsPlantIsNotThatOfTheOneBefore) {
  run_and_stop();
  bench.stop_server();
  const auto daemon = bench.start_daemon();
  for (int i = 0; i < 1000 && snapshot().value("stopped", true); ++i) closed_loop::sleep_s(0.01);
  EXPECT_EQ(snapshot().value("stopped", true), false) << snapshot();
  EXPECT_NE(snapshot().value("fault", "none"), "none") << snapshot();
  const Outcome waits = look();
  EXPECT_EQ(waits.code, 5) << waits.out;
  EXPECT_NE(waits.out.find("The AHU does not answer"), std::string::npos) << waits.out;
  EXPECT_NE(waits.out.find("Alarms: no reading since "), std::string::npos) << waits.out;
  EXPECT_EQ(waits.out.find("has had no error"), std::string::npos) << waits.out;
  daemon->signal(SIGTERM);
  ASSERT_EQ(daemon->wait(30), 0) << daemon->said();
  EXPECT_EQ(look().code, 3);
}

TEST_F(StatusCommand, SaysThatItMayNotReadInsteadOfThatThereIsNone) {
  if (::geteuid() == 0 && ::access("/usr/bin/setpriv", X_OK) != 0) GTEST_SKIP() << "root may read everything";
  run_and_stop();
  fs::permissions(bench.file("state"), fs::perms::none);
  fs::permissions(scratch.path(), fs::perms::all);
  const std::string airside = std::string(AIRSIDE_BIN_DIR) + "/airside";
  const std::vector<std::string> words{"--reuid",        "65534", "--regid", "65534",
                                       "--clear-groups", airside, "status",  bench.file("state").string()};
  const Outcome refused =
      ::geteuid() == 0 ? run_program("/usr/bin/setpriv", words, bench.file(""), scratch.path()) : look();
  fs::permissions(bench.file("state"), fs::perms::owner_all);
  EXPECT_EQ(refused.code, 1);
  EXPECT_NE(refused.err.find("no permission to read it"), std::string::npos) << refused.err;
  EXPECT_EQ(refused.err.find("no such file"), std::string::npos) << refused.err;
  EXPECT_FALSE(complaint_in(refused.err).remedy.empty());
}

TEST_F(StatusCommand, SaysThatThereIsNoneOrThatAFolderIsInItsPlace) {
  const Outcome none = look();
  EXPECT_EQ(none.code, 1);
  EXPECT_NE(none.err.find("no such file"), std::string::npos) << none.err;
  fs::create_directories(status);
  const Outcome folder = look();
  EXPECT_EQ(folder.code, 1);
  EXPECT_EQ(complaint_in(folder.err).found, "no regular file") << folder.err;
  EXPECT_EQ(run_program("airside", {"status", "--nonsense"}, bench.file(""), scratch.path()).code, 2);
}

}  // namespace
}  // namespace airside::status
