#include "sim/energyplus/rooms.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace airside::sim {
namespace {

constexpr int step_s = 180;

CivilTime at(int day, int minute) { return {start_of_day_2021(7, 1).seconds + day * 86400 + minute * 60}; }

std::vector<double> temps(double t) { return std::vector<double>(5, t); }

TEST(RoomLoops, SwitchFanCoilsWithHysteresis) {
  RoomLoops loops({}, 5, 5, 1, 25);
  const auto on = [&loops](int minute, double t) { return loops.step(at(0, minute), step_s, 22, temps(t)).fcu_on[0]; };
  EXPECT_EQ(on(600, 26.4), 0);
  EXPECT_EQ(on(603, 26.6), 1);
  EXPECT_EQ(on(606, 25.6), 1);
  EXPECT_EQ(on(609, 25.4), 0);
  EXPECT_EQ(on(612, 26.4), 0);
}

TEST(RoomLoops, KeepFanCoilsOffOutsideTheirHours) {
  RoomLoops loops({}, 5, 5, 1, 25);
  EXPECT_EQ(loops.step(at(0, 6 * 60 + 57), step_s, 22, temps(30)).fcu_on[3], 0);
  EXPECT_EQ(loops.step(at(0, 7 * 60), step_s, 22, temps(30)).fcu_on[3], 1);
  EXPECT_EQ(loops.step(at(0, 20 * 60), step_s, 22, temps(30)).fcu_on[3], 0);
}

TEST(RoomLoops, LagTheSupplyByTheirTimeConstant) {
  RoomLoopOptions options;
  options.supply_lag_s = 180;
  RoomLoops loops(options, 5, 5, 1, 20);
  EXPECT_NEAR(loops.step(at(0, 0), step_s, 21, temps(25)).supply_setpoint_degc, 21 - std::exp(-1.0), 1e-12);
  for (int i = 1; i < 20; ++i) loops.step(at(0, 3 * i), step_s, 21, temps(25));
  EXPECT_NEAR(loops.commands().supply_setpoint_degc, 21, 1e-6);
}

TEST(RoomLoops, FillTheFloorByDayAndEmptyItByNight) {
  RoomLoops loops({}, 5, 5, 1, 25);
  for (int zone = 0; zone < 10; ++zone) {
    const auto z = static_cast<std::size_t>(zone);
    EXPECT_LT(loops.step(at(0, 120), step_s, 22, temps(25)).occupancy[z], 0.2);
    EXPECT_GT(loops.step(at(0, 660), step_s, 22, temps(25)).occupancy[z], 0.6);
  }
}

TEST(RoomLoops, VaryFromDayToDayUnlessToldNotTo) {
  const auto noon = [](double noise, int day) {
    RoomLoopOptions options;
    options.occupancy_noise = noise;
    RoomLoops loops(options, 5, 5, 1, 25);
    return loops.warm_up(at(day, 660), 22, temps(25)).occupancy;
  };
  EXPECT_NE(noon(1, 0), noon(1, 1));
  EXPECT_EQ(noon(0, 0), noon(0, 1));
}

TEST(RoomLoops, EmptyTheFloorOnWeekendsWhenAsked) {
  RoomLoopOptions options;
  options.weekends = true;
  RoomLoops loops(options, 5, 5, 1, 25);
  EXPECT_GT(loops.step(at(1, 660), step_s, 22, temps(25)).occupancy[0], 0.6);  // Friday
  EXPECT_LT(loops.step(at(2, 660), step_s, 22, temps(25)).occupancy[0], 0.2);  // Saturday
}

TEST(RoomLoops, TakeVavsOutAsOftenAsAsked) {
  RoomLoopOptions options;
  options.vav_off_per_day = 0.3;
  RoomLoops loops(options, 5, 5, 7, 25);
  int outages = 0, steps_out = 0;
  const int days = 100;
  for (int day = 0; day < days; ++day) {
    std::vector<double> last(5, 1.0);
    for (int minute = 0; minute < 1440; minute += 3) {
      const auto& on = loops.step(at(day, minute), step_s, 22, temps(25)).vav_on;
      for (std::size_t i = 0; i < 5; ++i) {
        outages += last[i] > 0.5 && on[i] < 0.5;
        steps_out += on[i] < 0.5;
      }
      last = on;
    }
  }
  EXPECT_NEAR(outages, 0.3 * 5 * days, 40);
  EXPECT_NEAR(3.0 * steps_out / outages, 63, 5);
}

TEST(RoomLoops, ReportTemperaturesWithNoiseAndTwoDecimals) {
  RoomLoops loops({}, 5, 5, 1, 25);
  double sum = 0, squares = 0;
  const int n = 4000;
  for (int i = 0; i < n; ++i) {
    const double reading = loops.sensed_degc(25.0);
    EXPECT_NEAR(reading * 100, std::round(reading * 100), 1e-6);
    sum += reading - 25.0;
    squares += (reading - 25.0) * (reading - 25.0);
  }
  EXPECT_NEAR(sum / n, 0, 0.002);
  EXPECT_NEAR(std::sqrt(squares / n), 0.02, 0.002);
}

TEST(RoomLoops, RepeatThemselvesFromTheirSeed) {
  RoomLoops a({}, 5, 5, 9, 25), b({}, 5, 5, 9, 25), other({}, 5, 5, 10, 25);
  for (int minute = 0; minute < 1440; minute += 3) {
    a.step(at(0, minute), step_s, 22, temps(25));
    b.step(at(0, minute), step_s, 22, temps(25));
    other.step(at(0, minute), step_s, 22, temps(25));
  }
  EXPECT_EQ(a.commands().occupancy, b.commands().occupancy);
  EXPECT_NE(a.commands().occupancy, other.commands().occupancy);
}

}  // namespace
}  // namespace airside::sim
