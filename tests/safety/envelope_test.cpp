// The last gate before the actuator: both halves of each rule, and every double there is.

#include "airside/supervision/envelope.hpp"

#include <gtest/gtest.h>
#include <rapidcheck.h>

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <limits>

#include "airside/presets.hpp"

namespace airside {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double inf = std::numeric_limits<double>::infinity();

ControllerSettings limits(double change_k = 2.0) {
  ControllerSettings s;
  s.limit_min_degc = 18;
  s.limit_max_degc = 27;
  s.limit_change_k = change_k;
  return s;
}

double limited(double proposal, double last, double fallback = 25, double change_k = 2.0) {
  return SafetyEnvelope(limits(change_k)).limit(proposal, last, fallback).setpoint_degc();
}

TEST(SafetyEnvelope, LetsASafeProposalThrough) { EXPECT_NEAR(limited(22.37, 22), 22.37, 1e-12); }

TEST(SafetyEnvelope, HoldsLimitWhenProposalIsColder) { EXPECT_EQ(limited(10, 19), 18); }
TEST(SafetyEnvelope, HoldsLimitWhenProposalIsWarmer) { EXPECT_EQ(limited(40, 26), 27); }

TEST(SafetyEnvelope, HoldsRateDownwards) { EXPECT_NEAR(limited(19, 24), 22, 1e-12); }
TEST(SafetyEnvelope, HoldsRateUpwards) { EXPECT_NEAR(limited(26, 21), 23, 1e-12); }
TEST(SafetyEnvelope, AllowsAFullStepButNoMore) {
  EXPECT_NEAR(limited(22, 24), 22, 1e-12);
  EXPECT_NEAR(limited(21.99, 24), 22, 1e-12);
}

TEST(SafetyEnvelope, KnowsNoRateWhereTheLastSetpointIsUnknown) {
  EXPECT_EQ(limited(19, nan), 19);
  EXPECT_EQ(limited(19, inf), 19);
}

TEST(SafetyEnvelope, KeepsWithinOneStepOfWhateverMayStandAfterAWriteOfUnknownFate) {
  const SafetyEnvelope envelope(limits(2.0));
  StoredSetpoint standing;
  EXPECT_EQ(envelope.limit(19, standing, 25).setpoint_degc(), 19) << "nothing is known yet";
  standing.is(22);
  standing.may_be(23.5);
  EXPECT_NEAR(envelope.limit(26, standing, 25).setpoint_degc(), 24, 1e-12);
  EXPECT_NEAR(envelope.limit(19, standing, 25).setpoint_degc(), 21.5, 1e-12);
  for (int i = 0; i < 50; ++i) standing.may_be(envelope.limit(i % 2 == 0 ? 18 : 27, standing, 25).setpoint_degc());
  EXPECT_LE(standing.high_degc - standing.low_degc, 2.0 + 1e-12) << "and never closes in on nothing";
  standing.is(25);
  EXPECT_NEAR(envelope.limit(26, standing, 25).setpoint_degc(), 26, 1e-12) << "one reading ends the doubt";
  StoredSetpoint first_write;
  first_write.may_be(20);
  EXPECT_NEAR(envelope.limit(26, first_write, 25).setpoint_degc(), 22, 1e-12);
}

TEST(SafetyEnvelope, KnowsNoRateWhereOneEndOfTheRangeIsNoNumber) {
  const ControllerSettings s = product_settings();
  const double unknown = std::numeric_limits<double>::quiet_NaN();
  const SafetyEnvelope envelope(s);
  EXPECT_EQ(envelope.limit(s.limit_min_degc, StoredSetpoint{s.limit_max_degc, unknown}, 22).setpoint_degc(),
            s.limit_min_degc);
  EXPECT_EQ(envelope.limit(s.limit_min_degc, StoredSetpoint{unknown, s.limit_max_degc}, 22).setpoint_degc(),
            s.limit_min_degc);
}

TEST(SafetyEnvelope, MovesByOneStepFromASetpointFoundOutsideUntilItIsInside) {
  EXPECT_NEAR(limited(20, 40), 38, 1e-12);
  EXPECT_NEAR(limited(26, 5), 7, 1e-12);
  EXPECT_NEAR(limited(21.5, 8.8, 25, 6), 14.8, 1e-12);
  EXPECT_NEAR(limited(21.5, 14.8, 25, 6), 20.8, 1e-12);
  EXPECT_NEAR(limited(21.5, 27.3, 25, 6), 21.5, 1e-12) << "inside within one step";
  EXPECT_NEAR(limited(20, 27.3, 25, 6), 21.3, 1e-12) << "a step from what is stored, not from the limit";
  EXPECT_NEAR(limited(nan, 8.8, nan, 6), 14.8, 1e-12) << "whatever is proposed";
  double found = 1;
  int cycles = 0;
  for (; found < 18; ++cycles) found = limited(25, found, 25, 2);
  EXPECT_EQ(cycles, 9) << "1 to 19 degC";
}

TEST(SafetyEnvelope, JumpsInsideWhereTheSiteSaysSo) {
  ControllerSettings s = limits(2.0);
  s.outside_jump = 1;
  EXPECT_EQ(SafetyEnvelope(s).limit(20, 40, 25).setpoint_degc(), 25) << "a step from the nearer limit";
  EXPECT_EQ(SafetyEnvelope(s).limit(26, 5, 25).setpoint_degc(), 20);
}

TEST(SafetyEnvelope, FollowsWhateverMayBeStoredOutsideTheLimits) {
  const SafetyEnvelope envelope(limits(6.0));
  StoredSetpoint standing;
  standing.is(8.8);
  standing.may_be(14.8);
  EXPECT_NEAR(envelope.limit(22, standing, 25).setpoint_degc(), 14.8, 1e-12) << "a step from the farther end";
  standing.is(17);
  standing.may_be(20);
  EXPECT_NEAR(envelope.limit(15, standing, 25).setpoint_degc(), 18, 1e-12);
  EXPECT_NEAR(envelope.limit(26, standing, 25).setpoint_degc(), 23, 1e-12);
}

TEST(SafetyEnvelope, TakesTheFallbackForAProposalThatIsNoNumber) {
  for (const double bad : {nan, inf, -inf}) {
    EXPECT_EQ(limited(bad, 24, 25), 25);
    EXPECT_EQ(limited(bad, 20, 25), 22) << "the fallback keeps the rate too";
    EXPECT_EQ(limited(bad, 21, nan), 21) << "without a fallback the last setpoint stays";
    EXPECT_EQ(limited(bad, nan, nan), 27) << "and without any the warm limit";
  }
}

TEST(SafetyEnvelope, RoundsToTheRegistersStep) { EXPECT_NEAR(limited(22.3749, 22), 22.37, 1e-12); }

TEST(SafetyEnvelope, RoundsTowardsTheInsideOfALimit) {
  ControllerSettings s = limits(0.25);
  s.round_k = 0.1;
  const SafetyEnvelope envelope(s);
  EXPECT_NEAR(envelope.limit(27, 22, 25).setpoint_degc(), 22.2, 1e-12) << "22.25 would round to 22.3, more than a step";
  EXPECT_NEAR(envelope.limit(18, 22, 25).setpoint_degc(), 21.8, 1e-12);
  s.limit_min_degc = 18.05;
  s.limit_max_degc = 26.95;
  EXPECT_GE(SafetyEnvelope(s).limit(1, nan, 25).setpoint_degc(), 18.05);
  EXPECT_LE(SafetyEnvelope(s).limit(99, nan, 25).setpoint_degc(), 26.95);
}

TEST(SafetyEnvelope, WritesOnlyWhatTheRegisterHoldsAndThatWithinTheLimits) {
  ControllerSettings s = product_settings();
  s.limit_min_degc = 20.4;
  s.limit_max_degc = 24.6;
  s.register_step_k = 1;
  const SafetyEnvelope whole_degrees(s);
  EXPECT_EQ(whole_degrees.limit(24.6, nan, 22).setpoint_degc(), 24);
  EXPECT_EQ(whole_degrees.limit(20.4, nan, 22).setpoint_degc(), 21);
  EXPECT_EQ(whole_degrees.limit(22.6, 22, 22).setpoint_degc(), 23);
  s.limit_change_k = 0.7;
  EXPECT_EQ(SafetyEnvelope(s).limit(20.4, 20, 22).setpoint_degc(), 21) << "the register's first within the limits";
  EXPECT_EQ(SafetyEnvelope(s).limit(20.4, 9, 22).setpoint_degc(), 10) << "in a step of the register's where it must be";
  s.limit_change_k = 1.5;
  EXPECT_EQ(SafetyEnvelope(s).limit(22, 9.2, 22).setpoint_degc(), 10);
  EXPECT_EQ(SafetyEnvelope(s).limit(22, 27.7, 22).setpoint_degc(), 27);
  s.limit_change_k = 0.3;
  EXPECT_EQ(SafetyEnvelope(s).limit(24, 22.5, 22).setpoint_degc(), 23)
      << "the next that it holds, where none is nearer";
  s.limit_change_k = 0.7;
  s.register_step_k = 1 / 1.8;  // degF
  s.register_offset_degc = -32 / 1.8;
  s.limit_max_degc = 26;
  EXPECT_NEAR(SafetyEnvelope(s).limit(26, nan, 22).setpoint_degc(), (78 - 32) / 1.8, 1e-9) << "79 degF is 26.11 degC";
  s.limit_max_degc = 25;  // 77 degF, but for the last bits
  EXPECT_NEAR(SafetyEnvelope(s).limit(26, nan, 22).setpoint_degc(), 25, 1e-9);
}

TEST(SafetyEnvelope, StaysWithinTheLimitsThoughTheRegisterHoldsNothingThere) {
  ControllerSettings s = limits(6);
  s.register_step_k = 50;
  EXPECT_EQ(SafetyEnvelope(s).limit(22, 5, 22).setpoint_degc(), 27);
  EXPECT_EQ(SafetyEnvelope(s).limit(22, 60, 22).setpoint_degc(), 50) << "nearer by a step of the register's";
  EXPECT_EQ(SafetyEnvelope(s).limit(22, 45, 22).setpoint_degc(), 18);
}

TEST(SafetyEnvelope, NamesItsLimits) {
  const SafetyEnvelope envelope(limits(2.0));
  EXPECT_EQ(envelope.min_degc(), 18);
  EXPECT_EQ(envelope.max_degc(), 27);
  EXPECT_EQ(envelope.change_k(), 2);
}

/// Any bit pattern as a double, temperatures more often than chance has it.
rc::Gen<double> any_double() {
  return rc::gen::oneOf(
      rc::gen::map(rc::gen::arbitrary<std::uint64_t>(), [](std::uint64_t b) { return std::bit_cast<double>(b); }),
      rc::gen::map(rc::gen::inRange(-1000, 6000), [](int c) { return c / 100.0; }),
      rc::gen::element(nan, inf, -inf, 0.0, -0.0, 18.0, 27.0, 1e308, -1e308, 5e-324));
}

TEST(SafetyEnvelope, EveryTripleOfDoublesGivesAFiniteSetpointInLimitsOrNearerToThemWithinOneStep) {
  ::setenv("RC_PARAMS", "seed=20210801 max_success=20000", 0);  // the environment may ask for more
  const bool held = rc::check("finite, in limits, one step", [] {
    ControllerSettings s;
    s.limit_min_degc = *rc::gen::inRange(0, 5000) / 100.0;
    s.limit_max_degc = s.limit_min_degc + *rc::gen::inRange(1, 3000) / 100.0;
    s.limit_change_k = *rc::gen::inRange(1, 1000) / 100.0;
    s.round_k = *rc::gen::element(0.001, 0.01, 0.05, 0.1, 0.5, 1.0);
    const double coarse = *rc::gen::element(0.0, 0.0, 0.01, 0.1, 0.5, 1 / 1.8, 1.0);
    if (coarse <= std::min(s.limit_change_k, (s.limit_max_degc - s.limit_min_degc) / 2)) s.register_step_k = coarse;
    s.register_offset_degc = *rc::gen::element(0.0, -32 / 1.8, 0.25);
    s.outside_jump = *rc::gen::inRange(0, 2);
    const double proposal = *any_double(), last = *any_double(), fallback = *any_double();
    const double a = SafetyEnvelope(s).limit(proposal, last, fallback).setpoint_degc();
    RC_ASSERT(std::isfinite(a));
    const bool below = a<s.limit_min_degc, above = a> s.limit_max_degc;
    if (below) RC_ASSERT(s.outside_jump == 0 && last < a);
    if (above) RC_ASSERT(s.outside_jump == 0 && last > a);
    if (s.register_step_k > 0) {
      const double n = (a - s.register_offset_degc) / s.register_step_k;
      RC_ASSERT(std::abs(n - std::round(n)) < 1e-6);
    }
    if (std::isfinite(last)) {
      const double from = s.outside_jump != 0 ? std::clamp(last, s.limit_min_degc, s.limit_max_degc) : last;
      const bool is_huge = std::abs(from) > 1e6;  // where a step is less than the resolution of a double
      if (!is_huge) RC_ASSERT(std::abs(a - from) <= s.limit_change_k + 1e-9);
    }
  });
  EXPECT_TRUE(held);
}

}  // namespace
}  // namespace airside
