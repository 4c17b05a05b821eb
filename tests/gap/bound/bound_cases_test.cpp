// Sealed cases as tables: the same seed gives the same bytes, the draws are those of the generator, and what is hidden
// in a sensor is seen in that sensor's column.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "hal/text/input_error.hpp"
#include "sim/rc/rc_room_file.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "support/test_folder.hpp"
#include "tools/gap/blind/blind_cases.hpp"
#include "tools/gap/bound/bound_cases.hpp"
#include "tools/gap/model/log_window.hpp"

namespace airside::tools::gap {
namespace {

namespace fs = std::filesystem;

const std::vector<sim::Effect>& bound_effects() {
  static const std::vector<sim::Effect> effects = sim::load_effects(sim::find_effects());
  return effects;
}

BoundPlan small_bound(std::uint64_t seed) {
  BoundPlan plan;
  plan.first_seed = seed;
  plan.cases = 3;
  plan.days = 4;
  plan.rough = true;
  return plan;
}

std::string bytes_of(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

nlohmann::json about(const fs::path& file) { return nlohmann::json::parse(std::ifstream(file)); }

TEST(BoundTables, RepeatEveryByteForASeedAndLeaveWhatIsThere) {
  const hal::TestFolder root("bound_repeat");
  int steps = 0;
  EXPECT_EQ(make_bound_tables(small_bound(5), {}, bound_effects(), root.file("a"), [&steps] { ++steps; }), 1);
  EXPECT_EQ(steps, 3);
  EXPECT_EQ(make_bound_tables(small_bound(5), {}, bound_effects(), root.file("b")), 1);
  EXPECT_EQ(make_bound_tables(small_bound(6), {}, bound_effects(), root.file("b")), 1);
  const fs::path a = root.file("a"), b = root.file("b");
  for (const char* ending : {".bin", ".json"}) {
    const std::string first = bytes_of(a / (std::string("5") + ending));
    EXPECT_FALSE(first.empty());
    EXPECT_EQ(first, bytes_of(b / (std::string("5") + ending)));
    EXPECT_NE(first, bytes_of(b / (std::string("6") + ending)));
  }
  const nlohmann::json j = about(a / "5.json");
  const std::size_t columns = j["columns"].size(), bins = j["bins"];
  EXPECT_EQ(bins, 4U * bins_per_day);
  EXPECT_EQ(bytes_of(a / "5.bin").size(), 3 * 3 * columns * bins * sizeof(std::int16_t));
  std::ofstream(a / "5.bin") << "kept";
  EXPECT_EQ(make_bound_tables(small_bound(5), {}, bound_effects(), a, [&steps] { ++steps; }), 0);
  EXPECT_EQ(steps, 6) << "what is there counts as done";
  EXPECT_EQ(bytes_of(a / "5.bin"), "kept");
}

TEST(BoundTables, HideWhatTheGeneratorHides) {
  const hal::TestFolder root("bound_same");
  BlindPlan blind;
  blind.single = 3;
  blind.seed = 5;
  blind.days = 4;
  blind.rough = true;
  make_blind_cases(blind, bound_effects(), root.file("cases"), root.file("key.json"));
  make_bound_tables_of(root.file("cases"), root.file("key.json"), root.file("tables"), "cases", 1);
  make_bound_tables(small_bound(5), {}, bound_effects(), root.file("tables"));
  const auto hidden = [&](const char* file) {
    std::set<std::string> list;
    const nlohmann::json j = about(fs::path(root.file("tables")) / file);
    for (const nlohmann::json& c : j["cases"])
      list.insert(nlohmann::json{c["id"], c["magnitude"], c["ratio"], c["window"], c["feedback"]}.dump());
    return list;
  };
  EXPECT_EQ(hidden("cases.json").size(), 3U);
  EXPECT_EQ(hidden("cases.json"), hidden("5.json"));
  std::ofstream(root.file("other.json")) << R"({"cases": {}})";
  EXPECT_THROW(make_bound_tables_of(root.file("cases"), root.file("other.json"), root.file("tables"), "other", 1),
               hal::InputError);
}

TEST(BoundTables, ShowABiasedSensorInItsColumnAndInNoOther) {
  const sim::RcRoom twin = sim::load_room("301");
  const RcEngine engine(twin);
  const sim::RcRoom room = with_other_structure(measured_room(twin, 5, false), 5);
  const auto weather = sim::synthetic_weather(3);
  const MeasuredRun run{sim::civil_midnight(2021, 7, 1), 4, 11, false, 0};
  const auto table = [&](const std::vector<Hidden>& hidden) {
    const auto rows = measure(hide(room, hidden, bound_effects()), weather, run, hidden);
    return bound_table(engine, window_of(rows, engine.channels(), weather, "test"));
  };
  const Eigen::MatrixXd moved = table({{"room_sensor_bias", 1, 0.8}}) - table({});
  const BoundColumns columns = bound_columns(engine.channels());
  ASSERT_EQ(moved.cols(), std::ssize(columns.names));
  for (Eigen::Index k = 0; k < moved.cols(); ++k) {
    const std::string& name = columns.names[static_cast<std::size_t>(k)];
    EXPECT_NEAR(moved.col(k).mean(), name == "room_temp_2_degc" ? 0.8 : 0.0, 1e-3) << name;
  }
}

TEST(BoundTables, AreStepsWithAWordForWhatIsMissing) {
  BoundColumns columns{{"a", "b"}, {0.001, 0.1}};
  Eigen::MatrixXd table(2, 2);
  table << 1.2344, 1e9, std::nan(""), -0.05;
  EXPECT_EQ(steps_of(table, columns), (std::vector<std::int16_t>{1234, -32768, 32767, -1}));
}

}  // namespace
}  // namespace airside::tools::gap
