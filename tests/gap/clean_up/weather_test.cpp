// Whether the weather beside a log is that of its days.

#include <cmath>
#include <numbers>

#include "gap/clean_up_case.hpp"
#include "hal/text/input_error.hpp"
#include "sim/stateless_draw.hpp"

namespace airside::tools::gap {
namespace {

CleanUpContext beside_year(std::uint64_t seed) {
  CleanUpContext context = july().context;
  context.station = sim::synthetic_weather(seed);
  return context;
}

const Remark* of_weather(const CleanLog& log) {
  for (const Remark& r : log.remarks)
    if (r.defect == Defect::other_weather) return &r;
  return nullptr;
}

/// Another outdoor temperature in every row, from the time and what was logged.
Rows with_outdoor(const std::function<double(CivilTime, double)>& shown) {
  Rows rows = july().rows;
  for (hal::LogRow& row : rows) outdoor(row) = hundredths(shown(row.time, outdoor(row)));
  return rows;
}

TEST(CleanUpWeather, WarnsOfAnotherYearsWeatherWithItsFigures) {
  int found = 0;
  constexpr int years = 12;
  for (std::uint64_t seed = 100; seed < 100 + years; ++seed) {
    const CleanLog log = clean_up(july().rows, beside_year(seed));
    ASSERT_TRUE(log.outdoor_difference.has_value());
    EXPECT_GT(log.outdoor_difference->rms_k, 0.4);
    const Remark* r = of_weather(log);
    if (r == nullptr) continue;
    ++found;
    EXPECT_EQ(r->column, "outdoor_temp_degc");
    EXPECT_NE(r->text.find("K rms about a mean of"), std::string::npos) << r->text;
    EXPECT_NE(r->text.find("another year or another place"), std::string::npos) << r->text;
    EXPECT_NE(r->text.find("seed " + std::to_string(seed)), std::string::npos) << "the weather's name: " << r->text;
    if (r->action == Action::refused) continue;
    EXPECT_EQ(r->action, Action::warned);
    EXPECT_TRUE(log.usable());
    EXPECT_NE(r->text.find("sun, humidity and wind"), std::string::npos) << "what is in doubt: " << r->text;
    EXPECT_NE(warnings_text(log).find("room.csv: outdoor temperatures"), std::string::npos) << warnings_text(log);
  }
  EXPECT_GE(found, years - 1) << "14 days of made-up years: 1 % are missed";
}

TEST(CleanUpWeather, RefusesDaysThatHaveNothingInCommon) {
  const auto& station = *july().context.station;
  const Rows rows = with_outdoor([&](CivilTime t, double) {  // warm where the station's days are cool
    return 54 - station.at(t).outdoor_temp_degc;
  });
  const CleanLog log = clean_up(rows, july().context);
  const Remark* r = of_weather(log);
  ASSERT_NE(r, nullptr) << told(log.remarks);
  EXPECT_EQ(r->action, Action::refused) << r->text;
  EXPECT_NE(r->remedy.find("--weather"), std::string::npos) << r->remedy;
  EXPECT_LT(log.outdoor_difference->daily_correlation, 0);
  EXPECT_THROW(log.require_usable(), hal::InputError);
}

TEST(CleanUpWeather, SaysNothingOfASensorThatIsOffInTheSunNoisyAndByAClock) {
  const CleanLog right = clean_up(july().rows, july().context);
  EXPECT_EQ(of_weather(right), nullptr);
  ASSERT_TRUE(right.outdoor_difference.has_value());
  EXPECT_LT(right.outdoor_difference->rms_k, 0.1);
  EXPECT_EQ(right.outdoor_difference->lag_min, 0);
  const auto& station = *july().context.station;
  const Rows rows = with_outdoor([&](CivilTime t, double) {
    const double hour = t.second_of_day() / 3600.0;
    const double sun_k = hour > 13 && hour < 18 ? 3 * std::sin(std::numbers::pi * (hour - 13) / 5) : 0;
    const double noise_k = 0.5 * sim::draw_normal(3, 77, 0, t.seconds / 3600);
    return station.at({t.seconds - 2 * 3600}).outdoor_temp_degc + 4 + sun_k + noise_k;
  });
  const CleanLog log = clean_up(rows, july().context);
  EXPECT_EQ(of_weather(log), nullptr) << told(log.remarks);
  EXPECT_GT(log.outdoor_difference->mean_k, 3);
  EXPECT_GT(log.outdoor_difference->rms_k, 1) << "which alone would look like another year";
  EXPECT_NEAR(log.outdoor_difference->lag_min, 120, 40);
  EXPECT_LT(log.outdoor_difference->shifted_rms_k, log.outdoor_difference->rms_k);
  EXPECT_NEAR(log.outdoor_difference->irregular_k, 0.5, 0.2);
}

TEST(CleanUpWeather, SaysNothingWithoutAStationOrWithAStandInForTheSensor) {
  CleanUpContext context = beside_year(100);
  context.counts.stand_ins.resize(static_cast<std::size_t>(context.counts.signals()));
  context.counts.stand_ins[static_cast<std::size_t>(context.counts.signals() - 2)] = 25;
  CleanLog log = clean_up(july().rows, context);
  EXPECT_FALSE(log.outdoor_difference.has_value());
  EXPECT_EQ(of_weather(log), nullptr);
  context = july().context;
  context.station = nullptr;
  log = clean_up(july().rows, context);
  EXPECT_FALSE(log.outdoor_difference.has_value());
}

}  // namespace
}  // namespace airside::tools::gap
