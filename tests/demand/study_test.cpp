// The objective "band" on whole buildings, beside Guideline 36 and constants. The full tables are of
// `airside study boxes`.

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "sim/weather/weather.hpp"
#include "tools/study/box_run.hpp"

namespace {

using namespace airside;
using namespace airside::tools;

BoxRun run_of(const char* scenario, int month, std::uint64_t seed = 1) {
  return {.scenario = scenario, .seed = seed, .from = sim::civil_midnight(2021, month, 8), .days = 14};
}

const BoxMethod band{.kind = BoxMethod::Kind::band};

TEST(BandStudy, TakesNoMoreThanGuideline36WithZonesInTheirBand) {
  for (const char* scenario : {"humid", "mild", "reheat", "duct"}) {
    for (const int month : {4, 7, 10}) {
      const BoxRun run = run_of(scenario, month);
      const BoxFigures ours = run_boxes(run, band);
      const BoxFigures guideline = run_boxes(run, {.kind = BoxMethod::Kind::guideline36, .degc = 16});
      EXPECT_LT(ours.total_kwh(), 1.005 * guideline.total_kwh()) << scenario << ", month " << month;
      EXPECT_LT(ours.above_degch, guideline.above_degch + 1.0) << scenario << ", month " << month;
    }
  }
}

TEST(BandStudy, SavesWhereTheWeatherChanges) {
  for (const char* scenario : {"mild", "reheat"}) {
    const BoxRun run = run_of(scenario, 4, 2);
    const double ours = run_boxes(run, band).total_kwh();
    EXPECT_LT(ours, 0.95 * run_boxes(run, {.kind = BoxMethod::Kind::guideline36, .degc = 16}).total_kwh()) << scenario;
    std::vector<BoxFigures> constants;
    for (int i = 0; i <= 12; ++i) constants.push_back(run_boxes(run, {.degc = 12 + 0.5 * i}));
    EXPECT_LT(ours, constants[best_constant(constants)].total_kwh()) << scenario;
  }
}

TEST(BandStudy, NothingLeavesTheEnvelope) {
  const ControllerSettings site = box_site_settings();
  for (const char* scenario : {"mild", "reheat"}) {
    const BoxFigures ours = run_boxes(run_of(scenario, 10, 3), band);
    EXPECT_GE(ours.lowest_degc, site.limit_min_degc);
    EXPECT_LE(ours.highest_degc, site.limit_max_degc);
  }
}

TEST(BandStudy, WithoutDampersItIsTheSchedule) {
  BoxRun run = run_of("mild", 10);
  run.days = 4;
  run.blind_from_day = -100;  // never seen at all
  const BoxFigures blind = run_boxes(run, band), schedule = run_boxes(run, {.degc = 14});
  EXPECT_EQ(blind.lowest_degc, 14);
  EXPECT_EQ(blind.highest_degc, 14);
  EXPECT_EQ(blind.total_kwh(), schedule.total_kwh());
}

TEST(BandStudy, DampersThatAreLostUnderwayDoNoHarm) {
  BoxRun run = run_of("mild", 10);
  run.days = 8;
  run.blind_from_day = 4;
  const BoxFigures blind = run_boxes(run, band), schedule = run_boxes(run, {.degc = 14});
  EXPECT_LT(blind.total_kwh(), 1.01 * schedule.total_kwh());
  EXPECT_LT(blind.above_degch, schedule.above_degch + 0.5);
}

TEST(BandStudy, TheBestConstantKeepsZonesInTheirBandFirst) {
  const auto of = [](double kwh, double above) {
    BoxFigures f;
    f.fan_kwh = kwh;
    f.above_degch = above;
    return f;
  };
  EXPECT_EQ(best_constant({of(10, 0.5), of(9, 0.6), of(8, 3)}), 1u);
}

}  // namespace
