// What somebody else has put where the status belongs: it is never followed, waited for or written to, and where the
// status cannot be written for it, the daemon raises the alarm of its storage and goes on.

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "airside/controller/instances.hpp"
#include "firmware/edge/report/status_snapshot.hpp"
#include "support/bench.hpp"
#include "support/test_folder.hpp"

namespace airside::foreign {
namespace {

namespace fs = std::filesystem;
using closed_loop::Bench;
using closed_loop::Child;

nlohmann::json json_in(const fs::path& path) {
  std::ifstream in(path);
  return nlohmann::json::parse(in, nullptr, false);
}

class StatusPlace : public ::testing::Test {
 protected:
  StatusPlace() { std::ofstream(other.file("victim")) << "mine"; }
  hal::StoreResult<void> write(int row) {
    return file.write({row * 360},
                      {.site = "Room 301", .topology = "5vav-5fcu-2power", .control_mode = {}, .decision = decision});
  }
  /// A file of row `row`, and nothing was written through a link.
  void expect_row(int row) const {
    EXPECT_TRUE(fs::is_regular_file(fs::symlink_status(folder.file("status.json"))));
    EXPECT_EQ(json_in(folder.file("status.json"))["time"].get<std::string>().substr(14, 2),
              (row * 6 < 10 ? "0" : "") + std::to_string(row * 6));
    EXPECT_EQ(other.image().size(), 1u);
    EXPECT_EQ(other.image().at("victim").size(), 4u);
  }
  hal::TestFolder folder{"status_place"}, other{"status_victim"};
  Decision decision = Controller<FiveZone>::schedule_decision();
  edge::StatusFile file{folder.c_str()};
};

TEST_F(StatusPlace, ALinkOrAPipeIsTakenAwayAndNotFollowed) {
  int row = 0;
  for (const char* name : {"status.json", "status.json.new"}) {
    const fs::path at = folder.file(name);
    for (const int kind : {0, 1, 2}) {
      ASSERT_TRUE(write(++row));
      EXPECT_FALSE(file.cleared());
      fs::remove(at);
      if (kind == 0) fs::create_symlink(other.file("victim"), at);
      if (kind == 1) fs::create_symlink(other.file("none"), at);
      if (kind == 2) {
        ASSERT_EQ(::mkfifo(at.c_str(), 0600), 0);
      }
      for (const bool cleared : {true, false}) {
        row = row % 8 + 1;
        EXPECT_TRUE(write(row)) << name << kind;
        EXPECT_EQ(file.cleared(), cleared) << name << kind;
        expect_row(row);
      }
    }
  }
}

TEST_F(StatusPlace, AFolderForTheNextStatusIsAFaultThatTheStatusTellsOf) {
  ASSERT_TRUE(write(1));
  fs::remove(folder.file("status.json.new"));
  fs::create_directories(folder.file("status.json.new") / "full");
  for (const int row : {2, 3, 4}) {
    const auto written = write(row);
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().fault, hal::StoreFault::wrong_kind);
    expect_row(row);
  }
  fs::remove_all(folder.file("status.json.new"));
  EXPECT_TRUE(write(5));
  expect_row(5);
}

TEST_F(StatusPlace, AFolderForTheStatusIsAFaultUntilAPersonTakesItAway) {
  fs::create_directories(folder.file("status.json") / "full");
  for (const int row : {1, 2}) {
    const auto written = write(row);
    ASSERT_FALSE(written);
    EXPECT_EQ(written.error().fault, hal::StoreFault::wrong_kind);
    EXPECT_TRUE(fs::is_directory(folder.file("status.json") / "full")) << "it is somebody's";
  }
  fs::remove_all(folder.file("status.json"));
  EXPECT_TRUE(write(3));
  expect_row(3);
}

class StatusOfDaemon : public ::testing::Test {
 protected:
  void start() {
    bench.start_server();
    daemon = bench.start_daemon();
    rows(5);
  }
  void rows(std::size_t more) const {
    const std::size_t until = bench.logged_rows() + more;
    while (bench.logged_rows() < until && daemon->running()) closed_loop::sleep_s(0.001);
    ASSERT_GE(bench.logged_rows(), until) << daemon->said();
  }
  std::size_t times_said(const std::string& what) const {
    const std::string said = daemon->said();
    std::size_t times = 0;
    for (std::size_t at = said.find(what); at != std::string::npos; at = said.find(what, at + 1)) ++times;
    return times;
  }
  Bench bench{{.name = "status_place",
               .plant = closed_loop::rc_room(),
               .expert_days = 1,
               .days = 20,
               .more_site = closed_loop::brief_learning}};
  const fs::path status = bench.file("state") / "status.json", next = bench.file("state") / "status.json.new";
  std::unique_ptr<Child> daemon;
};

TEST_F(StatusOfDaemon, AlarmsWhereAFolderKeepsTheNextStatusFromItsName) {
  fs::create_directories(next / "full");
  start();
  rows(5);
  const nlohmann::json s = bench.status();
  EXPECT_EQ(s["storage"], "status cannot be written") << s;
  EXPECT_EQ(s["alarms"].dump().find("storage failed") != std::string::npos, true) << s;
  fs::remove_all(next);
  rows(10);
  EXPECT_EQ(bench.status()["storage"], "ok");
  EXPECT_EQ(bench.status()["alarms"], nlohmann::json::array());
  EXPECT_EQ(times_said("status cannot be written"), 1u) << daemon->said();
}

TEST_F(StatusOfDaemon, SaysOnceThatAFolderStandsInItsPlaceAndGoesOn) {
  fs::create_directories(status / "full");
  start();
  rows(10);
  EXPECT_EQ(times_said("status cannot be written: not a regular file or folder"), 1u) << daemon->said();
  EXPECT_EQ(times_said("storage failed") > 0 || times_said("state or log cannot be written") > 0, true)
      << daemon->said();
  fs::remove_all(status);
  rows(10);
  EXPECT_EQ(bench.status()["storage"], "ok");
}

TEST_F(StatusOfDaemon, IsNotHungByAPipeNorLedAwayByALink) {
  ASSERT_EQ(::mkfifo(next.c_str(), 0600), 0);
  start();
  std::ofstream(bench.file("victim")) << "mine";
  // In one step: the daemon writes a row each millisecond.
  fs::create_symlink(bench.file("victim"), bench.file("link"));
  fs::rename(bench.file("link"), next);
  rows(5);
  EXPECT_EQ(bench.status()["storage"], "ok");
  EXPECT_EQ(fs::file_size(bench.file("victim")), 4u);
  EXPECT_EQ(times_said("it was taken away"), 2u) << daemon->said();
}

}  // namespace
}  // namespace airside::foreign
