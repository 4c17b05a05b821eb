// Each control mode is taken for its reason, and left when that ends; without the reason nothing changes.

#include "support/controller_rig.hpp"

namespace airside {
namespace {

using Rig = ControllerRig;
using T = FiveZone;
using L = Layout<T>;

constexpr int cycles_per_override = 14;  // 4 h are 13.3

/// Somebody sets the AHU's setpoint between two decisions.
void another_hand(Rig& rig, double degc) {
  rig.row();
  rig.setpoint = degc;
  rig.row();
  rig.row();
}

TEST(ControllerLadder, AnotherHandIsLeftAloneForItsTimeAndNothingIsLearned) {
  Rig rig;
  rig.cycles(6);
  ASSERT_EQ(rig.decision().mode, ControlMode::learn);
  another_hand(rig, 21.0);
  const std::uint64_t remembered = rig.controller->replay().total_pushed();
  rig.cycles(cycles_per_override);
  EXPECT_EQ(rig.decision().mode, ControlMode::release);
  EXPECT_EQ(rig.decision().reason, Reason::overridden);
  EXPECT_EQ(rig.setpoint, 21.0) << "it was written over";
  EXPECT_EQ(rig.controller->replay().total_pushed(), remembered) << "the other hand's cycle was learned from";
  EXPECT_TRUE(rig.controller->cycle().mode_arbiter.beats(rig.now));
  rig.cycles(1);
  EXPECT_EQ(rig.decision().mode, ControlMode::learn);
  EXPECT_NE(rig.setpoint, 21.0) << "and is taken back after its time";
}

TEST(ControllerLadder, AWishForReleaseBetweenDecisionAndWriteLeavesWhatStands) {
  Rig rig;
  rig.cycles(6);
  const std::uint64_t remembered = rig.controller->replay().total_pushed();
  const auto d = rig.controller->decide(rig.now, Expected<Reading<T>>(rig.reading()));
  ASSERT_EQ(rig.decision().mode, ControlMode::learn);
  rig.controller->absorb(d, tl::unexpected(Fault::released));
  EXPECT_EQ(rig.decision().fault, Fault::none) << "nothing is wrong";
  EXPECT_EQ(rig.controller->cycle().last_setpoint_degc, rig.setpoint);
  EXPECT_EQ(rig.controller->replay().total_pushed(), remembered + 1) << "the cycle before was ours";
  EXPECT_EQ(rig.controller->cycle().ours, 0);
}

TEST(ControllerLadder, Row49ForecastsThatAreWrongForADayAreTold) {
  Rig rig(brief_learning());
  rig.cycles(6);
  int cycles = 0;
  for (; rig.decision().reason != Reason::forecasts_doubted && cycles < 3 * cycles_per_day; ++cycles) {
    inside(*rig.controller).cycle.head_expected_degc += 3;
    rig.cycles(1);
  }
  EXPECT_GE(cycles, cycles_per_day);
  EXPECT_LE(cycles, cycles_per_day + 40) << "a day after the schedule has the say";
  EXPECT_EQ(rig.decision().mode, ControlMode::learn) << "an alarm, no rung: the schedule has the say by itself";
  rig.cycles(60);
  EXPECT_FALSE(rig.controller->cycle().mode_arbiter.active(Reason::forecasts_doubted, rig.now));
}

TEST(ControllerLadder, Row49WithoutWrongForecastsNoneAreDoubted) {
  Rig rig(brief_learning());
  for (int i = 0; i < 3 * cycles_per_day; ++i) {
    rig.cycles(1);
    ASSERT_NE(rig.decision().reason, Reason::forecasts_doubted) << i;
  }
}

TEST(ControllerLadder, ADeviceThatWasOutOfTouchIsNoOtherHand) {
  Rig rig;
  rig.cycles(6);
  rig.row();
  rig.setpoint = 21.0;  // it restarted at its default
  const auto reconnected = [](Reading<T> r) {
    r.contact = 2;
    return Expected<Reading<T>>(r);
  };
  rig.row(reconnected);
  rig.row(reconnected);
  rig.cycles(1, reconnected);
  EXPECT_EQ(rig.decision().mode, ControlMode::learn);
  EXPECT_NE(rig.setpoint, 21.0);
}

TEST(ControllerLadder, Row24WithoutAnotherHandADeviceAtItsDefaultAfterARestartIsTakenOver) {
  const auto first_contact = [](Reading<T> r) {
    r.contact = 1;  // as each process counts
    return Expected<Reading<T>>(r);
  };
  for (const bool restarts : {true, false}) {
    Rig rig;
    rig.cycles(6, first_contact);
    rig.row(first_contact);
    if (restarts) {
      ASSERT_EQ(restart(*rig.controller), Fault::none);
    }
    rig.setpoint = 21.0;
    rig.row(first_contact);  // no cycle begins with the first row after the restart
    rig.row(first_contact);
    rig.cycles(1, first_contact);
    EXPECT_EQ(rig.decision().reason, restarts ? Reason::none : Reason::overridden);
    EXPECT_EQ(rig.setpoint == 21.0, !restarts);
  }
}

TEST(ControllerLadder, ASetpointThatShowsLateIsOurOwn) {
  Rig rig;
  rig.cycles(6);
  // The device confirms the old value and shows the new one only later.
  const double before = rig.setpoint;
  const auto d = rig.controller->decide(rig.now, Expected<Reading<T>>(rig.reading()));
  rig.setpoint = d.command.setpoint_degc();
  ASSERT_GT(std::abs(rig.setpoint - before), 0.05) << "the rig must have moved";
  rig.controller->absorb(d, Applied{before});
  rig.now.seconds += row_s;
  rig.row();
  rig.row();
  rig.cycles(1);
  EXPECT_EQ(rig.decision().mode, ControlMode::learn) << request_of(rig.decision().reason).why;
}

TEST(ControllerLadder, TheThirdForeignSetpointInADayEndsInReleaseUntilHandedBack) {
  Rig rig(brief_learning());
  rig.cycles(6);
  for (int i = 0; i < 3; ++i) {
    another_hand(rig, 21.0);
    rig.cycles(cycles_per_override);
  }
  EXPECT_EQ(rig.decision().reason, Reason::two_masters);
  EXPECT_FALSE(rig.controller->cycle().mode_arbiter.beats(rig.now)) << "the AHU must take over by itself";
  rig.cycles(10 * cycles_per_day);
  EXPECT_EQ(rig.decision().reason, Reason::two_masters);
  EXPECT_EQ(rig.setpoint, 21.0);
  rig.controller->hand_back();
  rig.cycles(2);
  EXPECT_EQ(rig.decision().mode, ControlMode::learn);
  EXPECT_NE(rig.setpoint, 21.0);
}

TEST(ControllerLadder, AStepIsCountedFromWhatWasSeenLastAlsoBetweenTwoDecisionsAndAfterARestart) {
  ControllerSettings settings = product_settings();
  settings.limit_change_k = 1;
  Rig rig(settings);
  rig.cycles(6);
  rig.row();
  rig.setpoint = 26.5;  // somebody's, seen in the row between
  rig.row();
  rig.row();
  const auto nothing = [](Reading<T>) { return Expected<Reading<T>>(tl::unexpected(Fault::no_reading)); };
  const auto d = rig.controller->decide(rig.now, nothing(rig.reading()));
  EXPECT_GE(d.command.setpoint_degc(), 25.5 - 1e-9);
  rig.controller->absorb(d, tl::unexpected(Fault::not_applied));
  const double asked = d.command.setpoint_degc();
  // A crash, and the AHU shows what was asked for, or restarted at its default meanwhile.
  const CycleState<T> before = rig.controller->cycle();
  for (const double shown : {asked, 19.0}) {
    inside(*rig.controller).cycle = before;
    EXPECT_EQ(restart(*rig.controller), Fault::none);
    rig.setpoint = shown;
    const double a = rig.controller->decide({rig.now.seconds + cycle_s}, Expected<Reading<T>>(rig.reading()))
                         .command.setpoint_degc();
    EXPECT_NEAR(a, shown, 1 + 1e-9);
    if (shown == asked) {
      EXPECT_NEAR(a, 26.5, 1 + 1e-9) << "its write may not have been done";
    }
  }
}

TEST(ControllerLadder, AnOverrideADayIsNoFight) {
  Rig rig(brief_learning());
  rig.cycles(6);
  for (int i = 0; i < 5; ++i) {
    another_hand(rig, 21.0);
    rig.cycles(cycles_per_day + 5);
    EXPECT_EQ(rig.decision().mode, ControlMode::learn) << i;
  }
}

TEST(ControllerLadder, ARefusedSetpointIsFollowedByTheScheduleThenByRelease) {
  Rig rig;
  rig.cycles(6);
  rig.refusal = Fault::write_refused;
  rig.cycles(1, {}, true);
  EXPECT_EQ(rig.decision().mode, ControlMode::learn) << "the first refusal is known only afterwards";
  EXPECT_EQ(rig.decision().fault, Fault::write_refused);
  rig.cycles(1, {}, true);
  EXPECT_EQ(rig.decision().reason, Reason::write_refused);
  EXPECT_EQ(rig.decision().mode, ControlMode::expert);
  rig.cycles(1, {}, true);
  EXPECT_EQ(rig.decision().mode, ControlMode::release);
  EXPECT_EQ(rig.decision().reason, Reason::writes_refused);
  rig.cycles(3);
  EXPECT_EQ(rig.decision().mode, ControlMode::expert) << "after an hour the schedule is tried again";
  rig.cycles(1);
  EXPECT_EQ(rig.decision().mode, ControlMode::learn) << "and taken";
}

TEST(ControllerLadder, ALostLinkIsNoRefusal) {
  Rig rig;
  rig.cycles(6);
  rig.cycles(4, {}, true);
  EXPECT_EQ(rig.decision().mode, ControlMode::learn);
  EXPECT_EQ(rig.decision().fault, Fault::not_applied);
}

TEST(ControllerLadder, ASetpointThatTheAhuClampsIsAnAlarmAndIsLearnedFromAsTaken) {
  Rig rig;
  rig.cycles(6);
  const auto d = rig.controller->decide(rig.now, Expected<Reading<T>>(rig.reading()));
  const double taken = d.command.setpoint_degc() + 1;
  rig.setpoint = taken;
  rig.controller->absorb(d, Applied{taken});
  EXPECT_EQ(rig.controller->cycle().last_setpoint_degc, taken);
  EXPECT_TRUE(rig.controller->cycle().mode_arbiter.active(Reason::setpoint_altered, rig.now));
  EXPECT_EQ(rig.controller->cycle().mode_arbiter.mode(rig.now), ControlMode::learn);
  rig.now.seconds += row_s;
  rig.row();
  rig.row();
  rig.cycles(1);
  EXPECT_EQ(rig.decision().mode, ControlMode::learn);
  EXPECT_FALSE(rig.controller->cycle().mode_arbiter.active(Reason::setpoint_altered, rig.now));
}

TEST(ControllerLadder, OneRoomFarFromTheOthersFreezesLearningAndControlGoesOn) {
  Rig rig;
  rig.cycles(6);
  const auto hot = [](Reading<T> r) {
    r.value(2) = 40 + 0.01 * (static_cast<double>(r.time.seconds / row_s % 2));
    return Expected<Reading<T>>(r);
  };
  rig.cycles(5, hot);
  EXPECT_EQ(rig.decision().mode, ControlMode::run);
  EXPECT_EQ(rig.decision().reason, Reason::room_disagrees);
  EXPECT_EQ(rig.decision().fault_signal, 2);
  EXPECT_LT(rig.decision().room_mean_degc, 27);
  rig.cycles(5);
  EXPECT_EQ(rig.decision().mode, ControlMode::learn);
}

TEST(ControllerLadder, AFrozenDeviceEndsInTheSchedule) {
  Rig rig;
  rig.cycles(6);
  const Reading<T> last = rig.reading();
  const auto frozen = [&](Reading<T> r) {
    r.value = last.value;
    return Expected<Reading<T>>(r);
  };
  rig.cycles(6, frozen);
  EXPECT_EQ(rig.decision().mode, ControlMode::expert);
  EXPECT_EQ(rig.decision().fault, Fault::frozen);
  rig.cycles(1);
  EXPECT_EQ(rig.decision().mode, ControlMode::learn);
}

TEST(ControllerLadder, ARepeatedTransitionIsRememberedOnce) {
  Rig rig;
  rig.cycles(6);
  const std::uint64_t remembered = rig.controller->replay().total_pushed();
  const double held = rig.setpoint;
  const Reading<T> last = rig.reading();
  for (int i = 0; i < 3; ++i) {  // three cycles of the same readings at the same setpoint
    Reading<T> r = last;
    r.time = rig.now;
    const auto d = rig.controller->decide(rig.now, Expected<Reading<T>>(r));
    rig.controller->absorb(d, Applied{held});
    rig.now.seconds += cycle_s;
  }
  EXPECT_EQ(rig.controller->replay().total_pushed(), remembered + 2) << "the way there, and one of standing still";
}

TEST(ControllerLadder, AReversedGainEndsInTheScheduleAndASaneOneDoesNot) {
  Rig rig;
  rig.cycles(6);
  auto& head = inside(*rig.controller).learning.head;
  head.theta()(HeadFeatures::setpoint_change) = -0.3;
  head.covariance().col(HeadFeatures::setpoint_change).setZero();
  head.covariance().row(HeadFeatures::setpoint_change).setZero();
  head.covariance()(HeadFeatures::setpoint_change, HeadFeatures::setpoint_change) = 1e-4;
  rig.cycles(1);
  EXPECT_EQ(rig.decision().mode, ControlMode::expert);
  EXPECT_EQ(rig.decision().reason, Reason::gain_reversed);
  head.theta()(HeadFeatures::setpoint_change) = 0.4;
  rig.cycles(2);
  EXPECT_EQ(rig.decision().mode, ControlMode::learn);
}

TEST(ControllerLadder, WorseThanTheScheduleFreezesFirstAndEndsInTheScheduleAfterAWorkingDay) {
  Rig rig(product_settings(), {1'627'862'400 + 8 * 3600});  // in working hours
  rig.cycles(6);
  const ControllerSettings& s = rig.controller->settings();
  int frozen = 0;
  for (int i = 0; i < 2 * cycles_per_day && rig.decision().mode != ControlMode::expert; ++i) {
    for (int k = 0; k < 40; ++k) inside(*rig.controller).cycle.shadow.cycle(s, s.target_degc + 1, 22, 20.5, 0.6);
    rig.cycles(1);
    frozen += rig.decision().reason == Reason::worse_than_schedule;
  }
  EXPECT_GT(frozen, 20);
  EXPECT_EQ(rig.decision().reason, Reason::worse_for_long);
  rig.cycles(cycles_per_day + 1);
  EXPECT_EQ(rig.decision().mode, ControlMode::learn) << "after a day under the schedule it tries again";
}

TEST(ControllerLadder, AnAhuThatTakesAnotherSetpointIsNotWrittenToBeyondTheBudget) {
  for (const bool clamps : {false, true}) {
    ControllerSettings s = brief_learning();
    s.writes_per_day = 20;
    Rig rig(s);
    rig.cycles(cycles_per_day);
    rig.lowest_degc = clamps ? 24.5 : rig.lowest_degc;
    rig.writes = 0;
    constexpr int days = 2;
    rig.cycles(days * cycles_per_day);
    EXPECT_LE(rig.writes, days * 20 + 20) << clamps;
    EXPECT_GE(rig.writes, days) << clamps << ": the schedule's steps at least";
  }
}

TEST(ControllerLadder, AnUpdateBeyondTheTrustRegionIsRefused) {
  ControllerSettings s = brief_learning();
  s.trust_ratio = 1e-3;
  Rig narrow(s), usual(brief_learning());
  s.trust_ratio = 10;
  Rig without(s);
  for (Rig* rig : {&narrow, &usual, &without}) rig->cycles(cycles_per_day);
  EXPECT_GT(narrow.controller->learning().rejected, 60u) << "every usual update is wider";
  EXPECT_EQ(usual.controller->learning().rejected, without.controller->learning().rejected)
      << "and never binds by itself";
}

TEST(ControllerLadder, Row52ARangeThatKeepsTheRoomsFromTheirTargetIsFoundWorseThanTheScheduleByItself) {
  for (const double set_h : {6.0, 12.0}) {
    ControllerSettings s = product_settings();
    s.expert_work_degc = 22.6;  // holds this room; ours may not go there
    s.action_max_degc = 20.8;
    s.worse_h = set_h;
    Rig rig(s, {1'627'862'400 + 7 * 3600});
    int ours = 0, frozen = 0;
    while (rig.decision().mode != ControlMode::expert || rig.decision().reason == Reason::none) {
      rig.cycles(1);
      frozen += rig.decision().reason == Reason::worse_than_schedule;
      ASSERT_LT(++ours, 3 * cycles_per_day);
    }
    EXPECT_EQ(rig.decision().reason, Reason::worse_for_long);
    EXPECT_NEAR(frozen, set_h * 3600 / cycle_s, cycles_per_day / 2 + 1) << "of working hours, the night between them";
    EXPECT_GE(frozen, set_h * 3600 / cycle_s - 1);
  }
}

TEST(ControllerLadder, EveryUpdateRefusedForADayFreezesTheWeightsForADay) {
  Rig rig;
  rig.cycles(6);
  inside(*rig.controller).cycle.refused_updates = rig.controller->settings().refused_updates - 1;
  auto& replay = inside(*rig.controller).replay;
  for (int i = 0; i < replay.size(); ++i) replay.slot(i).fill(std::numeric_limits<float>::quiet_NaN());
  rig.cycles(1);
  EXPECT_EQ(rig.decision().fault, Fault::learning_rejected);
  replay.clear();
  rig.cycles(2);
  EXPECT_EQ(rig.decision().mode, ControlMode::run);
  EXPECT_EQ(rig.decision().reason, Reason::learning_refused);
  rig.cycles(cycles_per_day);
  EXPECT_EQ(rig.decision().mode, ControlMode::learn);
}

TEST(ControllerLadder, WhatTheSurroundingsReportTakesTheRungAndGoesWithIt) {
  Rig rig;
  rig.cycles(6);
  rig.controller->report(Reason::clock_not_set, true, rig.now);
  rig.cycles(1);
  EXPECT_EQ(rig.decision().mode, ControlMode::expert);
  EXPECT_EQ(rig.decision().reason, Reason::clock_not_set);
  rig.controller->report(Reason::clock_not_set, false, rig.now);
  rig.controller->report(Reason::released_by_hand, true, rig.now);
  const double before = rig.setpoint;
  rig.cycles(3);
  EXPECT_EQ(rig.decision().mode, ControlMode::release);
  EXPECT_EQ(rig.setpoint, before);
  rig.controller->hand_back();
  rig.cycles(1);
  EXPECT_EQ(rig.decision().mode, ControlMode::learn);
}

TEST(ControllerLadder, TheSchedulesAndGuideline36sWishesStandBesideOurs) {
  Rig rig(product_settings(), {1'627'862'400 + 9 * 3600});
  rig.cycles(3);
  EXPECT_EQ(rig.decision().expert_degc, 20.5);
  EXPECT_TRUE(std::isfinite(rig.decision().g36_degc));
  EXPECT_GE(rig.decision().g36_degc, rig.controller->settings().action_min_degc);
  EXPECT_LE(rig.decision().g36_degc, rig.controller->settings().action_max_degc);
}

}  // namespace
}  // namespace airside
