// Every figure against numbers worked out by hand.

#include <gtest/gtest.h>

#include <functional>
#include <limits>

#include "hal/text/input_error.hpp"
#include "support/default_cycle.hpp"
#include "tools/run/metrics.hpp"

namespace airside::tools {
namespace {

constexpr std::int64_t monday = 4 * 86400;  // 1970-01-05

/// Full days from `monday` on; `fill` sets room mean and setpoint from day and cycle of the day.
std::vector<CycleSample> days_of(int days, const std::function<void(int, int, CycleSample&)>& fill) {
  std::vector<CycleSample> samples;
  for (int d = 0; d < days; ++d) {
    for (int k = 0; k < cycles_per_day; ++k) {
      CycleSample s;
      s.time = {monday + d * 86400 + k * cycle_s};
      s.room_mean_degc = 25.25;
      s.setpoint_degc = 22.5;
      fill(d, k, s);
      samples.push_back(s);
    }
  }
  return samples;
}

TEST(Metrics, ScoreFortySamplesADayFromCycle24ToCycle63) {
  EXPECT_FALSE(is_scored({monday + 23 * cycle_s}));
  EXPECT_TRUE(is_scored({monday + 24 * cycle_s}));
  EXPECT_TRUE(is_scored({monday + 63 * cycle_s}));
  EXPECT_FALSE(is_scored({monday + 64 * cycle_s}));
  const auto samples = days_of(1, [](int, int k, CycleSample& s) {
    if (k == 23 || k == 64) s.room_mean_degc = 99;  // must not count
    if (k == 24) s.room_mean_degc += 1;             // first scored sample
    if (k == 63) s.room_mean_degc -= 2;             // last scored sample
  });
  const Metrics m = compute_metrics(samples, {});
  EXPECT_EQ(m.days.at(0).samples, 40);
  EXPECT_NEAR(m.dae_degc, 3.0 / 40, 1e-12);
  EXPECT_NEAR(m.degree_hours_above_degch, 0.3, 1e-12);
  EXPECT_NEAR(m.degree_hours_below_degch, 0.6, 1e-12);
  EXPECT_NEAR(m.degree_hours_degch, 0.9, 1e-12);
}

TEST(Metrics, AverageDaeIsTheMeanOverDaysAndMeTheWorstDay) {
  const double error[] = {0.1, -0.7, 0.4};
  const auto samples = days_of(3, [&](int d, int, CycleSample& s) { s.room_mean_degc += error[d]; });
  const Metrics m = compute_metrics(samples, {});
  ASSERT_EQ(m.days.size(), 3u);
  EXPECT_NEAR(m.days[1].dae_degc, 0.7, 1e-12);
  EXPECT_NEAR(m.dae_degc, 0.4, 1e-12);
  EXPECT_NEAR(m.me_degc, 0.7, 1e-12);
  EXPECT_NEAR(m.day1_dae_degc, 0.1, 1e-12);
  EXPECT_NEAR(m.degree_hours_degch, 0.4 * 12, 1e-12);
  EXPECT_EQ(m.days[2].midnight.seconds, monday + 2 * 86400);
}

TEST(Metrics, WorstRoomIsThatOfEachDayAndNotOfTheRun) {
  // Room 1 is 2 K off on the first day, room 2 is 1 K off on the second.
  const auto samples = days_of(2, [](int d, int, CycleSample& s) {
    s.room_temp_degc = {25.25 + (d == 0 ? 2.0 : 0.0), 25.25 - (d == 1 ? 1.0 : 0.0), 25.25};
  });
  const Metrics m = compute_metrics(samples, {});
  EXPECT_NEAR(m.days[0].worst_room_dae_degc, 2, 1e-12);
  EXPECT_NEAR(m.days[1].worst_room_dae_degc, 1, 1e-12);
  EXPECT_NEAR(m.worst_room_dae_degc, 1.5, 1e-12);
  EXPECT_NEAR(m.room_dae_degc[0], 1, 1e-12);
  EXPECT_NEAR(m.rooms_dae_degc, (1 + 0.5 + 0) / 3, 1e-12);
}

TEST(Metrics, DarvOfAHandSeriesUsesThePrintedDivisor) {
  // Setpoint 20 but for cycle 30: second differences +1, -2, +1, so the sum is 4; n = 40, divisor 37.
  const auto samples = days_of(1, [](int, int k, CycleSample& s) { s.setpoint_degc = k == 30 ? 21 : 20; });
  const Metrics m = compute_metrics(samples, {});
  EXPECT_NEAR(m.darv_degc, 4.0 / 37, 1e-12);
  EXPECT_NEAR(m.darv_full_day_degc, 4.0 / 77, 1e-12);
}

TEST(Metrics, DarvIgnoresWhatHappensOutsideWorkingHoursAndStartsAnewEachDay) {
  // The schedule jumps at cycle 24 and 64 and every day has another level: neither is variation within a day.
  const auto samples =
      days_of(2, [](int d, int k, CycleSample& s) { s.setpoint_degc = k >= 24 && k <= 63 ? 20.5 + d : 25.0; });
  const Metrics m = compute_metrics(samples, {});
  EXPECT_NEAR(m.darv_degc, 0.0, 1e-12);
  // Full day: |-4.5| + |4.5| at each of two steps; second day 3.5. Sums 18 and 14, divisor 77.
  EXPECT_NEAR(m.days[0].darv_full_day_degc, 18.0 / 77, 1e-12);
  EXPECT_NEAR(m.days[1].darv_full_day_degc, 14.0 / 77, 1e-12);
}

TEST(Metrics, DarvOfARampIsZeroAndOfASawtoothIsFourTimesItsHalfHeight) {
  const auto ramp = days_of(1, [](int, int k, CycleSample& s) { s.setpoint_degc = 20 + 0.05 * k; });
  EXPECT_NEAR(compute_metrics(ramp, {}).darv_degc, 0.0, 1e-12);
  const auto saw = days_of(1, [](int, int k, CycleSample& s) { s.setpoint_degc = 22 + (k % 2 ? 0.1 : -0.1); });
  EXPECT_NEAR(compute_metrics(saw, {}).darv_degc, 38 * 0.4 / 37, 1e-12);
}

TEST(Metrics, DarvLeavesOutTermsAcrossAGap) {
  auto samples = days_of(1, [](int, int k, CycleSample& s) { s.setpoint_degc = k < 40 ? 20 : 24; });
  samples.erase(samples.begin() + 38, samples.begin() + 44);  // the jump falls into the hole
  EXPECT_NEAR(compute_metrics(samples, {}).darv_degc, 0.0, 1e-12);
}

TEST(Metrics, CdhCountsRoomsWarmerThanTheSetpointAndHdhTheReverse) {
  const auto cooling = days_of(2, [](int, int, CycleSample& s) { s.setpoint_degc = 22.25; });
  Metrics m = compute_metrics(cooling, {});
  EXPECT_NEAR(m.cdh_degch, 2 * 40 * 3.0 * 0.3, 1e-9);
  EXPECT_NEAR(m.hdh_degch, 0.0, 1e-12);
  const auto heating = days_of(1, [](int, int, CycleSample& s) { s.setpoint_degc = 25.75; });
  m = compute_metrics(heating, {});
  EXPECT_NEAR(m.cdh_degch, 0.0, 1e-12);
  EXPECT_NEAR(m.hdh_degch, 40 * 0.5 * 0.3, 1e-9);
}

TEST(Metrics, EnergyIntegratesEveryRowWorkingHoursOrNot) {
  std::vector<EnergyRow> rows;
  for (int i = 0; i < 2 * rows_per_day; ++i) rows.push_back({{monday + i * row_s}, i < rows_per_day ? 1.0 : 3.0});
  const Metrics m = compute_metrics(days_of(2, [](int, int, CycleSample&) {}), rows);
  EXPECT_NEAR(m.hvac_kwh, 24 + 72, 1e-9);
  EXPECT_NEAR(m.hvac_kwh_per_day, 48, 1e-9);
}

TEST(Metrics, SavedAreaIsSignedOverAllCyclesAndAlsoUnsigned) {
  // 60 cycles 2 K above the reference, 20 cycles 0.5 K below it.
  const auto samples = days_of(1, [](int, int k, CycleSample& s) { s.setpoint_degc = k < 60 ? 22.5 : 20.0; });
  const Metrics m = compute_metrics(samples, {});
  EXPECT_NEAR(m.saved_area_degch, (60 * 2.0 - 20 * 0.5) * 0.3, 1e-9);
  EXPECT_NEAR(m.saved_area_unsigned_degch, (60 * 2.0 + 20 * 0.5) * 0.3, 1e-9);
}

TEST(Metrics, RoomDaeIsKeptApartFromTheMean) {
  // Two rooms 0.6 K either side of the target: the mean is perfect, the rooms are not.
  const auto samples = days_of(2, [](int, int, CycleSample& s) { s.room_temp_degc = {25.25 + 0.6, 25.25 - 0.6}; });
  const Metrics m = compute_metrics(samples, {});
  EXPECT_NEAR(m.dae_degc, 0.0, 1e-12);
  ASSERT_EQ(m.room_dae_degc.size(), 2u);
  EXPECT_NEAR(m.room_dae_degc[0], 0.6, 1e-12);
  EXPECT_NEAR(m.room_dae_degc[1], 0.6, 1e-12);
}

TEST(Metrics, WeekendsAreLeftOutWhenTheSiteWorksOnWeekdaysOnly) {
  const auto samples = days_of(7, [](int d, int, CycleSample& s) { s.room_mean_degc += d >= 5 ? 3 : 0.2; });
  MetricsSettings settings;
  settings.weekdays_only = true;
  const Metrics m = compute_metrics(samples, {}, settings);
  EXPECT_EQ(m.days.size(), 5u);
  EXPECT_NEAR(m.dae_degc, 0.2, 1e-12);
  EXPECT_GT(compute_metrics(samples, {}).dae_degc, 0.9);
}

TEST(Metrics, OtherControlCyclesScoreTheirOwnNumberOfSamples) {
  std::vector<CycleSample> samples;
  for (int k = 0; k < 240; ++k) samples.push_back({{monday + k * 360}, 25.75, {}, 22.0});
  MetricsSettings settings;
  settings.cycle_s = 360;
  const Metrics m = compute_metrics(samples, {}, settings);
  EXPECT_EQ(m.days[0].samples, 120);
  EXPECT_NEAR(m.degree_hours_degch, 6.0, 1e-9);
}

TEST(Metrics, RefuseSamplesThatCannotBeScored) {
  auto samples = days_of(1, [](int, int, CycleSample& s) { s.room_temp_degc = {25.0}; });
  EXPECT_THROW(compute_metrics({}, {}), hal::InputError);
  auto broken = samples;
  broken[30].room_mean_degc = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(compute_metrics(broken, {}), hal::InputError);
  broken = samples;
  broken[31].time = broken[30].time;
  EXPECT_THROW(compute_metrics(broken, {}), hal::InputError);
  broken = samples;
  broken[31].room_temp_degc.push_back(25.0);
  EXPECT_THROW(compute_metrics(broken, {}), hal::InputError);
  broken.assign(samples.begin(), samples.begin() + 20);  // night only
  EXPECT_THROW(compute_metrics(broken, {}), hal::InputError);
  const std::vector<EnergyRow> rows = {{{monday}, std::numeric_limits<double>::infinity()}};
  EXPECT_THROW(compute_metrics(samples, rows), hal::InputError);
}

TEST(Spread, IsMeanAndSampleDeviation) {
  const std::vector<double> values = {1, 2, 3, 4};
  const Spread s = spread_of(values);
  EXPECT_NEAR(s.mean, 2.5, 1e-12);
  EXPECT_NEAR(s.sd, 1.2909944487358056, 1e-12);
  EXPECT_EQ(s.count, 4);
  EXPECT_EQ(spread_of(std::vector<double>{7}).sd, 0.0);
  EXPECT_EQ(spread_of(std::vector<double>{}).count, 0);
}

}  // namespace
}  // namespace airside::tools
