// Signs, limits and convergence of the baselines on a crude first-order room.

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <vector>

#include "airside/presets.hpp"
#include "airside/supervision/schedule.hpp"
#include "baselines/first_order_plant.hpp"
#include "hal/text/input_error.hpp"
#include "support/default_cycle.hpp"
#include "tools/baselines/arx.hpp"
#include "tools/baselines/pid.hpp"
#include "tools/baselines/schedule.hpp"
#include "tools/run/metrics.hpp"

namespace airside::tools {
namespace {

const ControllerSettings site_settings = paper_settings();

std::vector<HistoryRow> expert_days(FirstOrderPlant& plant, int days) {
  std::vector<HistoryRow> rows;
  ScheduleBaseline expert(site_settings);
  for (int i = 0; i < days * rows_per_day; ++i) {
    if (starts_cycle(plant.time())) plant.set_setpoint(expert.decide(plant.observe()));
    rows.push_back({plant.time(), plant.sensors(), plant.setpoint_degc()});
    plant.step_row();
  }
  return rows;
}

Metrics run(BaselineController& controller, int days, double swing_k = 0.8) {
  FirstOrderPlant plant(swing_k);
  const auto history = expert_days(plant, 5);
  controller.observe_history(history);
  std::vector<CycleSample> samples;
  for (int i = 0; i < days * rows_per_day; ++i) {
    const bool cycle = starts_cycle(plant.time());
    if (plant.time().second_of_day() % controller.decision_period_s(cycle_s) == 0) {
      plant.set_setpoint(controller.decide(plant.observe()));
    }
    if (cycle)
      samples.push_back({plant.time(), plant.mean_degc(), plant.sensors().room_temp_degc, plant.setpoint_degc()});
    plant.step_row();
  }
  return compute_metrics(samples, {});
}

double first_decision(const std::string& name, double mean_degc) {
  const auto controller = make_baseline(name, site_settings);
  FirstOrderPlant plant(0.0);
  plant.set_mean_degc(mean_degc);
  plant.set_setpoint(22.5);
  return controller->decide(plant.observe());
}

class FeedbackBaseline : public ::testing::TestWithParam<const char*> {};

TEST_P(FeedbackBaseline, LowersTheSetpointWhenHotAndRaisesItWhenCold) {
  EXPECT_LT(first_decision(GetParam(), 26.25), 22.5);
  EXPECT_GT(first_decision(GetParam(), 24.25), 22.5);
  EXPECT_NEAR(first_decision(GetParam(), 25.25), 22.5, 0.011);
}

TEST_P(FeedbackBaseline, SettlesAtTheTargetOnAQuietRoom) {
  const auto controller = make_baseline(GetParam(), site_settings);
  const Metrics m = run(*controller, 7, 0.0);
  EXPECT_LT(m.days.back().dae_degc, 0.05) << controller->name();
}

INSTANTIATE_TEST_SUITE_P(All, FeedbackBaseline,
                         ::testing::Values("pid-spec", "pid-tuned", "integral-tuned", "integral-5", "integral-7",
                                           "arx-2", "arx-rls"));

TEST(Baselines, EveryOneKeepsToTheActionRangeAndResolutionUnlessWrittenOtherwise) {
  for (const std::string& name : baseline_names()) {
    if (name.starts_with("g36-written")) continue;
    const auto controller = make_baseline(name, site_settings);
    FirstOrderPlant plant(0.0);
    for (int i = 0; i < 60; ++i) {
      plant.set_mean_degc(i % 3 == 0 ? 45.0 : i % 3 == 1 ? 5.0 : 25.123);
      const double a = controller->decide(plant.observe());
      EXPECT_GE(a, 20.0) << name;
      EXPECT_LE(a, 26.0) << name;
      EXPECT_NEAR(a * 100, std::round(a * 100), 1e-6) << name;
      plant.set_setpoint(a);
      for (int r = 0; r < 3; ++r) plant.step_row();
    }
  }
}

TEST(Baselines, HoldTheLastSetpointWhenNoRoomCanBeRead) {
  for (const char* name : {"pid-tuned", "integral-5", "arx-2", "arx-rls", "mpc"}) {
    const auto controller = make_baseline(name, site_settings);
    FirstOrderPlant plant(0.0);
    CycleObservation now = plant.observe();
    now.previous_setpoint_degc = 23.4;
    now.sensors.room_temp_degc.assign(5, std::numeric_limits<double>::quiet_NaN());
    EXPECT_NEAR(controller->decide(now), 23.4, 1e-9) << name;
    now.sensors.room_temp_degc[2] = 24.0;  // one room is enough to go on
    now.time.seconds += cycle_s;
    EXPECT_GT(controller->decide(now), 23.4) << name;
  }
}

TEST(Baselines, TheVariedOneMovesAboutTheIntegralAndAboutTheSchedule) {
  const auto controller = make_baseline("varied", site_settings);
  FirstOrderPlant plant(0.0);
  std::vector<double> mean_of_day, offsets;
  for (int i = 0; i < 9 * rows_per_day; ++i) {
    const CivilTime t = plant.time();
    if (starts_cycle(t)) {
      const double a = controller->decide(plant.observe());
      if (t.day() % 4 == 0) offsets.push_back(a - expert_setpoint_degc(site_settings, t));
      plant.set_setpoint(a);
    }
    plant.step_row();
    // The integral has come back from the schedule by noon of the day after it.
    if (t.second_of_day() == 0) mean_of_day.push_back(0);
    if (t.second_of_day() >= 43200 && t.day() % 4 != 0) mean_of_day.back() += plant.mean_degc() / (rows_per_day / 2);
  }
  const auto [least, most] = std::ranges::minmax(offsets);
  EXPECT_GE(least, -0.41);
  EXPECT_LE(most, 0.41);
  EXPECT_GT(most - least, 0.6);
  for (const double mean : mean_of_day) {
    if (mean > 0) {
      EXPECT_NEAR(mean, 25.25, 0.1);
    }
  }
}

TEST(Baselines, AnUnknownNameIsToldWhichNamesThereAre) {
  try {
    make_baseline("pid", site_settings);
    FAIL() << "accepted an unknown name";
  } catch (const hal::InputError& error) {
    EXPECT_NE(error.expected().find("pid-tuned"), std::string::npos);
  }
}

TEST(ScheduleBaseline, CoolsFromSevenToNineteen) {
  ScheduleBaseline expert(site_settings);
  CycleObservation now;
  now.time.seconds = 7 * 3600 - 1;
  EXPECT_EQ(expert.decide(now), 25.0);
  now.time.seconds = 7 * 3600;
  EXPECT_EQ(expert.decide(now), 20.5);
  now.time.seconds = 19 * 3600;
  EXPECT_EQ(expert.decide(now), 25.0);
}

TEST(PidBaseline, GivesTheTextbookOutput) {
  PidBaseline pid(site_settings, {1.0, 0.5, 0.1});
  FirstOrderPlant plant(0.0);
  plant.set_mean_degc(25.75);  // e = -0.5, dt = 0.3 h: 22.5 - 0.5 - 0.075
  EXPECT_NEAR(pid.decide(plant.observe()), 22.43 - 0.5, 0.011);
  CycleObservation next = plant.observe();
  next.time.seconds += cycle_s;
  next.sensors.room_temp_degc.assign(5, 25.45);  // e = -0.2: 22.5 - 0.2 - 0.5 * 0.21 + 0.1 * 0.3 / 0.3
  EXPECT_NEAR(pid.decide(next), 22.5 - 0.2 - 0.105 + 0.1, 0.011);
}

TEST(PidBaseline, DoesNotWindUpInALongSaturation) {
  PidBaseline pid(site_settings, {0.3, 5.0, 0.0});
  FirstOrderPlant plant(0.0);
  CycleObservation now = plant.observe();
  for (int i = 0; i < 200; ++i) {  // 60 h too hot for any setpoint
    now.time.seconds += cycle_s;
    now.sensors.room_temp_degc.assign(5, 30.0);
    EXPECT_NEAR(pid.decide(now), 20.0, 1e-9);
  }
  now.time.seconds += cycle_s;
  now.sensors.room_temp_degc.assign(5, 24.0);
  EXPECT_GT(pid.decide(now), 21.0);  // off the limit at the first cold reading
}

TEST(ArxBaseline, FindsTheGainOfTheRoomFromTheScheduleDays) {
  ArxSettings settings;
  settings.exogenous = false;  // in this room the FCUs follow the rooms, so their parameter could share p
  ArxBaseline arx(site_settings, settings);
  FirstOrderPlant plant(0.8);
  arx.observe_history(expert_days(plant, 5));
  EXPECT_NEAR(arx.gain(), 0.65, 0.08);
  EXPECT_NEAR(arx.parameters()[0], 0.35, 0.1);
}

TEST(ArxBaseline, KeepsItsPriorGainWhenTheScheduleNeverMoves) {
  ArxBaseline arx(site_settings, {});
  FirstOrderPlant plant(0.8);
  std::vector<HistoryRow> rows;
  for (int i = 0; i < 5 * rows_per_day; ++i) {
    rows.push_back({plant.time(), plant.sensors(), 20.5});
    plant.set_setpoint(20.5);
    plant.step_row();
  }
  arx.observe_history(rows);
  EXPECT_NEAR(arx.gain(), 0.6, 1e-9);
}

TEST(ArxBaseline, BeatsThePidWithSpecGainsOnASwingingRoom) {
  ArxBaseline arx(site_settings, {});
  PidBaseline pid(site_settings, pid_spec_gains());
  EXPECT_LT(run(arx, 5).dae_degc, 0.5 * run(pid, 5).dae_degc);
}

TEST(RecursiveLeastSquares, EqualsTheRidgeSolution) {
  Eigen::VectorXd mean(2), sd(2);
  mean << 0.1, 0.6;
  sd << 0.5, 0.3;
  RecursiveLeastSquares rls(mean, sd);
  Eigen::MatrixXd h(6, 2);
  h << 1, 0.2, -0.4, 1, 0.3, 0.3, 2, -1, 0.1, 0, -1, 0.7;
  Eigen::VectorXd y(6);
  y << 0.3, 0.5, 0.2, 0.1, -0.1, 0.4;
  const double r = 0.04;
  for (int i = 0; i < 6; ++i) rls.update(h.row(i).transpose(), y[i], r, 1.0, 100);
  const Eigen::Matrix2d precision = Eigen::Matrix2d(sd.cwiseAbs2().cwiseInverse().asDiagonal()) + h.transpose() * h / r;
  const Eigen::Vector2d rhs = mean.cwiseQuotient(sd.cwiseAbs2()) + h.transpose() * y / r;
  const double det = precision(0, 0) * precision(1, 1) - precision(0, 1) * precision(1, 0);
  EXPECT_NEAR(rls.parameters()[0], (precision(1, 1) * rhs[0] - precision(0, 1) * rhs[1]) / det, 1e-9);
  EXPECT_NEAR(rls.parameters()[1], (precision(0, 0) * rhs[1] - precision(1, 0) * rhs[0]) / det, 1e-9);
}

TEST(RecursiveLeastSquares, StaysBoundedThroughMonthsWithoutExcitation) {
  RecursiveLeastSquares rls(Eigen::VectorXd::Zero(2), Eigen::VectorXd::Ones(2));
  Eigen::VectorXd h(2);
  h << 1, 0;
  for (int i = 0; i < 100000; ++i) rls.update(h, 0.5, 0.01, 0.99, 1);
  h << 0, 1;
  rls.update(h, 1.0, 0.01, 0.99, 1);
  EXPECT_TRUE(rls.parameters().allFinite());
  EXPECT_LT(rls.parameters().norm(), 2.0);
}

}  // namespace
}  // namespace airside::tools
