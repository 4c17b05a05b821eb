// Amounts of missing heat are said with an interval that holds, in digits that fit it.

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "sim/weather/synthetic_weather.hpp"
#include "tools/gap/explain/flux.hpp"
#include "tools/gap/explain/interval_text.hpp"

namespace airside::tools::gap {
namespace {

constexpr sim::Channels three_rooms{3, 0, 1};

sim::Recording days_of_july(int days) {
  sim::Recording recording;
  recording.from = sim::civil_midnight(2023, 7, 3);
  recording.station = sim::synthetic_weather(1);
  recording.rows.assign(static_cast<std::size_t>(days) * rows_per_day, {23, {1, 1, 1}, {}, 30, 0, {}});
  return recording;
}

/// Heat between 9 and 17 h in the second room, `kw` of the day; chance is known to be next to nothing.
template <class OfDay>
UnknownHeat described(int days, const OfDay& kw) {
  const sim::Recording recording = days_of_july(days);
  UnknownHeat heat;
  heat.heat_kw = Eigen::MatrixXd::Zero(days * bins_per_day, 3);
  for (int day = 0; day < days; ++day) heat.heat_kw.col(1).segment(day * bins_per_day + 18, 16).setConstant(kw(day));
  const HeatSd of_chance = [](int, const Eigen::VectorXd&) { return 0.004; };
  describe_heat(heat, recording, three_rooms, of_chance, {});
  return heat;
}

TEST(HeatInterval, HoldsAnAmountThatIsNinePercentWrongAndIsNeverNothing) {
  const UnknownHeat heat = described(8, [](int) { return 2.5; });
  const ZoneHeat& z = heat.zones[1];
  ASSERT_TRUE(z.above_noise);
  EXPECT_GT(1.96 * z.active_sd_kw, 0.09 * 2.5) << "the twin is not right to a thousandth";
  EXPECT_NE(z.text.find("by about 2.5 ± 0.9 kW"), std::string::npos) << z.text;
  EXPECT_EQ(z.text.find("± 0.0 "), std::string::npos) << z.text;
  EXPECT_FALSE(heat.zones[0].above_noise) << "whether there is heat is still a question of chance alone";
}

TEST(HeatInterval, IsWiderWhereDaysDiffer) {
  const UnknownHeat even = described(9, [](int) { return 2.0; });
  const UnknownHeat uneven = described(9, [](int day) { return day % 2 == 0 ? 0.5 : 3.5; });
  EXPECT_GT(uneven.zones[1].active_sd_kw, 1.3 * even.zones[1].active_sd_kw);
}

TEST(IntervalText, HasTheDigitsThatTheIntervalLeaves) {
  EXPECT_EQ(with_interval(2.5, 0.3), "2.5 ± 0.3");
  EXPECT_EQ(with_interval(2.512, 0.0088), "2.512 ± 0.009");
  EXPECT_EQ(with_interval(0.8, 0.144), "0.80 ± 0.14");
  EXPECT_EQ(with_interval(12.3, 2.2), "12 ± 2");
  EXPECT_EQ(with_interval(1234, 33), "1230 ± 30");
  EXPECT_EQ(with_interval(2.5, 0), "2.5") << "an interval of nothing is not known";
  EXPECT_EQ(with_interval(2.5, std::nan("")), "2.5");
}

}  // namespace
}  // namespace airside::tools::gap
