// Each fault degrades the decision to the schedule, is named, and is left behind when it ends.

#include "airside/presets.hpp"
#include "support/controller_rig.hpp"
#include "support/default_cycle.hpp"

namespace airside {
namespace {

using Rig = ControllerRig;
using T = FiveZone;
using L = Layout<T>;

struct FaultCase {
  const char* name;
  Fault fault;
  Rig::Spoil spoil;
};

Rig::Spoil set(int signal, double value) {
  return [=](Reading<T> r) {
    r.value(signal) = value;
    return Expected<Reading<T>>(r);
  };
}

const FaultCase fault_cases[] = {
    {"NoNumber", Fault::not_finite, set(1, Rig::nan)},
    {"Infinite", Fault::not_finite, set(L::outdoor_temp, std::numeric_limits<double>::infinity())},
    {"OutOfRange", Fault::out_of_range, set(L::mau_temp, 900)},
    {"StatusOfTwo", Fault::out_of_range, set(L::fcu_on + 1, 2)},
    {"Stale", Fault::stale,
     [](Reading<T> r) {
       r.age_s.setConstant(5000);
       return Expected<Reading<T>>(r);
     }},
    {"NoReading", Fault::no_reading,
     [](Reading<T>) -> Expected<Reading<T>> { return tl::unexpected(Fault::no_reading); }},
};

class EachFault : public ::testing::TestWithParam<FaultCase> {};

TEST_P(EachFault, EndsInTheScheduleIsNamedAndIsLeftBehind) {
  Rig rig;
  rig.cycles(6);
  ASSERT_EQ(rig.decision().mode, ControlMode::learn);
  const std::uint64_t remembered = rig.controller->replay().total_pushed();
  rig.cycles(4, GetParam().spoil);
  EXPECT_EQ(rig.decision().mode, ControlMode::expert);
  EXPECT_EQ(rig.decision().fault, GetParam().fault) << text_of(rig.decision().fault);
  EXPECT_EQ(rig.decision().command.setpoint_degc(), expert_setpoint_degc(product_settings(), rig.decision().time));
  EXPECT_EQ(rig.controller->replay().total_pushed(), remembered) << "a faulty sample was remembered";
  rig.cycles(1);
  EXPECT_EQ(rig.decision().fault, Fault::none) << text_of(rig.decision().fault);
  EXPECT_EQ(rig.decision().mode, ControlMode::learn);
  EXPECT_EQ(rig.controller->replay().total_pushed(), remembered)
      << "the cycle that the fault began in was learned from";
  rig.cycles(1);
  EXPECT_EQ(rig.controller->replay().total_pushed(), remembered + 1) << "learning goes on";
}

INSTANTIATE_TEST_SUITE_P(Controller, EachFault, ::testing::ValuesIn(fault_cases),
                         [](const auto& which) { return std::string(which.param.name); });

TEST(ControllerFaults, AShortLossOfOneSensorIsHeldAndControlGoesOnWithoutLearning) {
  Rig rig;
  rig.cycles(6);
  const std::uint64_t remembered = rig.controller->replay().total_pushed();
  rig.row(set(2, Rig::nan));
  EXPECT_EQ(rig.decision().mode, ControlMode::run);
  EXPECT_EQ(rig.decision().fault, Fault::not_finite) << "held, and said so";
  EXPECT_EQ(rig.decision().fault_signal, 2);
  EXPECT_EQ(rig.controller->replay().total_pushed(), remembered);
}

TEST(ControllerFaults, AJumpIsHeldAndBelievedOnceConfirmed) {
  Rig rig;
  rig.cycles(6);
  rig.cycles(1, set(L::outdoor_temp, -35));  // three rows at the new level
  EXPECT_EQ(rig.decision().mode, ControlMode::run);
  EXPECT_EQ(rig.decision().fault, Fault::rate_exceeded);
  rig.cycles(1, set(L::outdoor_temp, -35));
  EXPECT_EQ(rig.decision().mode, ControlMode::learn);
}

TEST(ControllerFaults, ARefusedCommandIsNamedAndItsCycleNotLearnedFrom) {
  Rig rig;
  rig.cycles(6);
  const std::uint64_t remembered = rig.controller->replay().total_pushed();
  rig.cycles(1, {}, true);
  EXPECT_EQ(rig.decision().fault, Fault::not_applied);
  EXPECT_EQ(rig.controller->replay().total_pushed(), remembered + 1) << "the cycle before it was sound";
  rig.cycles(1);
  EXPECT_EQ(rig.controller->replay().total_pushed(), remembered + 1);
  rig.cycles(1);
  EXPECT_EQ(rig.controller->replay().total_pushed(), remembered + 2);
}

TEST(ControllerFaults, TheRoomHeadLearnsNothingAcrossAGapInTime) {
  Rig rig;
  rig.cycles(6);
  rig.now.seconds += 5 * cycle_s;  // the box was off
  const std::uint32_t updates = rig.controller->learning().head.updates();
  rig.cycles(2);  // the second ends a whole cycle, but the change before it spans the gap
  EXPECT_EQ(rig.controller->learning().head.updates(), updates);
  rig.cycles(1);
  EXPECT_EQ(rig.controller->learning().head.updates(), updates + 1);
}

TEST(ControllerFaults, WithoutWeightsTheScheduleRunsAndNothingIsWrong) {
  auto controller = std::make_unique<Controller<T>>();
  Rig rig;
  rig.controller = std::move(controller);
  rig.cycles(80);
  EXPECT_EQ(rig.decision().mode, ControlMode::expert);
  EXPECT_EQ(rig.decision().fault, Fault::none);
  EXPECT_EQ(rig.decision().command.setpoint_degc(), expert_setpoint_degc(product_settings(), rig.decision().time));
}

TEST(ControllerFaults, AForecastThatIsNoNumberYieldsTheSchedule) {
  Rig rig;
  rig.cycles(1);
  inside(*rig.controller).learning.weights.values.fill(std::numeric_limits<float>::quiet_NaN());
  rig.controller->prepare();
  ControllerSettings s = product_settings();
  rig.now.seconds += 10 * cycle_s;  // the head has no recent past to go by
  rig.row();
  EXPECT_EQ(rig.decision().mode, ControlMode::expert);
  EXPECT_EQ(rig.decision().fault, Fault::forecast_invalid);
  EXPECT_EQ(rig.decision().command.setpoint_degc(), expert_setpoint_degc(s, rig.decision().time));
}

TEST(ControllerFaults, AnInfiniteWishOfTheHeadIsNotTakenForTheEndOfTheRange) {
  Rig rig;
  rig.cycles(4);
  ASSERT_TRUE(std::isfinite(rig.decision().head_degc));
  auto& theta = inside(*rig.controller).learning.head.theta();
  theta.setZero();
  theta(HeadFeatures::setpoint_change) = 0.2;
  theta.tail<RoomHead<FiveZone>::slots * 2>().setConstant(1.7e308);  // finite, but not once it is divided by the gain
  rig.row();
  EXPECT_FALSE(std::isfinite(rig.decision().head_degc));
  EXPECT_TRUE(std::isfinite(rig.decision().network_degc)) << "which takes over";
  EXPECT_NE(rig.decision().mode, ControlMode::expert);
}

TEST(ControllerFaults, RestoredWeightsThatAreNoNumbersAreRefused) {
  Rig rig;
  rig.cycles(2);
  inside(*rig.controller).learning.weights.values[100] = std::numeric_limits<float>::infinity();
  EXPECT_EQ(restart(*rig.controller), Fault::state_invalid);
  rig.cycles(2);
  EXPECT_EQ(rig.decision().mode, ControlMode::expert);
}

}  // namespace
}  // namespace airside
