// The facts that the method prints about its room (docs/method.md, open point 24) and what the prototypes found of the
// floors.

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>

#include "rc_plant/rc_fixture.hpp"
#include "sim/rc/rc_floor.hpp"
#include "sim/rc/rc_room_file.hpp"
#include "support/default_cycle.hpp"

namespace airside::sim::test {
namespace {

struct WorkingMean {
  double mean_degc, error_k;
};

WorkingMean working_mean(double (*rule)(const RcPlant&)) {
  RcPlant plant(make_room(), hot_weather(), july, 1);
  run_days(plant, 2, rule);
  double sum = 0, error = 0;
  int count = 0;
  run_days(plant, 14, rule, [&](const RcPlant& p) {
    if (!working(p.time())) return;
    sum += mean_of(p.sensors().room_temp_degc);
    error += std::fabs(mean_of(p.sensors().room_temp_degc) - target_degc);
    ++count;
  });
  return {sum / count, error / count};
}

TEST(RcFacts, RoomSettlesNear25AndAQuarterAt22AndAHalf) {
  const WorkingMean found = working_mean([](const RcPlant&) { return 22.5; });
  std::printf("(a) working-hours mean at 22.5: %.3f degC\n", found.mean_degc);
  EXPECT_NEAR(found.mean_degc, 25.25, 0.15);
}

TEST(RcFacts, ExpertScheduleIsMoreThanAKelvinOff) {
  const WorkingMean found = working_mean(expert_rule);
  std::printf("(b) expert schedule: mean %.3f degC, DAE %.3f degC\n", found.mean_degc, found.error_k);
  EXPECT_GT(found.error_k, 1.1);
  EXPECT_LT(found.error_k, 1.9);
}

TEST(RcFacts, SetpointStepIsAlmostCompleteWithinTwoCycles) {
  RcPlant plant(make_room(), hot_weather(), july, 1, 22.5);
  double at_18 = 0, at_36 = 0, at_144 = 0;
  constexpr int days = 10;
  for (int day = 1; day <= days; ++day) {
    plant.advance_to(later(july, day * 86400 + 9 * 3600));
    RcPlant stays = plant, steps = plant;
    steps.set_setpoint(23.5);
    const auto gain = [&](int minutes) {
      stays.advance_to(later(plant.time(), minutes * 60));
      steps.advance_to(later(plant.time(), minutes * 60));
      return (steps.mean_room_temp_degc() - stays.mean_room_temp_degc()) / days;
    };
    at_18 += gain(18);
    at_36 += gain(36);
    at_144 += gain(144);
  }
  std::printf("(c) 1 K step: gain %.3f at 18 min, %.3f at 36 min, %.3f at 2.4 h; complete %.1f %% and %.1f %%\n", at_18,
              at_36, at_144, 100 * at_18 / at_144, 100 * at_36 / at_144);
  EXPECT_GT(at_18, 0.55);
  EXPECT_LT(at_36, 0.70);
  EXPECT_NEAR(at_18 / at_144, 0.86, 0.03);
  EXPECT_GT(at_36 / at_144, 0.92);
  EXPECT_LT(at_36 / at_144, 0.955);
}

// Mean absolute difference of the zones between a twin and its room on the expert's schedule.
std::pair<double, double> zone_errors(const RcRoom& twin_room, const RcRoom& real_room) {
  RcPlant twin(twin_room, hot_weather(), july, 1), real(real_room, hot_weather(), july, 2);
  double interior = 0, perimeter = 0;
  int count = 0;
  for (int cycle = 0; cycle < 16 * cycles_per_day; ++cycle) {
    if (cycle >= 2 * cycles_per_day) {
      for (std::size_t z = 0; z < 5; ++z) {
        interior += std::fabs(twin.sensors().room_temp_degc[z] - real.sensors().room_temp_degc[z]) / 5;
        perimeter += std::fabs(twin.sensors().fcu_temp_degc[z] - real.sensors().fcu_temp_degc[z]) / 5;
      }
      ++count;
    }
    for (RcPlant* plant : {&twin, &real}) {
      plant->set_setpoint(expert_degc(plant->time()));
      plant->advance_to(later(plant->time(), cycle_s));
    }
  }
  return {interior / count, perimeter / count};
}

TEST(RcFacts, TwinAndRealRoomDisagreeAsInTheReportMoreAtThePerimeter) {
  for (const char* name : {"301", "401", "402", "701", "702"}) {
    const auto [interior, perimeter] = zone_errors(load_room(name), load_room(std::string(name) + "-real"));
    std::printf("(d) twin against %s-real: interior %.2f K, perimeter %.2f K\n", name, interior, perimeter);
    EXPECT_GE(interior, 0.4) << name;
    EXPECT_GT(perimeter, interior) << name;
    EXPECT_LE(perimeter, 1.6) << name;
  }
}

TEST(RcFacts, TheMeanStudyRoomIsAsFarFromTheTwinAsInTheReport) {
  double interior = 0, perimeter = 0;
  const auto rooms = study_rooms(make_room());
  for (const RcRoom& room : rooms) {
    const auto [inside, edge] = zone_errors(make_room(), room);
    interior += inside / static_cast<double>(rooms.size());
    perimeter += edge / static_cast<double>(rooms.size());
    EXPECT_LE(std::max(inside, edge), 1.6) << room.name;
  }
  std::printf("(d) 12 study rooms: interior %.2f K, perimeter %.2f K\n", interior, perimeter);
  EXPECT_GE(interior, 0.4);
  EXPECT_GT(perimeter, interior);
}

TEST(RcFacts, TheMoreIsForeseenTheNearerTheRoomStaysToItsTarget) {
  double error[3] = {};
  for (const Foresight foresight : {Foresight::frozen, Foresight::profile, Foresight::full}) {
    RcPlant plant(make_room(), hot_weather(), july, 1);
    const auto rule = [&](const RcPlant& p) { return floor_setpoint(p, target_degc, 20, 26, foresight); };
    run_days(plant, 1, rule);
    int count = 0;
    double sum = 0;
    run_days(plant, 5, rule, [&](const RcPlant& p) {
      if (!working(p.time())) return;
      sum += std::fabs(mean_of(p.sensors().room_temp_degc) - target_degc);
      ++count;
    });
    error[static_cast<int>(foresight)] = sum / count;
  }
  std::printf("floors: frozen %.3f, mean profile known %.3f, full forecast %.3f degC\n", error[0], error[1], error[2]);
  EXPECT_LT(error[2], 0.02);
  EXPECT_LT(error[2], 0.5 * error[1]);
  EXPECT_LT(error[1], 0.8 * error[0]);
  EXPECT_LT(error[0], 0.15);
}

TEST(RcFacts, AYearRunsAtThisSpeed) {
  RcPlant plant(make_room(), hot_weather(), civil_midnight(2021, 1, 1), 1);
  const auto begin = std::chrono::steady_clock::now();
  plant.advance_to(civil_midnight(2022, 1, 1));
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::printf("a year of 3-min steps: %.2f s\n", seconds);
  EXPECT_EQ(text_of(plant.time()), "2022-01-01 00:00");
  for (double temp : plant.zone_temp_degc()) EXPECT_TRUE(temp > 0 && temp < 45) << temp;
}

}  // namespace
}  // namespace airside::sim::test
