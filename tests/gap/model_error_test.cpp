// Errors by hour, day and weather, and the usual figures, counted by hand.

#include "tools/gap/model/model_error.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "sim/weather/synthetic_weather.hpp"

namespace airside::tools::gap {
namespace {

constexpr double missing = std::numeric_limits<double>::quiet_NaN();

TEST(ModelError, IsMeanAndRootMeanSquareOfWhatWasMeasured) {
  Eigen::MatrixXd residual(4, 2);
  residual << 9, 9, 1, missing, -3, missing, missing, missing;
  const ChannelErrors e = errors_of(residual, 1, 4);
  EXPECT_NEAR(e.mean(0), -1, 1e-12);
  EXPECT_NEAR(e.rmse(0), std::sqrt(5), 1e-12);
  EXPECT_TRUE(std::isnan(e.rmse(1)));
  EXPECT_NEAR(joint_rmse(e, 0, 2), std::sqrt(5), 1e-12);  // a channel that nobody measured does not count
  EXPECT_EQ(joint_rmse(e, 1, 2), 0);
}

TEST(ModelError, FallsIntoItsHourAndItsDay) {
  Eigen::MatrixXd residual = Eigen::MatrixXd::Zero(3 * bins_per_day, 1);
  residual(bins_per_day + 15) = 2;  // day 2, 7:30
  residual(2 * bins_per_day + 14) = -1;
  const ErrorMap hours = errors_by_hour(residual, bins_per_day);
  ASSERT_EQ(hours.groups.size(), 24U);
  EXPECT_NEAR(hours.mean(0, 7), 0.25, 1e-12);
  EXPECT_NEAR(hours.rmse(0, 7), std::sqrt(5.0 / 4), 1e-12);
  EXPECT_EQ(hours.rmse(0, 8), 0);
  const ErrorMap days = errors_by_day(residual, {sim::civil_midnight(2021, 7, 14), {}, nullptr});
  EXPECT_EQ(days.groups, (std::vector<std::string>{"07-14", "07-15", "07-16"}));
  EXPECT_NEAR(days.mean(0, 1), 2.0 / bins_per_day, 1e-12);
}

TEST(ModelError, FallsIntoItsWeather) {
  sim::Recording recording;
  recording.from = sim::civil_midnight(2021, 7, 1);
  recording.station = sim::synthetic_weather(1);
  Eigen::MatrixXd residual = Eigen::MatrixXd::Zero(2 * bins_per_day, 1);
  for (int i = 0; i < 2 * rows_per_day; ++i) {
    sim::RecordedRow row;
    row.outdoor_temp_degc = i < rows_per_day ? 20 : 30;
    row.rain = i / rows_per_bin == 3 ? 1 : 0;
    recording.rows.push_back(row);
    const bool night = recording.station->at(recording.time(static_cast<std::size_t>(i))).global_horizontal_w_m2 < 10;
    if (i % rows_per_bin == rows_per_bin / 2) residual(i / rows_per_bin) = night ? 1 : -1;
  }
  residual(3) = 5;
  const ErrorMap map = errors_by_weather(residual, recording, 0);
  const auto of = [&map](const std::string& name) {
    const auto at = std::find(map.groups.begin(), map.groups.end(), name) - map.groups.begin();
    return at < std::ssize(map.groups) ? map.mean(0, at) : missing;
  };
  EXPECT_GT(of("night"), 1);
  EXPECT_EQ(of("rain"), 5);
  EXPECT_EQ(of("sunny"), -1);
  EXPECT_FALSE(std::isnan(of("warm")));
}

TEST(ModelError, GivesGuideline14AsTheStandardDoes) {
  const sim::Channels channels{1, 0, 2};  // room, MAU, supply, powers
  Eigen::MatrixXd measured(4, 5), residual = Eigen::MatrixXd::Zero(4, 5);
  measured << 20, 0, 0, 1, 3, 20, 0, 0, 1, 3, 30, 0, 0, 2, 2, 30, 0, 0, 2, 2;
  residual.col(0) << 1, 3, -1, -1;  // hourly: 2, -1
  residual.col(3) << 0, 0, 1, 1;
  const Guideline14 temp = guideline_14_room_temp(measured, residual, channels, 0, 4);
  EXPECT_EQ(temp.count, 2);
  EXPECT_NEAR(temp.cv_rmse_percent, 100 * std::sqrt(5) / 25, 1e-9);
  EXPECT_NEAR(temp.nmbe_percent, 100 * 1.0 / 25, 1e-9);
  EXPECT_TRUE(temp.passes());
  const Guideline14 power = guideline_14_power(measured, residual, channels, 0, 4);
  EXPECT_NEAR(power.cv_rmse_percent, 25, 1e-9);
  EXPECT_NEAR(power.nmbe_percent, 25, 1e-9);
  EXPECT_FALSE(power.passes());
}

TEST(ModelError, GivesEachMeterHourByHourAndMonthByMonth) {
  constexpr int days = 31 + 28 + 10;  // January, February, and too little of March
  sim::Recording recording;
  recording.from = sim::civil_midnight(2021, 1, 1);
  recording.rows.resize(days * rows_per_day);
  Eigen::MatrixXd measured = Eigen::MatrixXd::Constant(days * bins_per_day, 5, 10);
  Eigen::MatrixXd residual = Eigen::MatrixXd::Zero(days * bins_per_day, 5);
  residual.col(4).topRows(31 * bins_per_day).setConstant(1);  // the second meter, in January
  const MeterFigures right = guideline_14_meter(measured, residual, recording, 3, 0, residual.rows());
  EXPECT_EQ(right.hourly.count, days * 24);
  EXPECT_EQ(right.monthly.count, 2);
  EXPECT_EQ(right.monthly.cv_rmse_percent, 0);
  EXPECT_TRUE(right.monthly.passes_monthly());
  const MeterFigures wrong = guideline_14_meter(measured, residual, recording, 4, 0, residual.rows());
  const double january = 31 * 24 * 10, february = 28 * 24 * 10, mean = (january + february) / 2;
  EXPECT_NEAR(wrong.monthly.cv_rmse_percent, 100 * (january / 10) / mean, 1e-9);
  EXPECT_NEAR(wrong.monthly.nmbe_percent, 100 * (january / 10) / mean, 1e-9);
  EXPECT_FALSE(wrong.monthly.passes_monthly()) << "10 % off in one month";
  EXPECT_TRUE(wrong.hourly.passes());
  EXPECT_EQ(guideline_14_meter(measured, residual, recording, 4, 0, 40 * bins_per_day).monthly.count, 1)
      << "nine days are no month";
}

}  // namespace
}  // namespace airside::tools::gap
