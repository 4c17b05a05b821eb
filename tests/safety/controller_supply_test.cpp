// Supply air and setpoint register: air that does not follow, a fan that rests at night, a register found outside.

#include <algorithm>
#include <cmath>

#include "support/controller_rig.hpp"
#include "support/default_cycle.hpp"

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

/// Rooms that warm up by kelvins while the fan rests, one of them by 9 K more than the others.
Rig::Spoil hot_at_night(const Rig& rig, double* hours) {
  return [&rig, hours](Reading<T> r) {
    const double h = r.time.second_of_day() / 3600.0;
    *hours = h;
    const bool runs = h >= 6 && h < 20;
    r.flows = runs ? 1 : 0;
    r.supply_temp_degc = runs ? rig.setpoint + 0.3 : 30;
    const double warmed = h < 6 ? 1 : std::clamp(runs ? 1 - (h - 6) / 1.5 : (h - 20) / 1.5, 0.0, 1.0);
    for (int i = 0; i < Layout<T>::rooms; ++i) r.value(i) += 5 * warmed;
    r.value(2) += 9 * warmed;
    return Expected<Reading<T>>(r);
  };
}

TEST(ControllerSupply, NothingMovesWhileTheFanRests) {
  Rig rig(brief_learning());
  double hours = 0;
  const Rig::Spoil spoil = hot_at_night(rig, &hours);
  while (rig.now.second_of_day() < 6 * 3600) rig.row(spoil);
  while (rig.now.second_of_day() < 20 * 3600) rig.row(spoil);
  rig.cycles(1, spoil);  // the one that begins with still air
  const double setpoint = rig.setpoint, confidence = rig.controller->cycle().confidence;
  const std::uint32_t updates = rig.controller->learning().head.updates();
  const std::uint64_t remembered = rig.controller->replay().total_pushed();
  const int writes = rig.writes;
  const double gain = rig.controller->learning().head.theta()(HeadFeatures::setpoint_change);
  while (rig.now.second_of_day() != 6 * 3600) {
    rig.row(spoil);
    EXPECT_EQ(rig.decision().mode, ControlMode::learn) << hours;
    EXPECT_EQ(rig.controller->cycle().mode_arbiter.gravest(rig.now), Reason::none) << hours;
  }
  EXPECT_EQ(rig.setpoint, setpoint);
  EXPECT_EQ(rig.writes, writes);
  EXPECT_EQ(rig.controller->cycle().confidence, confidence);
  EXPECT_EQ(rig.controller->learning().head.updates(), updates);
  EXPECT_EQ(rig.controller->learning().head.theta()(HeadFeatures::setpoint_change), gain);
  EXPECT_EQ(rig.controller->replay().total_pushed(), remembered);
  rig.cycles(8, spoil);
  EXPECT_GT(rig.controller->replay().total_pushed(), remembered) << "and all goes on with the fan";
}

TEST(ControllerSupply, AWeekOfStillAirIsNoLackOfExcitationAndNoDrift) {
  Rig rig(brief_learning());
  rig.cycles(2 * cycles_per_day);
  for (int row = 0; row < 7 * rows_per_day; ++row) {
    rig.row([](Reading<T> r) {
      r.flows = 0;
      r.value(1) += 3;
      return Expected<Reading<T>>(r);
    });
    ASSERT_EQ(rig.controller->cycle().mode_arbiter.gravest(rig.now), Reason::none) << row;
  }
}

/// Rooms that stay this far from their target whatever is done.
Rig::Spoil rooms_off_by(double k) {
  return [k](Reading<T> r) {
    for (int i = 0; i < Layout<T>::rooms; ++i) {
      r.value(i) = 25.25 + k + 0.01 * std::sin(static_cast<double>(r.time.seconds) / 3000.0 + i);
    }
    return Expected<Reading<T>>(r);
  };
}

bool says_lost(const Rig& rig) { return rig.controller->cycle().mode_arbiter.active(Reason::authority_lost, rig.now); }

TEST(ControllerSupply, SetpointAtItsLimitWithoutEffectIsSaidInWorkingHoursAndDoesNotWindUp) {
  Rig rig(brief_learning());
  while (rig.now.second_of_day() < 7 * 3600) {
    rig.row(rooms_off_by(2));
    EXPECT_FALSE(says_lost(rig)) << "nobody is there at night";
  }
  rig.cycles(5, rooms_off_by(2));
  EXPECT_FALSE(says_lost(rig)) << "90 min of work";
  EXPECT_LE(rig.setpoint, 20.1) << "the coldest there is";
  rig.cycles(4, rooms_off_by(2));
  EXPECT_TRUE(says_lost(rig));
  EXPECT_EQ(rig.decision().mode, ControlMode::learn) << "an alarm, and no other control";
  EXPECT_GE(rig.controller->cycle().mode_arbiter.since_s(Reason::authority_lost), rig.now.seconds - 3600);
  rig.cycles(2, rooms_off_by(-1));
  EXPECT_FALSE(says_lost(rig));
  EXPECT_GT(rig.setpoint, 20.3) << "within two cycles, however long it stood there";
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
