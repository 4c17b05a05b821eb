#include <gtest/gtest.h>

#include <cmath>

#include "hal/text/input_error.hpp"
#include "rc_plant/rc_fixture.hpp"
#include "sim/rc/rc_floor.hpp"

namespace airside::sim::test {
namespace {

void expect_same_to_the_bit(const RcPlant& a, const RcPlant& b) {
  EXPECT_EQ(a.time(), b.time());
  EXPECT_EQ(a.zone_temp_degc(), b.zone_temp_degc());
  EXPECT_EQ(a.sensors().room_temp_degc, b.sensors().room_temp_degc);
  EXPECT_EQ(a.sensors().fcu_temp_degc, b.sensors().fcu_temp_degc);
  EXPECT_EQ(a.sensors().fcu_on, b.sensors().fcu_on);
  EXPECT_EQ(a.sensors().power_kw, b.sensors().power_kw);
  EXPECT_EQ(a.sensors().mau_temp_degc, b.sensors().mau_temp_degc);
  EXPECT_EQ(a.sensors().supply_temp_degc, b.sensors().supply_temp_degc);
}

RcPlant default_plant(std::uint64_t seed = 1) { return RcPlant(make_room(), hot_weather(), july, seed); }

// A room without whims, so that one change can be seen alone.
RcRoom calm_room() {
  RcRoom room = make_room();
  room.occupancy_day_sd = room.occupancy_zone_sd = room.occupancy_noise_sd = room.arrival_sd_min = 0;
  room.vav_off_per_day = room.mau_noise_sd_k = room.temp_noise_sd_k = room.power_noise_share = 0;
  return room;
}

// Mean over all zones and three working days.
double working_mean_degc(const RcRoom& room) {
  RcPlant plant(room, hot_weather(), july, 1);
  double sum = 0;
  int count = 0;
  run_days(
      plant, 4, [](const RcPlant&) { return 22.5; },
      [&](const RcPlant& p) {
        if (!working(p.time()) || p.time().day() == july.day()) return;
        sum += mean_of(p.zone_temp_degc());
        ++count;
      });
  return sum / count;
}

TEST(RcPlant, RepeatsARunToTheBit) {
  RcPlant first = default_plant(), second = default_plant();
  run_days(first, 3, expert_rule);
  run_days(second, 3, expert_rule);
  expect_same_to_the_bit(first, second);
}

TEST(RcPlant, DiffersWithTheSeed) {
  RcPlant first = default_plant(1), second = default_plant(2);
  run_days(first, 1, expert_rule);
  run_days(second, 1, expert_rule);
  EXPECT_NE(first.sensors().room_temp_degc, second.sensors().room_temp_degc);
}

TEST(RcPlant, DoesNotCareHowAnAdvanceIsSplit) {
  RcPlant whole = default_plant(), split = default_plant();
  whole.advance_to(later(july, 2 * 86400));
  for (int step = 1; step <= 960; ++step) {
    split.advance_to(later(july, step * 180));
    split.advance_to(split.time());
  }
  expect_same_to_the_bit(whole, split);
}

TEST(RcPlant, SensorsStayTheSameWhenReadTwiceAndCarryTwoDecimals) {
  RcPlant plant = default_plant();
  plant.advance_to(later(july, 3600));
  const Sensors once = plant.sensors();
  EXPECT_EQ(once.room_temp_degc, plant.sensors().room_temp_degc);
  for (double temp : once.room_temp_degc) EXPECT_NEAR(temp * 100, std::round(temp * 100), 1e-9);
  EXPECT_NE(once.room_temp_degc[0], plant.zone_temp_degc()[0]) << "noise and rounding must show";
}

TEST(RcPlant, CopyGoesItsOwnWayAndLeavesTheOriginalAlone) {
  RcPlant plant = default_plant(), untouched = default_plant();
  plant.advance_to(later(july, 9 * 3600));
  untouched.advance_to(later(july, 9 * 3600));
  RcPlant branch = plant;
  branch.set_setpoint(18);
  branch.advance_to(later(july, 10 * 3600));
  expect_same_to_the_bit(plant, untouched);
  plant.advance_to(later(july, 10 * 3600));
  untouched.advance_to(later(july, 10 * 3600));
  expect_same_to_the_bit(plant, untouched);
  EXPECT_LT(branch.mean_room_temp_degc(), plant.mean_room_temp_degc() - 1);
  RcPlant twin_branch = plant;
  twin_branch.advance_to(later(july, 20 * 3600));
  plant.advance_to(later(july, 20 * 3600));
  expect_same_to_the_bit(plant, twin_branch);
}

TEST(RcPlant, FrozenBranchHoldsEveryDisturbance) {
  RcPlant plant = default_plant();
  plant.advance_to(later(july, 8 * 3600));
  RcPlant frozen = plant, actual = plant;
  frozen.freeze_disturbances();
  const Disturbance before = frozen.disturbance();
  const auto fcu_before = frozen.sensors().fcu_on;
  frozen.advance_to(later(july, 14 * 3600));
  actual.advance_to(later(july, 14 * 3600));
  EXPECT_EQ(frozen.disturbance().gain_w, before.gain_w);
  EXPECT_EQ(frozen.disturbance().vav_on, before.vav_on);
  EXPECT_EQ(frozen.disturbance().facade_w_m2, before.facade_w_m2);
  EXPECT_EQ(frozen.disturbance().weather.outdoor_temp_degc, before.weather.outdoor_temp_degc);
  EXPECT_EQ(frozen.sensors().fcu_on, fcu_before);
  EXPECT_NE(actual.disturbance().gain_w, before.gain_w);
}

TEST(RcPlant, ExpectedFutureFollowsTheMeanProfileOfPeople) {
  RcPlant plant(calm_room(), hot_weather(), july, 1);
  plant.advance_to(later(july, 8 * 3600));
  RcPlant expected = plant, actual = plant;
  expected.expect_disturbances();
  expected.advance_to(later(july, 10 * 3600));
  actual.advance_to(later(july, 10 * 3600));
  for (std::size_t z = 0; z < 10; ++z) {
    EXPECT_NEAR(expected.disturbance().gain_w[z], actual.disturbance().gain_w[z], 1e-9);
  }
}

TEST(RcPlant, StoresExactlyTheHeatThatEntered) {
  RcPlant plant = default_plant();
  run_days(plant, 7, expert_rule);
  const RcEnergy& energy = plant.energy();
  EXPECT_NEAR(energy.stored_kj, energy.entered_kj(), 1e-6 * energy.gains_kj);
  EXPECT_GT(energy.gains_kj, 1e5);
  EXPECT_GT(energy.solar_kj, 1e4);
  EXPECT_LT(energy.vav_kj, -1e5);
  EXPECT_LT(energy.fcu_kj, -1e4);
  EXPECT_LT(std::fabs(energy.stored_kj), 0.2 * energy.gains_kj) << "a week's heat must leave again";
}

TEST(RcPlant, WithoutAnyDriveTheRoomKeepsItsTemperature) {
  RcRoom room = calm_room();
  room.gain_base_w_m2 = room.gain_occupied_w_m2 = 0;
  room.neighbour_temp_degc = 25;
  room.envelope_factor = room.infiltration_ach = room.infiltration_wind_ach_s_m = room.infiltration_stack_ach_k = 0;
  room.shgc = room.outdoor_air_m3_s = 0;
  std::fill(room.vav_damper.begin(), room.vav_damper.end(), 0.0);
  std::fill(room.fcu_flow_m3_s.begin(), room.fcu_flow_m3_s.end(), 0.0);
  RcPlant plant(room, hot_weather(), july, 1);
  plant.advance_to(later(july, 5 * 86400));
  for (double temp : plant.zone_temp_degc()) EXPECT_NEAR(temp, 25, 1e-9);
}

TEST(RcPlant, FanCoilsSwitchOnlyAtTheEdgesOfTheirBandAndOnlyInTheirHours) {
  RcRoom room = calm_room();
  RcPlant plant(room, hot_weather(), july, 1);
  std::vector<double> before = plant.sensors().fcu_on;
  int switched_on = 0, switched_off = 0;
  for (int step = 0; step < 5 * 480; ++step) {
    plant.advance_to(later(plant.time(), 180));
    const double hour = plant.time().second_of_day() / 3600.0;
    for (std::size_t f = 0; f < 5; ++f) {
      const double now = plant.sensors().fcu_on[f], temp = plant.zone_temp_degc()[5 + f];
      if (hour < 7 || hour >= 20) {
        EXPECT_EQ(now, 0) << text_of(plant.time());
      } else {
        // The thermostat looks every minute, so a switch may be up to 3 min old.
        if (now > before[f]) {
          EXPECT_GT(temp, 26.5 - 0.35);
          ++switched_on;
        }
        if (now < before[f]) {
          EXPECT_LT(temp, 25.5 + 0.35);
          ++switched_off;
        }
        if (temp > 26.51) {
          EXPECT_EQ(now, 1) << temp;
        }
        if (temp < 25.49) {
          EXPECT_EQ(now, 0) << temp;
        }
      }
    }
    before = plant.sensors().fcu_on;
  }
  EXPECT_GT(switched_on, 20);
  EXPECT_GT(switched_off, 20);
}

TEST(RcPlant, ForcedFanCoilRunsThoughItIsRecordedOff) {
  RcRoom room = calm_room();
  room.fcu_forced[2] = 1;
  room.fcu_forced[3] = -1;
  RcPlant plant(room, hot_weather(), july, 1);
  plant.advance_to(later(july, 86400 + 3 * 3600));
  EXPECT_EQ(plant.sensors().fcu_on[2], 0);
  EXPECT_DOUBLE_EQ(plant.fcu_duty()[2], 1);
  plant.advance_to(later(july, 86400 + 15 * 3600));
  EXPECT_EQ(plant.fcu_duty()[3], 0);
  EXPECT_GT(plant.zone_temp_degc()[8], 26.5);
}

TEST(RcPlant, SupplyTemperatureLagsAndReachesItsSetpoint) {
  RcRoom room = calm_room();
  room.coil_capacity_kw = 40;
  RcPlant plant(room, hot_weather(), july, 1, 23.0);
  plant.advance_to(later(july, 10 * 3600));
  EXPECT_NEAR(plant.supply_temp_degc(), 23.0, 0.01);
  plant.set_setpoint(21.0);
  EXPECT_EQ(plant.sensors().setpoint_degc, 21.0);
  plant.advance_to(later(plant.time(), 180));
  EXPECT_NEAR(plant.supply_temp_degc(), 21 + 2 * std::exp(-180.0 / 200), 0.01);
  plant.advance_to(later(plant.time(), 1800));
  EXPECT_NEAR(plant.supply_temp_degc(), 21.0, 0.01);
}

TEST(RcPlant, CoilShortOfCapacityCannotReachAColdSetpoint) {
  RcRoom room = calm_room();
  room.coil_capacity_kw = 6;
  RcPlant plant(room, hot_weather(), july, 1, 16.0);
  plant.advance_to(later(july, 14 * 3600));
  EXPECT_GT(plant.supply_temp_degc(), 17.0);
  EXPECT_LT(plant.coil_load_kw(), 6.2);
}

TEST(RcPlant, AirHandlerCannotHeat) {
  RcPlant plant(calm_room(), hot_weather(), july, 1, 35.0);
  plant.advance_to(later(july, 4 * 3600));
  EXPECT_LT(plant.supply_temp_degc(), plant.mean_room_temp_degc() + 1.0);
}

TEST(RcPlant, ClosedVavWarmsItsRoomAndShowsOff) {
  RcRoom often = make_room();
  often.vav_off_per_day = 4;
  RcPlant plant(often, hot_weather(), july, 1);
  int off_rows = 0;
  double warmer = 0;
  for (int row = 0; row < 5 * rows_per_day; ++row) {
    plant.advance_to(later(plant.time(), row_s));
    if (!working(plant.time())) continue;
    for (std::size_t v = 0; v < 5; ++v) {
      if (plant.sensors().vav_on[v] > 0.5) continue;
      ++off_rows;
      warmer += plant.zone_temp_degc()[v] - plant.mean_room_temp_degc();
    }
  }
  ASSERT_GT(off_rows, 50);
  EXPECT_GT(warmer / off_rows, 0.5);
}

// Each effect that the gap workflow may have to name moves the room the way physics says.
struct Effect {
  const char* name;
  void (*apply)(RcRoom&);
  double least_k, most_k;
};

TEST(RcPlant, EveryEffectMovesTheRoomTheRightWay) {
  const Effect effects[] = {
      {"infiltration", [](RcRoom& r) { r.infiltration_ach += 2; }, 0.02, 2},
      {"more sun", [](RcRoom& r) { r.solar_factor_south = r.solar_factor_west = 2; }, 0.005, 2},
      {"gains", [](RcRoom& r) { r.gain_occupied_w_m2 *= 1.5; }, 0.2, 3},
      {"less air",
       [](RcRoom& r) {
         for (double& x : r.vav_flow_calibration) x = 0.8;
       },
       0.1, 2},
      {"supply sensor reads high", [](RcRoom& r) { r.supply_sensor_offset_k = 1; }, -1.2, -0.3},
      {"duct gain", [](RcRoom& r) { r.duct_gain_k += 1; }, 0.3, 1.2},
      {"duct leak", [](RcRoom& r) { r.duct_leak_share = 0.2; }, 0.1, 2},
      {"VAV stuck nearly closed", [](RcRoom& r) { r.vav_stuck_damper[2] = 0.1; }, 0.1, 2},
      {"fan coil degraded",
       [](RcRoom& r) {
         for (double& x : r.fcu_capacity_factor) x = 0.2;
       },
       0.02, 2},
      {"warm neighbour", [](RcRoom& r) { r.neighbour_temp_degc += 5; }, 0.02, 1},
      {"make-up air warmer", [](RcRoom& r) { r.mau_setpoint_degc = 26; }, 0.01, 1},
  };
  const double normal = working_mean_degc(calm_room());
  for (const Effect& effect : effects) {
    RcRoom room = calm_room();
    effect.apply(room);
    const double moved = working_mean_degc(room) - normal;
    EXPECT_GE(moved, effect.least_k) << effect.name;
    EXPECT_LE(moved, effect.most_k) << effect.name;
  }
}

TEST(RcPlant, SwappedSensorsShowEachOthersRoom) {
  RcRoom room = calm_room(), swapped = calm_room();
  room.gain_factor[0] = swapped.gain_factor[0] = 2;
  std::swap(swapped.room_sensor_zone[0], swapped.room_sensor_zone[4]);
  RcPlant right(room, hot_weather(), july, 1), wrong(swapped, hot_weather(), july, 1);
  right.advance_to(later(july, 15 * 3600));
  wrong.advance_to(later(july, 15 * 3600));
  EXPECT_EQ(right.sensors().room_temp_degc[0], wrong.sensors().room_temp_degc[4]);
  EXPECT_EQ(right.sensors().room_temp_degc[4], wrong.sensors().room_temp_degc[0]);
  EXPECT_GT(right.sensors().room_temp_degc[0], right.sensors().room_temp_degc[4] + 0.5);
}

TEST(RcPlant, ShiftedClockMovesThePeople) {
  RcRoom shifted = calm_room();
  shifted.clock_shift_s = 3600;
  RcPlant right(calm_room(), hot_weather(), july, 1), late(shifted, hot_weather(), july, 1);
  right.advance_to(later(july, 7 * 3600 + 1800 + 720));
  late.advance_to(later(july, 8 * 3600 + 1800 + 720));
  EXPECT_EQ(right.disturbance().gain_w, late.disturbance().gain_w);
}

TEST(RcPlant, WeekendIsQuietIfTheRoomHasWeekends) {
  RcRoom room = calm_room();
  room.occupancy_weekend_factor = 0.1;
  RcPlant plant(room, hot_weather(), july, 1);       // a Thursday
  plant.advance_to(later(july, 86400 + 10 * 3600));  // Friday
  const double friday_w = plant.disturbance().gain_w[0];
  plant.advance_to(later(july, 2 * 86400 + 10 * 3600));  // Saturday
  EXPECT_LT(plant.disturbance().gain_w[0], 0.6 * friday_w);
}

TEST(RcPlant, RunsRoomsOfOtherCounts) {
  const int counts[][3] = {{3, 0, 1}, {8, 4, 2}, {1, 1, 1}, {2, 7, 2}};
  for (const auto& c : counts) {
    RcPlant plant(make_room(c[0], c[1], c[2]), hot_weather(), july, 1);
    run_days(plant, 3, [](const RcPlant&) { return 22.5; });
    plant.advance_to(later(plant.time(), 12 * 3600));
    const Sensors& s = plant.sensors();
    EXPECT_EQ(s.room_temp_degc.size(), static_cast<std::size_t>(c[0]));
    EXPECT_EQ(s.vav_on.size(), static_cast<std::size_t>(c[0]));
    EXPECT_EQ(s.fcu_temp_degc.size(), static_cast<std::size_t>(c[1]));
    EXPECT_EQ(s.fcu_on.size(), static_cast<std::size_t>(c[1]));
    EXPECT_EQ(s.power_kw.size(), static_cast<std::size_t>(c[2]));
    EXPECT_GT(s.power_kw[0], 0);
    EXPECT_NEAR(plant.mean_room_temp_degc(), 25.25, 1.5) << c[0] << "-" << c[1];
  }
}

TEST(RcPlant, RefusesToGoBackOrByOddSteps) {
  RcPlant plant = default_plant();
  EXPECT_THROW(plant.advance_to(later(july, -180)), std::invalid_argument);
  EXPECT_THROW(plant.advance_to(later(july, 100)), std::invalid_argument);
  EXPECT_THROW(plant.set_setpoint(std::nan("")), std::invalid_argument);
}

TEST(RcPlant, RefusesAnImpossibleRoom) {
  RcRoom room = make_room();
  room.shgc = 1.5;
  EXPECT_THROW(RcPlant(room, hot_weather(), july, 1), hal::InputError);
  RcRoom stiff = make_room();
  stiff.wall_kj_k[7] = 1;
  stiff.wall_ua_w_k[7] = 10000;
  EXPECT_THROW(RcPlant(stiff, hot_weather(), july, 1), hal::InputError);
}

TEST(RcFloor, HitsTheTargetOnTheTrueFuture) {
  RcPlant plant = default_plant();
  plant.advance_to(later(july, 9 * 3600));
  const double setpoint = full_forecast_setpoint(plant, 25.0, 15, 28);
  EXPECT_NEAR(mean_room_temp_after(plant, setpoint, Foresight::full), 25.0, 0.002);
  const CivilTime before = plant.time();
  EXPECT_EQ(plant.time(), before);
}

TEST(RcFloor, GivesTheLimitWhenTheTargetIsOutOfReach) {
  RcPlant plant = default_plant();
  plant.advance_to(later(july, 9 * 3600));
  EXPECT_EQ(frozen_floor_setpoint(plant, 10.0, 20, 26), 20);
  EXPECT_EQ(frozen_floor_setpoint(plant, 40.0, 20, 26), 26);
}

}  // namespace
}  // namespace airside::sim::test
