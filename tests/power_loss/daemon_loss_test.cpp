// What a box had learned is damaged or gone: the daemon says what and until when, alarms, and runs the schedule until a
// person has seen it. A new box is told apart.

#include <gtest/gtest.h>

#include <functional>
#include <nlohmann/json.hpp>

#include "hal/text/civil_text.hpp"
#include "power_loss/daemon_desk.hpp"

namespace airside::power_loss {
namespace {

namespace fs = std::filesystem;

class LostState : public ::testing::Test {
 protected:
  static constexpr int rows_before = 20, rows_after = 30;

  LostState() {
    EXPECT_EQ(desk.run(rows_before).code, 0) << desk.said();
    setpoints = desk.setpoints();
    desk.keep("whole");
  }
  void damage_each(const std::function<void(const fs::path&)>& damage) const {
    for (const char* name : {"learning.a", "learning.b"}) damage(state / name);
  }
  /// A daemon that starts on the box as it is now and runs until `row`.
  nlohmann::json status_after(int row = rows_after) {
    desk.forget_words();
    EXPECT_EQ(desk.run(row).code, 0) << desk.said();
    return nlohmann::json::parse(desk.status(), nullptr, false);
  }
  void expect_alarm(const char* what) {
    const nlohmann::json status = status_after();
    EXPECT_EQ(status["reason"], "state lost") << what << desk.said();
    EXPECT_EQ(status["state"], "expert") << what;
    EXPECT_EQ(status["lost_until"], hal::civil_text(desk.time_of(rows_before - 1))) << what << status;
    EXPECT_NE(desk.said().find("had learned until row " + hal::civil_text(desk.time_of(rows_before - 1)) + " is lost"),
              std::string::npos)
        << what << desk.said();
    const nlohmann::json later = status_after(rows_after + 5);
    EXPECT_EQ(later["reason"], "state lost") << what << ": a restart does not end it";
  }
  void expect_alarm_after(const char* what, const std::function<void()>& damage) {
    desk.roll_back("whole", rows_before, setpoints);
    damage();
    expect_alarm(what);
  }

  DaemonDesk desk{{.name = "loss"}};
  const fs::path state = desk.box() / "state", log = desk.box() / "log";
  std::map<std::int64_t, double> setpoints;
};

TEST_F(LostState, IsToldWhateverHappenedToTheLearningRecords) {
  expect_alarm_after("a bit", [this] {
    damage_each([](const fs::path& path) {
      std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
      file.seekg(5000);
      const int was = file.get();
      file.seekp(5000);
      file.put(static_cast<char>(was ^ 1));
    });
  });
  for (const std::uintmax_t size : {0U, 128U, 4096U, 700000U}) {
    expect_alarm_after(std::to_string(size).c_str(),
                       [&] { damage_each([&](const fs::path& path) { fs::resize_file(path, size); }); });
  }
  expect_alarm_after("removed", [this] { damage_each([](const fs::path& path) { fs::remove(path); }); });
}

TEST_F(LostState, IsToldWhereTheFolderIsEmptyOrGoneBesideLogsOrCounters) {
  const auto empty = [this] {
    for (const auto& entry : fs::directory_iterator(state)) fs::remove_all(entry.path());
  };
  expect_alarm_after("emptied", empty);
  expect_alarm_after("removed", [this] { fs::remove_all(state); });
  expect_alarm_after("emptied, by an older version", [&] {
    empty();
    fs::remove(log / "push_counters");
  });
  desk.roll_back("whole", rows_before, setpoints);
  empty();
  for (const auto& entry : fs::directory_iterator(log)) {
    if (entry.path().extension() == ".csv") fs::remove(entry.path());
  }
  EXPECT_EQ(status_after()["reason"], "state lost") << "counters alone";
}

TEST_F(LostState, EndsWhenAPersonHandsBack) {
  damage_each([](const fs::path& path) { fs::remove(path); });
  expect_alarm("removed");
  desk.wish("hand-back");
  const nlohmann::json status = status_after(rows_after + 15);
  EXPECT_EQ(status["reason"], "none") << desk.said();
  EXPECT_EQ(status_after(rows_after + 20)["reason"], "none");
}

TEST_F(LostState, KeepsAnAhuReleasedWhereItsRowIsWhole) {
  desk.wish("release");
  EXPECT_EQ(status_after(rows_before + 4)["reason"], "released by hand");
  fs::remove(desk.box() / "inbox" / "release");
  damage_each([](const fs::path& path) { fs::remove(path); });
  EXPECT_EQ(status_after()["reason"], "released by hand") << desk.said();
}

TEST_F(LostState, TakesNoOldBlob) {
  desk.push(7);
  EXPECT_EQ(status_after(rows_before + 4)["pushed_weights"], "on trial");
  fs::remove_all(state);
  desk.push(7);
  const nlohmann::json status = status_after();
  EXPECT_EQ(status["pushed_weights"], "none") << desk.said();
  EXPECT_EQ(status["pushed_refusal"], "blob counter") << desk.said();
  EXPECT_EQ(status["reason"], "state lost");
  fs::remove_all(state);
  fs::remove(log / "push_counters");
  desk.push(7);
  EXPECT_EQ(status_after(rows_after + 4)["pushed_refusal"], "counter unknown") << desk.said();
  desk.push(8);
  EXPECT_EQ(status_after(rows_after + 8)["pushed_refusal"], "counter unknown") << desk.said();
}

TEST_F(LostState, WithoutALossNoneIsTold) {
  const nlohmann::json resumed = status_after();
  EXPECT_EQ(resumed["reason"], "none") << desk.said();
  EXPECT_EQ(resumed["lost_until"], "");
  desk.reset();
  const nlohmann::json fresh = status_after();
  EXPECT_EQ(fresh["reason"], "none") << desk.said();
  EXPECT_EQ(desk.said().find(" is lost"), std::string::npos) << desk.said();
}

}  // namespace
}  // namespace airside::power_loss
