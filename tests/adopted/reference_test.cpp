// Reference buildings as plants: the project wrote none of them.

#include <algorithm>
#include <cmath>

#include "adopted/reference_models.hpp"
#include "hal/text/input_error.hpp"
#include "sim/energyplus/plant.hpp"
#include "support/default_cycle.hpp"

namespace airside::sim {
namespace {

struct Range {
  double low = 1e9, high = -1e9;
  void see(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
};

/// Everything that the sensors show, one after the other.
std::vector<double> shown(const Sensors& s) {
  std::vector<double> all;
  for (const auto* group :
       {&s.room_temp_degc, &s.fcu_temp_degc, &s.vav_on, &s.fcu_on, &s.power_kw, &s.damper, &s.zone_setpoint_degc})
    all.insert(all.end(), group->begin(), group->end());
  for (const double one : {s.mau_temp_degc, s.outdoor_temp_degc, s.rain, s.supply_temp_degc, s.setpoint_degc,
                           s.occupied, s.supply_flow_m3s, s.ahu_on})
    all.push_back(std::isnan(one) ? -1000 : one);  // so that equal is equal
  return all;
}

double daytime_setpoint(CivilTime t) { return 13 + 0.25 * (cycle_of_day(t) % 9); }

std::vector<double> log_of(EnergyPlusPlant& plant) {
  std::vector<double> log;
  while (plant.time() < plant.end()) {
    plant.set_setpoint(daytime_setpoint(plant.time()));
    plant.advance_to({plant.time().seconds + cycle_s});
    const std::vector<double> now = shown(plant.sensors());
    log.insert(log.end(), now.begin(), now.end());
  }
  return log;
}

std::vector<double> log_of(const EnergyPlusOptions& options) {
  EnergyPlusPlant plant(options);
  return log_of(plant);
}

std::string message_of_run(const EnergyPlusOptions& options) {
  try {
    EnergyPlusPlant plant(options);
  } catch (const hal::InputError& error) {
    return error.what();
  }
  return {};
}

TEST(AdoptedPlant, FollowsItsSetpointAtTheSupplyNodeInOccupiedHours) {
  AIRSIDE_NEEDS_REFERENCES();
  EnergyPlusOptions options = medium_office();
  options.days = 3;
  EnergyPlusPlant plant(options);
  int hours = 0;
  double worst = 0;
  while (plant.time() < plant.end()) {
    plant.set_setpoint(daytime_setpoint(plant.time()));
    plant.advance_to({plant.time().seconds + cycle_s});
    const Sensors& s = plant.sensors();
    if (s.occupied < 0.5) continue;
    ++hours;
    worst = std::max(worst, std::abs(s.supply_temp_degc - s.setpoint_degc));
  }
  EXPECT_GT(hours, 60);
  EXPECT_LT(worst, 0.3);
}

TEST(AdoptedPlant, ShowsWhatItsOwnControlsDo) {
  AIRSIDE_NEEDS_REFERENCES();
  EnergyPlusPlant plant(medium_office());
  Range damper, fans, cooling, flow;
  int on = 0, occupied = 0;
  while (plant.time() < plant.end()) {
    plant.set_setpoint(14);
    plant.advance_to({plant.time().seconds + cycle_s});
    const Sensors& s = plant.sensors();
    ASSERT_EQ(s.room_temp_degc.size(), 5U);
    ASSERT_EQ(s.damper.size(), 5U);
    ASSERT_EQ(s.zone_setpoint_degc.size(), 5U);
    ASSERT_EQ(s.power_kw.size(), 3U);
    ASSERT_TRUE(s.fcu_temp_degc.empty());
    const int minute = CivilTime{plant.time().seconds - 1}.minute_of_day();
    for (std::size_t i = 0; i < 5; ++i) {
      EXPECT_TRUE(s.room_temp_degc[i] > 18 && s.room_temp_degc[i] < 32) << s.room_temp_degc[i];
      if (s.ahu_on > 0.5) damper.see(s.damper[i]);
      EXPECT_EQ(s.vav_on[i] > 0.5, s.ahu_on > 0.5 && s.damper[i] > 1e-3);
      if (minute > 7 * 60 && minute < 20 * 60) {
        EXPECT_NEAR(s.zone_setpoint_degc[i], 24, 0.01) << minute;
      }
      if (minute < 4 * 60) {
        EXPECT_NEAR(s.zone_setpoint_degc[i], 26.7, 0.01) << minute;
      }
    }
    EXPECT_EQ(s.ahu_on > 0.5, s.supply_flow_m3s > 0.01) << minute;
    fans.see(s.power_kw[0]);
    cooling.see(s.power_kw[1]);
    flow.see(s.supply_flow_m3s);
    on += s.ahu_on > 0.5 ? 1 : 0;
    occupied += s.occupied > 0.5 ? 1 : 0;
  }
  EXPECT_LT(damper.low, 0.35);
  EXPECT_GT(damper.high, 0.5);
  EXPECT_TRUE(fans.high > 2 && fans.high < 60) << fans.high;
  EXPECT_TRUE(cooling.high > 10 && cooling.high < 250) << cooling.high;
  EXPECT_TRUE(flow.high > 1 && flow.high < 12) << flow.high;
  EXPECT_TRUE(on > 45 && on < 72) << on << " of 80 cycles";
  EXPECT_TRUE(occupied > 25 && occupied < 45) << occupied << " of 80 cycles";
}

TEST(AdoptedPlant, RepeatsItselfToTheBitAndChangesOnlyItsNoiseWithTheSeed) {
  AIRSIDE_NEEDS_REFERENCES();
  EnergyPlusOptions options = medium_office();
  EnergyPlusPlant one(options);
  const std::vector<double> first = log_of(one);
  EXPECT_EQ(first, log_of(options));
  options.seed = 2;
  EnergyPlusPlant other(options);
  EXPECT_NE(first, log_of(other));
  EXPECT_EQ(one.true_room_temps_degc(), other.true_room_temps_degc());
}

TEST(AdoptedPlant, BranchTellsWhatTheRunThenDoesAndDisturbsNothing) {
  AIRSIDE_NEEDS_REFERENCES();
  EnergyPlusPlant plant(medium_office()), alone(medium_office());
  const CivilTime morning{plant.time().seconds + 6 * 3600};
  plant.advance_to(morning);
  alone.advance_to(morning);
  for (int cycle = 0; cycle < 30; ++cycle) {
    const CivilTime until{plant.time().seconds + cycle_s};
    const double setpoint = daytime_setpoint(plant.time());
    const double predicted = plant.branch_mean_room_temp_degc(setpoint, until);
    plant.branch_mean_room_temp_degc(setpoint + 2, {until.seconds + cycle_s});
    for (EnergyPlusPlant* each : {&plant, &alone}) {
      each->set_setpoint(setpoint);
      each->advance_to(until);
    }
    ASSERT_EQ(predicted, plant.true_mean_room_temp_degc()) << cycle;
    ASSERT_EQ(shown(plant.sensors()), shown(alone.sensors())) << cycle;
  }
}

TEST(AdoptedPlant, GivesTheFullForecastItsFloor) {
  AIRSIDE_NEEDS_REFERENCES();
  EnergyPlusPlant plant(medium_office());
  plant.advance_to({plant.time().seconds + 10 * 3600});
  const double cold = full_forecast_setpoint(plant, 10, 12, 20), warm = full_forecast_setpoint(plant, 40, 12, 20);
  EXPECT_EQ(cold, 12);
  EXPECT_EQ(warm, 20);
}

TEST(AdoptedPlant, RunsAPackagedUnitOfOneZoneWithoutADamper) {
  AIRSIDE_NEEDS_REFERENCES();
  EnergyPlusPlant plant(small_office());
  int on = 0;
  Range power;
  while (plant.time() < plant.end()) {
    plant.set_setpoint(16);
    plant.advance_to({plant.time().seconds + cycle_s});
    const Sensors& s = plant.sensors();
    ASSERT_EQ(s.damper.size(), 1U);
    EXPECT_TRUE(std::isnan(s.damper[0]));
    EXPECT_TRUE(std::isnan(s.mau_temp_degc));
    ASSERT_EQ(s.power_kw.size(), 2U);
    EXPECT_TRUE(std::isnan(s.power_kw[1]));
    EXPECT_EQ(s.vav_on[0], s.ahu_on);
    power.see(s.power_kw[0]);
    on += s.ahu_on > 0.5 ? 1 : 0;
    if (s.ahu_on > 0.5 && s.occupied > 0.5) {
      EXPECT_NEAR(s.supply_temp_degc, 16, 0.3);
    }
  }
  EXPECT_TRUE(on > 45 && on <= 80) << on;
  EXPECT_TRUE(power.high > 1 && power.high < 50) << power.high;
}

TEST(AdoptedPlant, ShowsFanCoilsOfItsZones) {
  AIRSIDE_NEEDS_REFERENCES();
  EnergyPlusPlant plant(large_hotel());
  plant.advance_to({plant.time().seconds + 15 * 3600});
  const Sensors& s = plant.sensors();
  ASSERT_EQ(s.fcu_temp_degc.size(), 2U);
  EXPECT_EQ(s.fcu_on, (std::vector<double>{1, 1}));
  EXPECT_NEAR(s.fcu_temp_degc[0], s.room_temp_degc[0], 0.2);
  EXPECT_TRUE(std::isnan(s.ahu_on));
  EXPECT_TRUE(std::isnan(s.occupied));
  EXPECT_EQ(s.vav_on, (std::vector<double>{1, 1, 1})) << "the supply node's flow says that the AHU runs";
}

TEST(AdoptedPlant, RefusesANameWithTheNearOnesThatTheModelHas) {
  AIRSIDE_NEEDS_REFERENCES();
  EnergyPlusOptions meter = medium_office(), zone = medium_office(), kind = medium_office();
  meter.own->powers[1] = "Coolin:Electricity";
  const std::string said = message_of_run(meter);
  EXPECT_NE(said.find("near it: 'Cooling:Electricity'"), std::string::npos) << said;
  zone.own->zones[0] = "Core_botom";
  zone.own->supply_fan = "VAV_1_Fann";
  const std::string of_zone = message_of_run(zone);
  EXPECT_NE(of_zone.find("near it: 'Core_bottom'"), std::string::npos) << of_zone;
  EXPECT_NE(of_zone.find("1 more names are missing"), std::string::npos) << of_zone;
  kind.own->supply_setpoint_schedule = "Seasonal-Reset-Supply-Air-Temp-Sch";
  const std::string of_kind = message_of_run(kind);
  EXPECT_NE(of_kind.find("Schedule:Compact"), std::string::npos) << of_kind;
}

}  // namespace
}  // namespace airside::sim
