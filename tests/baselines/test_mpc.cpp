// The predictive peer: its quadratic program, what it learns of a room, and that it leaves no offset.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <limits>

#include "airside/presets.hpp"
#include "baselines/first_order_plant.hpp"
#include "support/default_cycle.hpp"
#include "tools/baselines/mpc.hpp"
#include "tools/baselines/schedule.hpp"

namespace airside::tools {
namespace {

const ControllerSettings mpc_site = paper_settings();

TEST(BoxQuadratic, IsTheClosedFormInsideTheBoxAndStopsAtItsWalls) {
  Eigen::Matrix3d h;
  h << 4, 1, 0.5, 1, 3, -1, 0.5, -1, 2;
  const Eigen::Vector3d f(1, -2, 3);
  const Eigen::Vector3d free = h.llt().solve(-f);
  Eigen::VectorXd x = Eigen::VectorXd::Zero(3);
  solve_box_quadratic(h, f, -10, 10, x);
  EXPECT_LT((x - free).norm(), 1e-7);
  solve_box_quadratic(h, f, -0.5, 0.5, x);
  const Eigen::VectorXd slope = h * x + f;
  for (int i = 0; i < 3; ++i) {  // at a wall the slope pushes outward, inside it vanishes
    if (x[i] > -0.5 + 1e-9) {
      EXPECT_LT(slope[i], 1e-6);
    }
    if (x[i] < 0.5 - 1e-9) {
      EXPECT_GT(slope[i], -1e-6);
    }
  }
}

std::vector<HistoryRow> schedule_days(FirstOrderPlant& plant, int days) {
  std::vector<HistoryRow> rows;
  ScheduleBaseline expert(mpc_site);
  for (int i = 0; i < days * rows_per_day; ++i) {
    if (starts_cycle(plant.time())) plant.set_setpoint(expert.decide(plant.observe()));
    rows.push_back({plant.time(), plant.sensors(), plant.setpoint_degc()});
    plant.step_row();
  }
  return rows;
}

TEST(MpcBaseline, FindsTheRoomInTheScheduleDays) {
  FirstOrderPlant plant(0.8);
  MpcBaseline mpc(mpc_site, {});
  mpc.observe_history(schedule_days(plant, 5));
  EXPECT_NEAR(mpc.steady_gain(), 1.0, 0.1);      // this room follows its supply air
  EXPECT_NEAR(mpc.parameters()[2], 0.65, 0.08);  // the way to its supply air in one
}

TEST(MpcBaseline, FindsItInDaysWithGapsInTheReadings) {
  FirstOrderPlant plant(0.8);
  std::vector<HistoryRow> rows = schedule_days(plant, 5);
  constexpr double gone = std::numeric_limits<double>::quiet_NaN();
  for (std::size_t i = 0; i < rows.size(); i += 10) rows[i].sensors.outdoor_temp_degc = gone;
  for (std::size_t i = 5; i < rows.size(); i += 70) rows[i].sensors.room_temp_degc.assign(5, gone);
  MpcBaseline mpc(mpc_site, {});
  mpc.observe_history(rows);
  EXPECT_NEAR(mpc.steady_gain(), 1.0, 0.1);
  EXPECT_TRUE(mpc.parameters().allFinite());
}

/// People come when the schedule cools: its days say that cold air warms.
TEST(MpcBaseline, KeepsItsPriorWhereTheDaysSayThatColdAirWarms) {
  FirstOrderPlant plant(0.8);
  std::vector<HistoryRow> rows = schedule_days(plant, 5);
  for (HistoryRow& row : rows)
    row.sensors.room_temp_degc.assign(5, mpc_site.target_degc - 2 * (row.setpoint_degc - 22.5));
  MpcBaseline mpc(mpc_site, {});
  mpc.observe_history(rows);
  EXPECT_NEAR(mpc.steady_gain(), 1.0, 0.01) << "the prior's";
  EXPECT_TRUE(mpc.parameters().allFinite());
}

TEST(MpcBaseline, LeavesNoOffsetWhereALoadStandsThatItsModelDoesNotKnow) {
  FirstOrderPlant known(0.5);
  MpcBaseline mpc(mpc_site, {});
  mpc.observe_history(schedule_days(known, 5));
  FirstOrderPlant plant(0.0);  // the daily swing is gone
  double worst = 0;
  for (int i = 0; i < 3 * rows_per_day; ++i) {
    if (starts_cycle(plant.time())) plant.set_setpoint(mpc.decide(plant.observe(24.5)));
    plant.step_row();
    if (i > 2 * rows_per_day) worst = std::max(worst, std::abs(plant.mean_degc() - 24.5));
  }
  EXPECT_LT(worst, 0.1);
}

TEST(MpcBaseline, GoesLessFarAtOnceWhereMovesCostMore) {
  const auto first_move = [](double weight) {
    FirstOrderPlant plant(0.0);
    MpcSettings settings;
    settings.move_weight = weight;
    MpcBaseline mpc(mpc_site, settings);
    mpc.observe_history(schedule_days(plant, 5));
    plant.set_setpoint(22.5);
    plant.set_mean_degc(25.75);
    return 22.5 - mpc.decide(plant.observe());
  };
  EXPECT_GT(first_move(1), 0.0);
  EXPECT_LT(first_move(1), 0.7 * first_move(0.01));
}

}  // namespace
}  // namespace airside::tools
