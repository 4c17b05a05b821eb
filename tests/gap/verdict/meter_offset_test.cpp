// Power that a meter shows beyond the model: found with its hours and size, and not made out of noise.

#include "tools/gap/explain/meter_offset.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

#include "tools/gap/explain/day_stretch.hpp"
#include "tools/gap/model/residual.hpp"

namespace airside::tools::gap {
namespace {

constexpr int metered_days = 14;

class MeterOffsetTest : public ::testing::Test {
 protected:
  MeterOffsetTest() {
    recording.from = sim::civil_midnight(2021, 7, 5);
    recording.rows.resize(metered_days * rows_per_day);
    std::mt19937 random(3);
    std::normal_distribution<double> noise(0, 0.2);
    residual = Eigen::MatrixXd::NullaryExpr(metered_days * bins_per_day, at.count(), [&] { return noise(random); });
  }
  /// On the second meter, every day.
  void add(double kw, int from_bin, int to_bin) {
    for (int day = 0; day < metered_days; ++day) {
      for (int bin = from_bin; bin < to_bin; ++bin)
        residual((day * bins_per_day + bin) % residual.rows(), at.power() + 1) += kw;
    }
  }

  const sim::Channels at{2, 0, 2};
  sim::Recording recording;
  Eigen::MatrixXd residual;
};

TEST_F(MeterOffsetTest, FindsAPumpThatRunsByDay) {
  add(1.2, 16, 36);
  residual(3 * bins_per_day + 20, at.power() + 1) = std::numeric_limits<double>::quiet_NaN();
  const auto offsets = meter_offsets(residual, recording, at);
  ASSERT_EQ(offsets.size(), 2U);
  EXPECT_FALSE(offsets[0].above_noise) << offsets[0].text;
  EXPECT_TRUE(offsets[1].above_noise);
  EXPECT_EQ(offsets[1].from_h, 8);
  EXPECT_EQ(offsets[1].to_h, 18);
  EXPECT_NEAR(offsets[1].kw, 1.2, 0.05);
  EXPECT_NEAR(offsets[1].kwh_per_day, 12, 1);
  EXPECT_EQ(text_of(offsets).find("power 2 is 1.2 ± 0.4 kW above the model between 8 and 18 h"), 0U)
      << text_of(offsets);
  EXPECT_EQ(json_of(offsets, at)[1]["meter"], "power_2_kw");
}

TEST_F(MeterOffsetTest, FindsWhatIsMissingOverMidnightAndWhatTakesLess) {
  add(-0.8, 44, 48 + 10);
  const auto offsets = meter_offsets(residual, recording, at);
  EXPECT_TRUE(offsets[1].above_noise);
  EXPECT_NEAR(offsets[1].kw, -0.8, 0.06);
  EXPECT_EQ(offsets[1].from_h, 22);
  EXPECT_EQ(offsets[1].to_h, 5);
  EXPECT_NE(offsets[1].text.find("below the model"), std::string::npos);
}

TEST_F(MeterOffsetTest, MakesNothingOutOfNoise) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> noise(0, 0.5);
    residual = Eigen::MatrixXd::NullaryExpr(metered_days * bins_per_day, at.count(), [&] { return noise(random); });
    EXPECT_EQ(text_of(meter_offsets(residual, recording, at)), "") << seed;
  }
}

TEST(DayStretch, IsTheWholeDayWhereHardlyAnHourIsLeftOut) {
  Eigen::VectorXd day = Eigen::VectorXd::Ones(bins_per_day);
  day(3) = 0;
  EXPECT_TRUE(active_stretch(day).is_whole_day());
  EXPECT_EQ(active_stretch(day).text(), "day and night");
  day.setZero();
  day.segment(17, 3).setConstant(-2);
  const DayStretch stretch = active_stretch(day);
  EXPECT_EQ(stretch.text(), "between 8:30 and 10 h");
  EXPECT_EQ(stretch.peak, -2);
}

}  // namespace
}  // namespace airside::tools::gap
