// Sensors, the AHU's setpoint, the box's sleep and the learning: each fault in a controlled room, and what looks like
// it and is none.

#include <gtest/gtest.h>

#include "fault_matrix/fault_loop.hpp"
#include "support/bench.hpp"
#include "support/default_cycle.hpp"

namespace airside::fault_matrix {
namespace {

using sim::FaultKind;

constexpr double hour_cycles = 60.0 / 18;
constexpr int in_cycles(double hours) { return static_cast<int>(hours * hour_cycles); }

/// A room that has been under control for half a day, past the holds of its beginning.
class Room : public ::testing::Test {
 protected:
  Room() {
    loop.cycles(40);
    EXPECT_EQ(loop.decision().mode, ControlMode::learn) << text_of(loop.decision().reason);
  }
  ~Room() override {
    EXPECT_EQ(loop.watchman().unsafe(), 0u) << loop.watchman().first;
    EXPECT_EQ(loop.watchman().learned_bad, 0u) << loop.watchman().first;
  }
  std::uint64_t remembered() { return loop.controller().replay().total_pushed(); }
  ControlMode mode() const { return loop.decision().mode; }
  Reason reason() const { return loop.decision().reason; }
  bool active(Reason r) { return loop.controller().cycle().mode_arbiter.active(r, loop.box_time()); }
  /// Whether any of the next cycles shows the reason.
  bool shows(Reason r, int cycles) {
    for (int i = 0; i < cycles; ++i) {
      loop.cycles(1);
      if (active(r) || loop.decision().reason == r) return true;
    }
    return false;
  }

  FaultLoop loop{prepared_room()};
};

TEST_F(Room, Row01ALostSignalIsHeldForACycleThenTheScheduleRunsAndItComesBack) {
  loop.begin(FaultKind::not_a_number, 6, 2);
  const std::uint64_t before = remembered();
  loop.cycles(1);
  EXPECT_EQ(mode(), ControlMode::run);
  EXPECT_EQ(reason(), Reason::signal_held);
  loop.cycles(2);
  EXPECT_EQ(mode(), ControlMode::expert);
  EXPECT_EQ(reason(), Reason::signal_lost);
  EXPECT_EQ(loop.decision().fault, Fault::not_finite);
  EXPECT_EQ(loop.decision().fault_signal, 2);
  EXPECT_LE(remembered() - before, 0u) << "nothing of it is remembered";
  loop.cycles(in_cycles(6) + 2);
  EXPECT_EQ(mode(), ControlMode::learn) << "polling went on";
}

TEST_F(Room, Row01WithoutItASignalAtItsLimitIsUsed) {
  loop.begin(FaultKind::set_to, 6, L::rain, 1);  // the end of its range
  loop.cycles(10);
  EXPECT_EQ(mode(), ControlMode::learn);
}

TEST_F(Room, Row02AnImpossibleValueIsAnAlarmThenTheSchedule) {
  loop.begin(FaultKind::set_to, 6, 0, 300);
  EXPECT_TRUE(shows(Reason::signal_lost, 4));
  EXPECT_EQ(mode(), ControlMode::expert);
  EXPECT_EQ(loop.decision().fault, Fault::not_finite) << "its point map lets no such value through";
  EXPECT_EQ(loop.decision().fault_signal, 0);
}

TEST_F(Room, Row02WithoutItAWarmRoomIsNoFault) {
  loop.begin(FaultKind::offset, 2, 0, 0.8);
  loop.cycles(8);
  EXPECT_EQ(mode(), ControlMode::learn);
}

TEST_F(Room, Row03AJumpIsRejectedUntilThreeSamplesConfirmIt) {
  loop.begin(FaultKind::offset, 24, L::outdoor_temp, -40);
  std::vector<Fault> seen;
  for (int row = 1; row <= 4; ++row) {
    loop.in_hours(0.1 * row, [&] { seen.push_back(loop.controller().cycle().validator.faults()[L::outdoor_temp]); });
  }
  loop.cycles(3);
  EXPECT_EQ(seen, (std::vector<Fault>{Fault::rate_exceeded, Fault::rate_exceeded, Fault::none, Fault::none}));
}

TEST_F(Room, Row03WithoutItABoxThatClosesIsFollowedAtOnce) {
  loop.begin(FaultKind::set_to, 1, L::vav_on + 1, 0);
  loop.cycles(2);
  EXPECT_NE(loop.decision().fault, Fault::rate_exceeded);
  EXPECT_EQ(mode(), ControlMode::learn);
}

TEST_F(Room, Row04AStuckRoomAmongMovingOnesEndsInTheScheduleAndFreezesLearning) {
  loop.begin(FaultKind::stuck, 60, 3);
  ASSERT_TRUE(shows(Reason::signal_lost, in_cycles(40)));
  EXPECT_EQ(loop.decision().fault, Fault::stuck);
  EXPECT_EQ(loop.decision().fault_signal, 3);
  const std::uint64_t before = remembered();
  loop.cycles(5);
  EXPECT_EQ(remembered(), before);
  EXPECT_EQ(mode(), ControlMode::expert);
  loop.clear();
  loop.cycles(4);
  EXPECT_EQ(mode(), ControlMode::learn);
}

TEST_F(Room, Row04WithoutItNoRoomOfAWeekIsCalledStuck) {
  loop.cycles(7 * cycles_per_day);
  EXPECT_EQ(loop.reason_rows(Reason::signal_lost), 0u);
  EXPECT_EQ(loop.gravest(), ControlMode::learn);
}

TEST_F(Room, Row05AStaleSignalIsHeldForACycleThenTheScheduleRuns) {
  loop.begin(LoopFault::stale, 6, 4, 7200);
  loop.cycles(1);
  EXPECT_EQ(mode(), ControlMode::run);
  loop.cycles(1);
  EXPECT_EQ(mode(), ControlMode::expert) << "no more than one cycle";
  EXPECT_EQ(loop.decision().fault, Fault::stale);
  EXPECT_EQ(loop.decision().fault_signal, 4);
}

TEST_F(Room, Row05WithoutItAFewMinutesAreFresh) {
  loop.begin(LoopFault::stale, 6, 4, 300);
  loop.cycles(10);
  EXPECT_EQ(mode(), ControlMode::learn);
}

TEST_F(Room, Row06OneRoomFarFromAllOthersIsReplacedByTheirMedianAndTwoEndInTheSchedule) {
  loop.begin(FaultKind::offset, 30, 1, 11);
  loop.cycles(4);
  EXPECT_EQ(reason(), Reason::room_disagrees);
  EXPECT_EQ(mode(), ControlMode::run);
  EXPECT_NEAR(loop.decision().room_mean_degc, 25.25, 1.5) << "not the 2 K that the room would add";
  loop.begin(FaultKind::offset, 30, 3, -11);
  loop.cycles(4);
  EXPECT_EQ(mode(), ControlMode::expert);
  EXPECT_EQ(loop.decision().fault, Fault::disagrees);
}

TEST_F(Room, Row06WithoutItAClosedBoxMayHaveAWarmRoom) {
  loop.begin(FaultKind::offset, 30, 1, 4);
  loop.cycles(20);
  EXPECT_EQ(mode(), ControlMode::learn);
}

TEST_F(Room, Row07ASensorThatDriftsIsAnAlarmWithoutLearning) {
  loop.cycles(14 * cycles_per_day);  // what is usual must be known
  loop.begin(FaultKind::drift, 40 * 24, 2, 0.3);
  ASSERT_TRUE(shows(Reason::sensor_drifts, 15 * cycles_per_day));
  EXPECT_EQ(mode(), ControlMode::run);
  const auto& learning = loop.controller().learning();
  const std::uint64_t before = learning.learner.steps(), pushed = remembered();
  const auto updates = learning.head.updates();
  loop.cycles(10);
  EXPECT_EQ(learning.learner.steps(), before);
  EXPECT_EQ(learning.head.updates(), updates);
  EXPECT_EQ(remembered(), pushed) << "nothing of it is trained on later";
}

TEST_F(Room, Row07WithoutItSixWeeksShowNoDrift) {
  loop.cycles(42 * cycles_per_day);
  EXPECT_EQ(loop.reason_rows(Reason::sensor_drifts), 0u);
}

TEST_F(Room, Row23AClampedSetpointIsAnAlarmAndTheTakenOneIsLearnedFrom) {
  loop.begin(FaultKind::setpoint_clamped, 10, -1, 19);
  const std::uint64_t before = remembered();
  loop.cycles(6);
  EXPECT_TRUE(active(Reason::setpoint_altered));
  EXPECT_EQ(mode(), ControlMode::learn) << "an alarm, no more";
  EXPECT_GT(remembered(), before);
  const auto& learning = loop.controller().learning();
  const double applied =
      static_cast<double>(loop.controller().replay().newest(0)[L::setpoint]) * learning.scaler.scale(L::setpoint) +
      learning.scaler.mean(L::setpoint);
  EXPECT_NEAR(applied, 19, 1e-4);
}

TEST_F(Room, Row23WithoutItNoSetpointOfAWeekIsAltered) {
  loop.cycles(7 * cycles_per_day);
  EXPECT_FALSE(active(Reason::setpoint_altered));
  EXPECT_EQ(loop.reason_rows(Reason::setpoint_altered), 0u);
}

TEST_F(Room, Row24AnotherHandsSetpointIsLeftAloneForFourHours) {
  loop.begin(FaultKind::setpoint_by_hand, 0, -1, 21.4);
  const std::uint64_t before = remembered();
  loop.cycles(in_cycles(3.9));
  EXPECT_EQ(mode(), ControlMode::release);
  EXPECT_EQ(reason(), Reason::overridden);
  EXPECT_EQ(loop.standing_degc(), 21.4);
  EXPECT_EQ(remembered(), before) << "nothing is learned from it";
  loop.cycles(2);
  EXPECT_EQ(mode(), ControlMode::learn) << "its time is over";
  EXPECT_NE(loop.standing_degc(), 21.4);
}

TEST_F(Room, Row24WhoMovesHisOwnSetpointAgainIsNoSecondMaster) {
  for (int i = 0; i < 6; ++i) {
    loop.begin(FaultKind::setpoint_by_hand, 0, -1, 21 + 0.5 * i);
    loop.cycles(2);
    EXPECT_EQ(reason(), Reason::overridden) << i;
  }
  EXPECT_EQ(loop.standing_degc(), 23.5);
}

TEST_F(Room, Row24WithoutItARestartedAhuIsTakenOverAtOnce) {
  loop.begin(LoopFault::no_answer, 0.15);
  loop.begin(FaultKind::restarted, 0, -1, 20.3);
  loop.cycles(2);
  EXPECT_EQ(mode(), ControlMode::learn);
  EXPECT_NE(loop.standing_degc(), 20.3);
}

TEST_F(Room, Row25AThirdTakeBackInADayIsReleaseUntilAPersonHandsBack) {
  loop.begin(FaultKind::setpoint_fought, 20, -1, 23.4);
  EXPECT_TRUE(shows(Reason::two_masters, in_cycles(20)));
  EXPECT_EQ(mode(), ControlMode::release);
  EXPECT_FALSE(loop.controller().cycle().mode_arbiter.beats(loop.box_time())) << "the AHU's own controller takes over";
  loop.clear();
  loop.cycles(3 * cycles_per_day);
  EXPECT_EQ(reason(), Reason::two_masters);
  loop.controller().hand_back();
  loop.cycles(3);
  EXPECT_EQ(mode(), ControlMode::learn);
}

TEST_F(Room, Row25WithoutItOneHandADayIsNoFight) {
  for (int day = 0; day < 4; ++day) {
    loop.begin(FaultKind::setpoint_by_hand, 0, -1, 21.1);
    loop.cycles(cycles_per_day);
  }
  EXPECT_EQ(loop.reason_rows(Reason::two_masters), 0u);
  EXPECT_EQ(loop.reason_rows(Reason::overridden), static_cast<std::uint64_t>(4 * 42))
      << "4 h and a cycle each, in rows";
  EXPECT_EQ(mode(), ControlMode::learn);
}

TEST_F(Room, Row27SupplyAirThatIgnoresItsSetpointFreezesLearningAndIsAnAlarm) {
  loop.begin(FaultKind::setpoint_ignored, 30);
  ASSERT_TRUE(shows(Reason::supply_ignores_setpoint, in_cycles(28)));
  EXPECT_EQ(mode(), ControlMode::run);
  const auto& learning = loop.controller().learning();
  const std::uint64_t before = learning.learner.steps(), pushed = remembered();
  const auto updates = learning.head.updates();
  loop.cycles(3);
  EXPECT_EQ(learning.learner.steps(), before);
  EXPECT_EQ(learning.head.updates(), updates) << "it would learn the gain of a closed valve";
  EXPECT_EQ(remembered(), pushed);
}

TEST_F(Room, Row27WithoutItTheCoilsLagIsNoAlarm) {
  loop.cycles(14 * cycles_per_day);
  EXPECT_EQ(loop.reason_rows(Reason::supply_ignores_setpoint), 0u);
}

TEST_F(Room, Row31AfterASleepTheMissedCyclesAreSkippedAndNothingIsLearnedAcrossIt) {
  const std::uint64_t cycles = loop.controller().learning().cycles, before = remembered();
  const CivilTime asleep_at = loop.box_time();
  loop.begin(LoopFault::asleep, 7.3);
  loop.cycles(2);
  EXPECT_GE(loop.box_time().seconds - asleep_at.seconds, 7 * 3600);
  EXPECT_EQ(loop.controller().learning().cycles, cycles + 2) << "no burst";
  EXPECT_LE(remembered() - before, 1u) << "only the cycle after it";
  loop.cycles(4);
  EXPECT_EQ(mode(), ControlMode::learn);
}

TEST_F(Room, Row31WithoutItEveryCycleFollowsTheOneBefore) {
  const CivilTime from = loop.box_time();
  const std::uint64_t before = remembered();
  loop.cycles(50);
  EXPECT_EQ(loop.box_time().seconds - from.seconds, 50 * cycle_s);
  EXPECT_EQ(remembered() - before, 50u);
}

TEST_F(Room, Row51MomentsThatAreNoNumbersNeverReachTheWeightsInUse) {
  const auto before = loop.controller().learning().weights.values;
  inside(loop.controller()).learning.learner.first_moment().values.fill(std::numeric_limits<float>::quiet_NaN());
  loop.cycles(3);
  EXPECT_TRUE(all_finite(loop.controller().learning().weights));
  EXPECT_TRUE(all_finite(loop.controller().learning().learner.first_moment()));
  EXPECT_LT(mode(), ControlMode::expert);
  loop.cycles(10);
  EXPECT_NE(loop.controller().learning().weights.values, before) << "and learning goes on";
}

TEST_F(Room, Row51WithoutItUpdatesAreTaken) {
  const std::uint64_t refused = loop.controller().learning().rejected;
  loop.cycles(cycles_per_day);
  EXPECT_LT(loop.controller().learning().rejected - refused, 40u);
}

TEST_F(Room, Row52AHeadThatBelievesInAnotherGainGoesToTheScheduleAndLearnsItAnew) {
  auto& head = inside(loop.controller()).learning.head;
  head.theta()(HeadFeatures::setpoint_change) = -2;
  EXPECT_TRUE(shows(Reason::gain_reversed, 2));
  EXPECT_EQ(mode(), ControlMode::expert);
  loop.cycles(3 * cycles_per_day);
  EXPECT_EQ(mode(), ControlMode::learn) << text_of(reason());
  EXPECT_GT(head.gain(loop.controller().settings()), 0.2);
}

TEST_F(Room, Row52WithoutItAMonthIsNeverWorseThanTheSchedule) {
  loop.cycles(31 * cycles_per_day);
  EXPECT_EQ(loop.reason_rows(Reason::worse_than_schedule) + loop.reason_rows(Reason::worse_for_long), 0u);
}

TEST_F(Room, Row53ADeviceThatRepeatsItselfIsRememberedOnceAndEndsInTheSchedule) {
  loop.begin(FaultKind::all_stuck, 12);
  const std::uint64_t before = remembered();
  loop.cycles(in_cycles(3));
  EXPECT_EQ(loop.decision().fault, Fault::frozen);
  EXPECT_EQ(mode(), ControlMode::expert);
  EXPECT_LE(remembered() - before, 3u);
}

TEST_F(Room, Row53ADayOfFalseReadingsMovesTheWeightsByNoMoreThanTheTrustRegionAndIsForgotten) {
  loop.take_dae_k();
  loop.cycles(5 * cycles_per_day);
  const double usual_k = loop.take_dae_k();
  loop.begin(FaultKind::all_offset, 24, -1, 1.5);
  for (int i = 0; i < cycles_per_day; ++i) {
    const auto before = loop.controller().learning().weights.values;
    loop.cycles(1);
    const auto& after = loop.controller().learning().weights.values;
    double moved = 0, norm = 0;
    for (std::size_t k = 0; k < before.size(); ++k) {
      moved += std::pow(static_cast<double>(after[k]) - static_cast<double>(before[k]), 2);
      norm += std::pow(static_cast<double>(before[k]), 2);
    }
    EXPECT_LE(std::sqrt(moved), loop.controller().settings().trust_ratio * std::sqrt(norm) * 1.001) << i;
  }
  loop.clear();
  loop.cycles(cycles_per_day);
  loop.take_dae_k();
  loop.cycles(5 * cycles_per_day);
  EXPECT_LT(loop.take_dae_k(), 2 * usual_k + 0.03);
}

TEST_F(Room, Row53WithoutItEveryCycleIsRemembered) {
  const std::uint64_t before = remembered();
  loop.cycles(2 * cycles_per_day);
  EXPECT_EQ(remembered() - before, static_cast<std::uint64_t>(2 * cycles_per_day));
}

}  // namespace
}  // namespace airside::fault_matrix
