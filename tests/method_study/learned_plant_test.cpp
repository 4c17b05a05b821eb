// A learned environment: the network of its file moves the temperatures, the log moves all else.

#include <gtest/gtest.h>

#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>
#include <string>

#include "hal/text/input_error.hpp"
#include "sim/learned/learned_plant.hpp"
#include "support/program.hpp"

namespace airside::sim {
namespace {

constexpr std::int64_t day_s = 86400;
constexpr CivilTime from{18833 * day_s};  // 2021-07-25
constexpr int rows = 2 * rows_per_day;

/// One VAV box, no fan coil, no meter: S, VAV on, MAU, outdoors, rain, then A.
class LearnedPlantTest : public testing::Test {
 protected:
  LearnedPlantTest() {
    counts_.name = "1vav-0fcu-0power";
    counts_.vavs = 1;
    write_log(rows);
    model_ = {
        {"format", "airside learned environment 1"},
        {"log", "room.csv"},
        {"columns", {"room_temp_1_degc", "vav_on_1", "mau_temp_degc", "outdoor_temp_degc", "rain", "setpoint_degc"}},
        {"test_from", "2021-07-25"},
        {"slope", 0.5},
        {"mean", {25, 0, 18, 30, 0, 23}},
        {"scale", {2, 1, 1, 5, 1, 2}},
        {"out_scale", {0.1}},
        // Two units: one follows the setpoint, the other the outdoor temperature against it.
        {"layers",
         {{{"weight", {{0, 0, 0, 0, 0, 1}, {0, 0, 0, 1, 0, 0}}}, {"bias", {0, 0}}},
          {{"weight", {{1, 1}}}, {"bias", {0}}}}}};
  }

  void write_log(int count, int left_out = -1) const {
    hal::LogWriter log((folder_.path() / "room.csv").string(), counts_, false);
    for (int i = 0; i < count; ++i) {
      hal::LogRow row = hal::make_log_row(counts_);
      row.time = {from.seconds + i * row_s};
      row.value = {26, 1, 18, 30.0 + i % 3, 0};
      row.setpoint_degc = 20;
      if (i != left_out) log.append(row);
    }
    log.close();
  }
  std::string file() const {
    const fs::path path = folder_.path() / "environment.json";
    std::ofstream(path) << model_.dump();
    return path.string();
  }
  LearnedPlant plant(CivilTime start = from) const {
    return {std::make_shared<const LearnedEnvironment>(read_environment(file(), counts_)), counts_, start, 25};
  }
  /// What is said of the file after `change`.
  std::string refusal(const std::function<void(nlohmann::json&)>& change) {
    const nlohmann::json good = model_;
    change(model_);
    std::string said = "nothing";
    try {
      (void)read_environment(file(), counts_);
    } catch (const hal::InputError& e) {
      said = e.what();
    }
    model_ = good;
    return said;
  }

  TemporaryFolder folder_;
  hal::TopologyCounts counts_;
  nlohmann::json model_;
};

TEST_F(LearnedPlantTest, TemperaturesFollowTheNetwork) {
  LearnedPlant room = plant();
  EXPECT_EQ(room.time().seconds, from.seconds);
  EXPECT_DOUBLE_EQ(room.sensors().room_temp_degc.at(0), 26);  // the log's, once
  // Setpoint 25: unit 1 is (25 - 23) / 2 = 1. Outdoors 30: unit 2 is 0. 0.1 K in a row.
  room.advance_to({from.seconds + row_s});
  EXPECT_NEAR(room.sensors().room_temp_degc.at(0), 26.1, 1e-9);
  // Outdoors 31: 0.2. Setpoint 21: -1, which LeakyReLU makes -0.5.
  room.set_setpoint(21);
  room.advance_to({from.seconds + 2 * row_s});
  EXPECT_NEAR(room.sensors().room_temp_degc.at(0), 26.1 + 0.1 * (0.2 - 0.5), 1e-9);
}

TEST_F(LearnedPlantTest, AllElseIsTheLogs) {
  LearnedPlant room = plant();
  for (int i = 1; i < 7; ++i) {
    room.advance_to({from.seconds + i * row_s});
    EXPECT_DOUBLE_EQ(room.sensors().outdoor_temp_degc, 30.0 + i % 3);
    EXPECT_DOUBLE_EQ(room.sensors().vav_on.at(0), 1);
    EXPECT_DOUBLE_EQ(room.sensors().mau_temp_degc, 18);
    EXPECT_DOUBLE_EQ(room.sensors().setpoint_degc, 25);
  }
}

TEST_F(LearnedPlantTest, TheEndOfItsLogIsSaid) {
  LearnedPlant room = plant();
  room.advance_to({from.seconds + (rows - 1) * row_s});
  try {
    room.advance_to({from.seconds + rows * row_s});
    FAIL() << "ran past its log";
  } catch (const hal::InputError& e) {
    EXPECT_NE(std::string(e.what()).find("2021-07-26T23:54"), std::string::npos) << e.what();
  }
}

TEST_F(LearnedPlantTest, StartsAtAnyRowOfItsLogAndNoOther) {
  EXPECT_DOUBLE_EQ(plant({from.seconds + day_s + row_s}).sensors().outdoor_temp_degc, 31);
  for (const std::int64_t s : {-row_s, 2, rows * row_s})
    EXPECT_THROW((void)plant({from.seconds + s}), hal::InputError) << s;
}

TEST_F(LearnedPlantTest, ABadFileIsRefusedByItsField) {
  const auto says = [this](const char* part, const std::function<void(nlohmann::json&)>& change) {
    const std::string said = refusal(change);
    EXPECT_NE(said.find("environment.json: " + std::string(part)), std::string::npos) << said;
  };
  says("format", [](auto& j) { j["format"] = "another"; });
  says("mean: found 5 numbers; expected 6", [](auto& j) { j["mean"].erase(0); });
  says("scale: found a number that is not above 0", [](auto& j) { j["scale"][2] = 0; });
  says("out_scale", [](auto& j) { j.erase("out_scale"); });
  says("columns[3]: found \"sun\"", [](auto& j) { j["columns"][3] = "sun"; });
  says("layers[0].weight[1]: found 5 numbers; expected 6", [](auto& j) { j["layers"][0]["weight"][1].erase(0); });
  says("layers[1].weight[0][1]: found \"one\"", [](auto& j) { j["layers"][1]["weight"][0][1] = "one"; });
  says("layers: found 2 outputs of the last one; expected 1", [](auto& j) { j["layers"].erase(1); });
  says("slope", [](auto& j) { j["slope"] = "steep"; });
  says("test_from", [](auto& j) { j["test_from"] = "in July"; });
  says("log", [](auto& j) { j["log"] = 3; });
}

TEST_F(LearnedPlantTest, ALogThatLacksTheDaysIsRefused) {
  EXPECT_NE(refusal([](auto& j) { j["test_from"] = "2021-07-27"; }).find("room.csv: found 0 rows from 2021-07-27"),
            std::string::npos);
  write_log(rows, 100);
  EXPECT_NE(refusal([](auto&) {}).find("found a gap after 2021-07-25T09:54"), std::string::npos);
}

}  // namespace
}  // namespace airside::sim
