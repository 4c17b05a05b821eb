// A test done on a hidden room of EnergyPlus: the room is the one of the measured log, and obeys.

#include <gtest/gtest.h>

#include <fstream>

#include "gap/needs_engine.hpp"
#include "support/test_folder.hpp"
#include "tools/gap/blind/blind_cases.hpp"
#include "tools/gap/blind/blind_tests.hpp"
#include "tools/gap/case/case_format.hpp"
#include "tools/gap/case/case_tests.hpp"
#include "tools/run/site.hpp"

namespace airside::tools::gap {
namespace {

TEST(TestedCasesEnergyPlus, RoomObeysATestThatItsThermostatsWouldNotWant) {
  AIRSIDE_NEEDS_ENGINE();
  const auto effects = sim::load_effects(sim::find_effects());
  const hal::TestFolder root("tested_energyplus");
  BlindPlan plan;
  plan.null = 1;  // the first case of a window has feedback: fan coils follow thermostats
  plan.engine = BlindEngine::energyplus;
  plan.days = 4;
  plan.window = 3;
  plan.seed = 12;
  plan.rough = true;
  plan.jobs = 1;
  make_blind_cases(plan, effects, root.file("cases"), root.file("key.json"));

  BlindTests tests;
  tests.folder = root.file("cases");
  tests.key = nlohmann::json::parse(std::ifstream(root.file("key.json")));
  const nlohmann::json proposal = {{"name", "fcu_on_night@2"}, {"comfortable", true}, {"power", 0.9}};
  tests.verdicts = {{"verdicts", {{{"case", "case-0001"}, {"verdict", "ambiguous"}, {"experiments", {proposal}}}}}};
  const auto done = do_blind_tests(tests, effects, SafetyEnvelope(built_in_site().settings));
  ASSERT_EQ(done.size(), 1U);
  EXPECT_EQ(done[0].test, "fcu_on_night@2") << done[0].why_not;

  const auto folder = case_folders(tests.folder).front();
  const auto written = read_case_tests(folder);
  ASSERT_EQ(written.size(), 1U);
  const hal::Log log =
      hal::read_log((folder / written[0].log).string(), {"", 5, 5, 2}, {hal::default_log_limits, true});
  EXPECT_EQ(log.rows.size(), 5U * rows_per_day);
  constexpr std::size_t temp_of_coil_2 = 6, coil_1 = 15, coil_2 = 16;
  double cooled_k = 0;
  int nights = 0;
  for (const hal::LogRow& row : log.rows) {
    const int hour = row.time.second_of_day() / 3600;
    const bool commanded = row.time.seconds >= written[0].from.seconds + 20 * 3600 && (hour >= 20 || hour < 6);
    if (std::isfinite(row.value[coil_2]) && (commanded || hour >= 20 || hour < 6)) {
      EXPECT_EQ(row.value[coil_2], commanded ? 1 : 0) << sim::text_of(row.time);
    }
    if (std::isfinite(row.value[coil_1]) && hour >= 20) {
      EXPECT_EQ(row.value[coil_1], 0) << sim::text_of(row.time);
    }
    if (hour != 5 || !std::isfinite(row.value[temp_of_coil_2])) continue;
    cooled_k += commanded ? -row.value[temp_of_coil_2] / 20 : row.value[temp_of_coil_2] / 30;
    nights += commanded ? 1 : 0;
  }
  EXPECT_GE(nights, 18);
  EXPECT_GT(cooled_k, 0.5) << "its zone is cooler after nights in which it ran";
}

}  // namespace
}  // namespace airside::tools::gap
