// `airside doctor` says what is missing, with the line that fixes it; `airside watch` shows what the log has.

#include <fmt/format.h>
#include <gtest/gtest.h>
#include <pty.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <nlohmann/json.hpp>
#include <regex>
#include <sstream>

#include "support/bench.hpp"
#include "support/program.hpp"

namespace airside::status {
namespace {

using closed_loop::Bench;
using nlohmann::json;

class FirstLook : public ::testing::Test {
 protected:
  Outcome airside(std::vector<std::string> words) const {
    return run_program("airside", std::move(words), bench.file(""), scratch.path());
  }
  Outcome doctor() const { return airside({"doctor", "site.toml"}); }
  /// State of one finding: ok, advice or MISSING.
  std::string state_of(const std::string& what) const {
    const json all = json::parse(airside({"doctor", "site.toml", "--json"}).out);
    for (const json& f : all["findings"]) {
      if (f["what"] == what) return f["state"];
    }
    return "not looked at";
  }
  void change_site(const std::string& from, const std::string& to) const {
    std::string text = text_of_file(site);
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    std::ofstream(site, std::ios::trunc) << text.replace(at, from.size(), to);
  }
  /// A line of the site file from its key on.
  std::string line_of(const std::string& key) const {
    const std::string text = text_of_file(site);
    const std::size_t at = text.find("\n" + key);
    return at == std::string::npos ? "" : text.substr(at + 1, text.find('\n', at + 1) - at - 1);
  }
  void run_rows(std::size_t rows) {
    bench.start_server();
    const auto daemon = bench.start_daemon();
    while (bench.logged_rows() < rows && daemon->running()) closed_loop::sleep_s(0.001);
    daemon->signal(SIGTERM);
    ASSERT_EQ(daemon->wait(30), 0) << daemon->said();
  }

  Bench bench{{.name = "first_look",
               .plant = closed_loop::rc_room(),
               .expert_days = 1,
               .days = 20,
               .more_site = closed_loop::brief_learning}};
  TemporaryFolder scratch;
  const fs::path site = bench.file("site.toml");
};

TEST_F(FirstLook, DoctorWithoutASiteLooksAtTheMachineAlone) {
  const Outcome alone = airside({"doctor"});
  EXPECT_EQ(alone.code, 0) << alone.err;
  EXPECT_NE(alone.out.find("ok       program    airside "), std::string::npos) << alone.out;
  EXPECT_EQ(alone.out.find("bus"), std::string::npos);
}

TEST_F(FirstLook, DoctorTellsAnAhuThatAnswersFromOneThatDoesNot) {
  bench.start_server();
  EXPECT_EQ(doctor().code, 0) << doctor().out;
  EXPECT_EQ(state_of("bus"), "ok");
  EXPECT_EQ(state_of("points"), "ok");
  EXPECT_EQ(state_of("status"), "advice") << "airsided has not run";
  bench.stop_server();
  const Outcome gone = doctor();
  EXPECT_EQ(gone.code, 1);
  EXPECT_NE(gone.out.find("MISSING  bus"), std::string::npos) << gone.out;
  EXPECT_NE(gone.out.find("then airside probe site.toml"), std::string::npos) << gone.out;
  EXPECT_NE(gone.err.find("1 of "), std::string::npos) << gone.err;
}

TEST_F(FirstLook, DoctorNamesWhatASiteLacks) {
  bench.start_server();
  fs::remove_all(bench.file("state"));
  std::ofstream(bench.file("state")) << "no folder";
  EXPECT_EQ(state_of("state"), "MISSING");
  fs::remove(bench.file("state"));
  change_site(line_of("blob ="), "blob = \"nowhere.blob\"");
  EXPECT_EQ(state_of("weights"), "MISSING");
  const std::string points = text_of_file(bench.file("points.csv"));
  const std::size_t beat = points.find("\nheartbeat,");
  ASSERT_NE(beat, std::string::npos);
  std::ofstream(bench.file("points.csv"), std::ios::trunc)
      << points.substr(0, beat + 1) + points.substr(points.find('\n', beat + 1) + 1);
  EXPECT_EQ(state_of("heartbeat"), "advice");
  std::ofstream(site, std::ios::app) << "\n[nonsense]\n";
  EXPECT_EQ(state_of("site"), "MISSING");
  EXPECT_NE(doctor().out.find("nonsense"), std::string::npos) << doctor().out;
}

TEST_F(FirstLook, AFolderBelowEtcIsNoneThatAUnitMayWrite) {
  bench.start_server();
  const auto check = [&] {
    return run_program("airsided", {"--check", "--site", "site.toml"}, bench.file(""), scratch.path());
  };
  ASSERT_EQ(check().code, 0) << check().err;
  change_site(line_of("dir = \"log\""), "dir = \"/etc/airside/log\"");
  const Outcome refused = check();
  EXPECT_EQ(refused.code, 1);
  for (const char* part :
       {"[log] dir: found /etc/airside/log", "airsided.service may write", "dir = \"/var/lib/airside/log\""})
    EXPECT_NE(refused.err.find(part), std::string::npos) << refused.err;
  EXPECT_FALSE(fs::exists("/etc/airside/log"));
  EXPECT_EQ(state_of("log"), "MISSING");
  EXPECT_NE(doctor().out.find("write dir = \"/var/lib/airside/log\" in [log] of site.toml"), std::string::npos)
      << doctor().out;
  EXPECT_NE(state_of("state"), "MISSING");
}

TEST_F(FirstLook, DoctorLooksAtASerialLine) {
  std::string text = text_of_file(site);
  const std::size_t at = text.find("[modbus]"), end = text.find("\n[", at + 1);
  const auto with_device = [&](const std::string& device) {
    std::ofstream(site, std::ios::trunc) << text.substr(0, at) << "[modbus]\ntransport = \"rtu\"\ndevice = \"" << device
                                         << "\"\npoints = \"points.csv\"\n"
                                         << (end == std::string::npos ? "" : text.substr(end));
    return state_of("bus");
  };
  EXPECT_EQ(with_device("/dev/nothing-there"), "MISSING");
  EXPECT_EQ(with_device(site.string()), "MISSING") << "a file is no line";
  int master = 0, slave = 0;
  char name[128] = {};
  ASSERT_EQ(openpty(&master, &slave, name, nullptr, nullptr), 0);
  EXPECT_EQ(with_device(name), "ok");
  ::close(master);
  ::close(slave);
}

TEST_F(FirstLook, DoctorTellsADaemonThatRunsFromOneThatDoesNot) {
  run_rows(10);
  EXPECT_EQ(state_of("status"), "advice");
  EXPECT_NE(doctor().out.find("stopped in order"), std::string::npos) << doctor().out;
  const fs::path status = bench.file("state") / "status.json";
  json all = json::parse(text_of_file(status));
  all["stopped"] = false;
  std::ofstream(status, std::ios::trunc) << all;
  EXPECT_EQ(state_of("status"), "ok");
  std::ofstream(status, std::ios::trunc) << "{\"stopped\":";
  EXPECT_EQ(state_of("status"), "MISSING") << "a damaged status is a finding like any other";
  std::ofstream(status, std::ios::trunc) << all;
  fs::last_write_time(status, fs::file_time_type::clock::now() - std::chrono::hours(1));
  EXPECT_NE(doctor().out.find("airsided does not run"), std::string::npos) << doctor().out;
}

TEST_F(FirstLook, LinesOfTheDaemonHaveATimeWhereNoJournalAddsOne) {
  bench.start_server();
  const auto lines_of_a_run = [&] {
    const auto daemon = bench.start_daemon();
    const std::size_t before = bench.logged_rows();
    while (bench.logged_rows() < before + 3 && daemon->running()) closed_loop::sleep_s(0.001);
    daemon->signal(SIGTERM);
    EXPECT_EQ(daemon->wait(30), 0);
    return daemon->said();
  };
  const std::string alone = lines_of_a_run();
  std::istringstream lines(alone);
  int count = 0;
  for (std::string line; std::getline(lines, line); ++count)
    EXPECT_TRUE(std::regex_search(line, std::regex("^20[0-9]{2}-[0-9]{2}-[0-9]{2}T[0-9]{2}:[0-9]{2}:[0-9]{2}Z [^ ]")))
        << line;
  EXPECT_GT(count, 0) << alone;
  ::setenv("JOURNAL_STREAM", "8:1", 1);
  std::string in_journal = lines_of_a_run();
  if (in_journal.starts_with(alone)) in_journal.erase(0, alone.size());  // one file for both
  ::unsetenv("JOURNAL_STREAM");
  EXPECT_FALSE(in_journal.empty());
  EXPECT_EQ(in_journal.find("Z "), std::string::npos) << in_journal;
}

TEST_F(FirstLook, WatchShowsTheNewestRowAndTheDayBeforeIt) {
  run_rows(60);
  const Outcome seen = airside({"watch", "site.toml"});
  ASSERT_EQ(seen.code, 0) << seen.err;
  std::istringstream lines(seen.out);
  std::string line, of_room;
  while (std::getline(lines, line)) {
    if (line.find(" room 1 ") != std::string::npos) of_room = line;
  }
  const auto log = bench.log();
  const std::string& newest = log.rows.back();
  const std::size_t from = newest.find(',') + 1;
  const double room = std::stod(newest.substr(from));
  EXPECT_NE(of_room.find(fmt::format("{:.2f}", room)), std::string::npos) << of_room << "\n" << newest;
  // A mark of three bytes for each half hour that has a row.
  const auto marks = std::ranges::count(of_room, '\xe2');
  const auto half_hours = static_cast<std::ptrdiff_t>(std::min<std::size_t>(log.rows.size(), 240) / 5);
  EXPECT_GE(marks, half_hours) << of_room;
  EXPECT_LE(marks, half_hours + 1) << of_room;
  // Behind the line of each room its own least and most, not those of all rooms.
  double least = room, most = room;
  for (std::size_t i = log.rows.size() - std::min<std::size_t>(log.rows.size(), 240); i < log.rows.size(); ++i) {
    const double degc = std::stod(log.rows[i].substr(log.rows[i].find(',') + 1));
    least = std::min(least, degc);
    most = std::max(most, degc);
  }
  EXPECT_TRUE(of_room.ends_with(fmt::format("  {:.1f} to {:.1f} degC", least, most))) << of_room;
  EXPECT_NE(seen.out.find("Lines of rooms and their mean have one scale, "), std::string::npos) << seen.out;
  EXPECT_NE(seen.out.find("mean of rooms"), std::string::npos);
  EXPECT_NE(seen.out.find("setpoint"), std::string::npos);
}

TEST_F(FirstLook, WatchSaysWhatIsNotThereYet) {
  const Outcome seen = airside({"watch", "site.toml"});
  EXPECT_EQ(seen.code, 0) << seen.err;
  EXPECT_NE(seen.out.find("no such file"), std::string::npos) << seen.out;
  EXPECT_NE(seen.out.find("No row in "), std::string::npos) << seen.out;
  EXPECT_EQ(airside({"watch", "nothing.toml"}).code, 1);
}

TEST_F(FirstLook, WatchDrawsAnewOnATerminalAndLeavesItAsItWas) {
  run_rows(10);
  int master = 0;
  const pid_t child = ::forkpty(&master, nullptr, nullptr, nullptr);
  ASSERT_GE(child, 0);
  if (child == 0) {
    const std::string program = std::string(AIRSIDE_BIN_DIR) + "/airside";
    if (::chdir(bench.file("").c_str()) == 0) {
      ::execl(program.c_str(), "airside", "watch", "site.toml", "--every", "0.2", nullptr);
    }
    ::_exit(127);
  }
  std::string text;
  const auto pictures = [&text] {
    int count = 0;
    for (std::size_t at = text.find("\x1b[H"); at != std::string::npos; at = text.find("\x1b[H", at + 1)) ++count;
    return count;
  };
  char buffer[4096];
  const double deadline_s = closed_loop::now_s() + 20;
  while (pictures() < 3 && closed_loop::now_s() < deadline_s) {
    const ssize_t n = ::read(master, buffer, sizeof buffer);
    if (n <= 0) break;
    text.append(buffer, static_cast<std::size_t>(n));
  }
  EXPECT_GE(pictures(), 3);
  ::kill(child, SIGINT);
  for (ssize_t n = ::read(master, buffer, sizeof buffer); n > 0; n = ::read(master, buffer, sizeof buffer))
    text.append(buffer, static_cast<std::size_t>(n));
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0);
  EXPECT_NE(text.find("\x1b[?25h\x1b[?1049l"), std::string::npos) << "cursor and screen are given back";
  ::close(master);
}

}  // namespace
}  // namespace airside::status
