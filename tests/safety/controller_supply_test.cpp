// Supply air and setpoint register: air that does not follow, a fan that rests at night, a register found outside.

#include "support/controller_rig.hpp"

namespace airside {
namespace {

using T = FiveZone;
using Rig = ControllerRig;

Rig::Spoil supply_off_by(const Rig& rig, double k) {
  return [&rig, k](Reading<T> r) {
    r.supply_temp_degc = rig.setpoint + k;
    return Expected<Reading<T>>(r);
  };
}

TEST(ControllerSupply, SupplyAirThatIgnoresItsSetpointFreezesLearningAfterAWhile) {
  Rig rig;
  rig.cycles(6, supply_off_by(rig, 0.3));
  rig.cycles(4, supply_off_by(rig, 2.0));
  EXPECT_EQ(rig.decision().mode, ControlMode::learn) << "an hour may pass";
  rig.cycles(2, supply_off_by(rig, 2.0));
  EXPECT_EQ(rig.decision().mode, ControlMode::run);
  EXPECT_EQ(rig.decision().reason, Reason::supply_ignores_setpoint);
  const NetworkWeights<T, float> before = rig.controller->learning().weights;
  rig.cycles(3, supply_off_by(rig, 2.0));
  EXPECT_TRUE(rig.same_weights(before));
  rig.cycles(2, supply_off_by(rig, 0.3));
  EXPECT_EQ(rig.decision().mode, ControlMode::learn);
}

/// Supply air that follows only while the fan runs, 07:00 to 20:00; `shown`: the point that says so.
Rig::Spoil still_at_night(const Rig& rig, bool shown) {
  return [&rig, shown](Reading<T> r) {
    const double h = r.time.second_of_day() / 3600.0;
    const bool runs = h >= 7 && h < 20;
    r.supply_temp_degc = runs ? rig.setpoint + 0.3 : 30;
    if (shown) r.flows = runs ? 1 : 0;
    return Expected<Reading<T>>(r);
  };
}

struct FanDay {
  int alarms = 0, frozen = 0, learned_at_night = 0, learned_by_day = 0;
};

/// Two days of an AHU whose fan stops at night.
FanDay fan_day(const ControllerSettings& settings, bool shown) {
  Rig rig(settings);
  FanDay seen;
  for (int row = 0; row < 2 * rows_per_day; ++row) {
    const CivilTime t = rig.now;
    const std::uint64_t before = rig.controller->replay().total_pushed();
    rig.row(still_at_night(rig, shown));
    const double h = t.second_of_day() / 3600.0;
    const bool night = h >= 20.05 || h < 7.4;  // a cycle counts where the fan ran from its begin to its end
    const int learned = static_cast<int>(rig.controller->replay().total_pushed() - before);
    (night ? seen.learned_at_night : seen.learned_by_day) += learned;
    seen.alarms += rig.controller->cycle().mode_arbiter.active(Reason::supply_ignores_setpoint, t);
    seen.frozen += rig.decision().mode != ControlMode::learn;
  }
  return seen;
}

TEST(ControllerSupply, AFanThatRestsAtNightIsNoAlarmWhereTheSiteSaysSo) {
  ControllerSettings scheduled = brief_learning();
  scheduled.fan_start_h = 7;
  scheduled.fan_end_h = 20;
  for (const FanDay& seen : {fan_day(scheduled, false), fan_day(brief_learning(), true)}) {
    EXPECT_EQ(seen.alarms, 0);
    EXPECT_EQ(seen.frozen, 0);
    EXPECT_EQ(seen.learned_at_night, 0) << "a gain without flow is none";
    EXPECT_GE(seen.learned_by_day, 2 * 38);
  }
}

TEST(ControllerSupply, SupplyAirThatRestsIsAnAlarmWhereNobodySaysWhy) {
  const FanDay seen = fan_day(brief_learning(), false);
  EXPECT_GT(seen.alarms, rows_per_day / 2);
  EXPECT_GT(seen.frozen, rows_per_day / 2);
}

TEST(ControllerSupply, SupplyAirThatIgnoresItsSetpointIsFoundFromTheFansStartOn) {
  ControllerSettings settings = brief_learning();
  settings.fan_start_h = 7;
  settings.fan_end_h = 20;
  settings.fan_weekday_only = 1;
  Rig rig(settings);  // Monday, 00:00
  while (rig.now.second_of_day() < 7 * 3600) rig.row(supply_off_by(rig, 4));
  for (int row = 0; row < 15; ++row) rig.row(supply_off_by(rig, 4));
  EXPECT_FALSE(rig.controller->cycle().mode_arbiter.active(Reason::supply_ignores_setpoint, rig.now)) << "84 min";
  for (int row = 0; row < 2; ++row) rig.row(supply_off_by(rig, 4));
  EXPECT_TRUE(rig.controller->cycle().mode_arbiter.active(Reason::supply_ignores_setpoint, rig.now));
  rig.now.seconds += 5 * 86400;  // Saturday
  rig.row(supply_off_by(rig, 4));
  EXPECT_FALSE(rig.controller->cycle().mode_arbiter.active(Reason::supply_ignores_setpoint, rig.now));
}

TEST(ControllerSupply, ASetpointFoundFarOutsideIsBroughtInsideStepByStep) {
  ControllerSettings settings = brief_learning();
  settings.limit_min_degc = settings.action_min_degc = 20;
  settings.limit_max_degc = settings.action_max_degc = 26;
  settings.limit_change_k = 4.5;
  Rig rig(settings);
  rig.setpoint = 8.8;
  rig.cycles(1);
  EXPECT_NEAR(rig.setpoint, 13.3, 1e-9) << "one step from what is stored";
  rig.cycles(1);
  EXPECT_NEAR(rig.setpoint, 17.8, 1e-9);
  rig.cycles(1);
  EXPECT_GE(rig.setpoint, 20);
  settings.outside_jump = 1;
  Rig jumps(settings);
  jumps.setpoint = 30.5;
  (void)jumps.controller->decide(jumps.now, jumps.reading());
  EXPECT_LE(jumps.decision().command.setpoint_degc(), 26);
}

}  // namespace
}  // namespace airside
