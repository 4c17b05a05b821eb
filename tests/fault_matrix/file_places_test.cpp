// A folder or a pipe where a file of the box belongs: the daemon neither hangs nor dies, raises the alarm of its
// storage, and writes as soon as a person has taken it away.

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "hal/text/civil_text.hpp"
#include "support/bench.hpp"
#include "tools/run/plant_choice.hpp"

namespace airside::fault_matrix {
namespace {

namespace fs = std::filesystem;
using closed_loop::Bench;
using closed_loop::Child;

class FilePlaces : public ::testing::Test {
 protected:
  FilePlaces() { bench.start_server(); }

  static void lay(const fs::path& at, bool pipe) {
    fs::create_directories(at.parent_path());
    if (pipe) {
      ASSERT_EQ(::mkfifo(at.c_str(), 0600), 0) << at;
    } else {
      fs::create_directories(at / "full");
    }
  }
  /// Waits until the status tells of `rows` more rows. False: the daemon hangs, or is gone.
  bool goes_on(Child& daemon, int rows) const {
    const double until_s = closed_loop::now_s() + 60;
    std::string seen;
    for (int row = -1; row < rows;) {
      if (closed_loop::now_s() > until_s || !daemon.running()) return false;
      const nlohmann::json s = bench.status();
      if (s.is_object() && s["time"] != seen) seen = s["time"], ++row;
      closed_loop::sleep_s(0.001);
    }
    return true;
  }
  void expect_alarm_until_removed(const std::vector<fs::path>& places, bool pipe, bool alarms = true) {
    const std::string what = places.front().filename().string() + (pipe ? ", a pipe" : ", a folder");
    for (const char* folder : {"state", "log"}) fs::remove_all(bench.file(folder));
    for (const fs::path& at : places) lay(at, pipe);
    const auto daemon = bench.start_daemon(false, {"--crash-limit", "8"});  // it keeps its starts
    ASSERT_TRUE(goes_on(*daemon, 3)) << what << daemon->said();
    if (alarms) {
      EXPECT_NE(bench.status()["storage"], "ok") << what;
      EXPECT_NE(bench.status()["alarms"].dump().find("storage failed"), std::string::npos) << what << bench.status();
    }
    for (const fs::path& at : places) fs::remove_all(at);
    ASSERT_TRUE(goes_on(*daemon, 5)) << what << daemon->said();
    EXPECT_EQ(bench.status()["storage"], "ok") << what << daemon->said();
    daemon->signal(SIGTERM);
    EXPECT_EQ(daemon->wait(30), 0) << what << daemon->said();
  }

  Bench bench{{.name = "file_places",
               .plant = closed_loop::rc_room(),
               .expert_days = 1,
               .days = 40,
               .more_site = closed_loop::brief_learning}};
};

TEST_F(FilePlaces, OfTheStateFolderAlarmAndAreUsedAgain) {
  for (const char* name :
       {"lock", "row.a", "learning.b", "replay.a", "starts", "weights.blob.new", "previous", "previous.new"}) {
    for (const bool pipe : {false, true}) expect_alarm_until_removed({bench.file("state") / name}, pipe);
  }
  for (const char* folder : {"state", "log"}) {
    expect_alarm_until_removed({bench.file(folder) / "push_counters"}, false);
    expect_alarm_until_removed({bench.file(folder) / "push_counters.new"}, false);
    expect_alarm_until_removed({bench.file(folder) / "push_counters.new"}, true, false);  // taken away
  }
}

TEST_F(FilePlaces, OfTheLogAlarmAndAreUsedAgain) {
  for (const bool pipe : {false, true}) {
    std::vector<fs::path> days;
    const std::int64_t first_s = tools::start_of(closed_loop::rc_room()).seconds;
    for (int day = 0; day < 45; ++day) {
      const std::string date = hal::civil_text({first_s + day * std::int64_t{86400}}).substr(0, 10);
      days.push_back(bench.file("log") / ("airside-" + date + ".csv"));
    }
    expect_alarm_until_removed(days, pipe);
  }
}

}  // namespace
}  // namespace airside::fault_matrix
