// Figures of the study of nights on which the fan rests.

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>
#include <vector>

#include "tools/run/plant_choice.hpp"
#include "tools/study/night_run.hpp"

namespace airside::tools {
namespace {

/// Two days of rows, all rooms at the target plus so many K.
std::vector<hal::LogRow> rows_of(const Site& site, double (*above_k)(double hour, int day)) {
  std::vector<hal::LogRow> rows;
  for (int i = 0; i < 2 * rows_per_day; ++i) {
    hal::LogRow row = hal::make_log_row(site.counts);
    row.time = {1'627'776'000 + i * std::int64_t{row_s}};
    for (int room = 0; room < site.counts.vavs; ++room) {
      row.value[static_cast<std::size_t>(room)] =
          site.settings.target_degc + above_k(row.time.second_of_day() / 3600.0, i / rows_per_day);
    }
    rows.push_back(row);
  }
  return rows;
}

TEST(NightFigures, CountTheHoursAfterTheFansStart) {
  const Site site = resting_site(6, 20);
  EXPECT_EQ(site.settings.fan_start_h, 6);
  const auto rows = rows_of(site, [](double hour, int day) {
    return hour < 6 ? 5.0 : hour < 7 ? -2.0 : hour < 9 ? 0.5 : day == 0 ? 0.1 : 0.2;
  });
  const NightFigures f = night_figures(site, rows, 6);
  EXPECT_NEAR(f.first_hour_degc, 2.0, 1e-9);
  EXPECT_NEAR(f.first_three_hours_degc, 1.0, 1e-9);
  EXPECT_NEAR(f.first_day_degc, 1.0, 1e-9);
  EXPECT_NEAR(f.working_degc, (2 * 0.5 + 10 * 0.15) / 12, 1e-9);
  EXPECT_THROW((void)night_figures(site, {}, 6), std::invalid_argument);
}

TEST(NightFigures, TheRoomOfTheRunRestsOutsideTheFansHours) {
  PlantChoice choice;
  choice.kind = "rc";
  choice.room = "401-real";
  choice.fan_start_h = 6;
  choice.fan_stop_h = 20;
  const Site site = resting_site(6, 20);
  const auto resting = make_plant(choice, site, 1);
  choice.fan_start_h = choice.fan_stop_h = 0;
  const auto running = make_plant(choice, site, 1);
  const CivilTime morning{start_of(choice).seconds + 5 * 3600};
  for (const auto& plant : {resting.get(), running.get()}) {
    plant->set_setpoint(20);
    plant->advance_to(morning);
  }
  EXPECT_GT(resting->sensors().room_temp_degc[0], running->sensors().room_temp_degc[0] + 1);
}

}  // namespace
}  // namespace airside::tools
