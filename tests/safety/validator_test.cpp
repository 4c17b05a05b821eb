// Each rule of the validator, both ways: what must be refused is, and what is sound passes.

#include "airside/supervision/validation.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace airside {
namespace {

using T = FiveZone;
using L = Layout<T>;

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

LimitsTable<T> table() {
  LimitsTable<T> limits = default_limits<T>();
  for (auto& l : limits) l.stale_s = 1000;
  return limits;
}

/// A sound reading; every value moves a little each row, as sensors do.
Reading<T> reading(int row, double room_degc = 25.0) {
  Reading<T> r;
  r.time = {1'000'000'800 + row * row_s};
  r.value.setZero();
  for (int i = 0; i < L::rooms; ++i) r.value(i) = room_degc + 0.1 * i + 0.01 * (row % 2);
  for (int i = 0; i < T::fcus; ++i) r.value(L::fcu_temp + i) = 25.5;
  for (int i = 0; i < T::powers; ++i) r.value(L::power + i) = 3.0;
  r.value(L::mau_temp) = 18;
  r.value(L::outdoor_temp) = 30;
  return r;
}

class ValidatorTest : public ::testing::Test {
 protected:
  Validator<T> validator{table()};
  int row = 0;

  /// Feeds `rows` sound rows.
  void settle(int rows) {
    for (int i = 0; i < rows; ++i, ++row) {
      const auto ok = validator.check(reading(row));
      ASSERT_TRUE(ok) << text_of(ok.error());
      ASSERT_TRUE(ok->learnable());
    }
  }
  /// Checks the next row with `signal` at `value`; returns whether it was held, or the fault.
  Expected<ValidReading<T>> next(int signal, double value, double age_s = 0) {
    Reading<T> r = reading(row++);
    r.value(signal) = value;
    r.age_s(signal) = age_s;
    return validator.check(r);
  }
};

TEST_F(ValidatorTest, PassesASoundReadingWhole) {
  settle(5);
  const auto ok = validator.check(reading(row));
  ASSERT_TRUE(ok);
  EXPECT_EQ(ok->value(), reading(row).value);
  EXPECT_EQ(ok->held(), 0);
  EXPECT_EQ(ok->time().seconds, reading(row).time.seconds);
}

TEST_F(ValidatorTest, RefusesAFirstReadingThatIsNoNumber) {
  for (int signal = 0; signal < L::signals; ++signal) {
    Validator<T> fresh(table());
    Reading<T> r = reading(0);
    r.value(signal) = nan;
    const auto refused = fresh.check(r);
    ASSERT_FALSE(refused) << signal;
    EXPECT_EQ(refused.error(), Fault::not_finite);
    EXPECT_EQ(fresh.lost_signal(), signal);
  }
}

TEST_F(ValidatorTest, HoldsALostValueForHoldTimeAndNotLonger) {
  settle(3);
  for (int lost = 1; lost <= 3; ++lost) {
    const auto held = next(2, nan);
    ASSERT_TRUE(held) << lost;
    EXPECT_FALSE(held->learnable());
    EXPECT_EQ(held->held(), 1);
    EXPECT_EQ(held->value()(2), reading(2).value(2));
  }
  const auto gone = next(2, nan);  // 1,440 s after the last good one
  ASSERT_FALSE(gone);
  EXPECT_EQ(gone.error(), Fault::not_finite);
  EXPECT_EQ(validator.lost_signal(), 2);
  const auto back = next(2, 25.2);
  ASSERT_TRUE(back);
  EXPECT_TRUE(back->learnable());
}

TEST_F(ValidatorTest, HoldsNothingOnceTheClockWasSetBack) {
  settle(3);
  Reading<T> r = reading(-100);
  r.value(0) = nan;
  EXPECT_FALSE(validator.check(r));
}

TEST_F(ValidatorTest, RefusesBothEndsOfTheRangeAndPassesTheEndsThemselves) {
  for (const double bad : {4.99, 50.01, -300.0, 1e9, std::numeric_limits<double>::infinity()}) {
    Validator<T> fresh(table());
    Reading<T> r = reading(0);
    r.value(L::fcu_temp) = bad;
    EXPECT_FALSE(fresh.check(r)) << bad;
  }
  for (const double good : {5.0, 50.0}) {
    Validator<T> fresh(table());
    Reading<T> r = reading(0);
    r.value(L::fcu_temp) = good;
    EXPECT_TRUE(fresh.check(r)) << good;
  }
}

TEST_F(ValidatorTest, RefusesAStatusThatIsNone) {
  settle(1);
  const auto odd = next(L::vav_on, 2);
  ASSERT_TRUE(odd);
  EXPECT_EQ(validator.faults()[static_cast<std::size_t>(L::vav_on)], Fault::out_of_range);
}

TEST_F(ValidatorTest, PassesAFastStepWithinTheRateAndHoldsAFasterOne) {
  settle(3);
  ASSERT_TRUE(next(0, reading(2).value(0) + 5.9)->learnable()) << "6 min at 1 K/min";
  const auto jump = next(1, reading(2).value(1) + 6.5);
  ASSERT_TRUE(jump);
  EXPECT_FALSE(jump->learnable());
  EXPECT_EQ(validator.faults()[1], Fault::rate_exceeded);
}

TEST_F(ValidatorTest, BelievesAJumpOnlyAtTheThirdSampleInARow) {
  settle(3);
  // 20 K is more than the rate allows even over three rows.
  EXPECT_FALSE(next(L::fcu_temp, 45.0)->learnable());
  EXPECT_FALSE(next(L::fcu_temp, 45.1)->learnable());
  const auto third = next(L::fcu_temp, 45.0);
  ASSERT_TRUE(third);
  EXPECT_TRUE(third->learnable());
  EXPECT_EQ(third->value()(L::fcu_temp), 45.0);
}

TEST_F(ValidatorTest, AGapInTheJumpBeginsTheCountAnew) {
  settle(3);
  EXPECT_FALSE(next(0, 50.0)->learnable());
  EXPECT_FALSE(next(0, nan)->learnable());
  EXPECT_FALSE(next(0, 50.0)->learnable());
  const auto fourth = next(0, 50.0);
  EXPECT_FALSE(fourth && fourth->learnable());
}

TEST_F(ValidatorTest, ScatteredJumpsNeverConfirmOneAnother) {
  settle(3);
  for (const double v : {48.0, 6.0, 48.0}) {
    const auto wild = next(0, v);
    EXPECT_FALSE(wild && wild->learnable());
  }
}

TEST_F(ValidatorTest, HoldsAStaleValueAndPassesAFreshOne) {
  settle(3);
  EXPECT_TRUE(next(3, 25.3, 1000)->learnable());
  EXPECT_FALSE(next(3, 25.3, 1001)->learnable());
  EXPECT_EQ(validator.faults()[3], Fault::stale);
  EXPECT_FALSE(next(3, 25.3, nan)->learnable()) << "an unknown age is no fresh one";
}

/// Rows of room 2 standing at 25.2 while the others swing by `swing_k`.
int rows_until_stuck(Validator<T>& validator, double swing_k, int rows) {
  for (int row = 0; row < rows; ++row) {
    Reading<T> r = reading(row);
    for (int i = 0; i < L::rooms; ++i) r.value(i) = 25.0 + 0.1 * i + swing_k * std::sin(0.05 * row);
    r.value(2) = 25.2;
    const auto seen = validator.check(r);
    if (validator.faults()[2] == Fault::stuck) return row;
    EXPECT_TRUE(seen);
  }
  return -1;
}

TEST_F(ValidatorTest, CallsASensorStuckOnlyWhereItsPeersMove) {
  Validator<T> moving(table()), resting(table());
  const int found = rows_until_stuck(moving, 1.0, 200);
  EXPECT_GT(found, 60) << "not before six hours";
  EXPECT_LT(found, 90);
  EXPECT_EQ(rows_until_stuck(resting, 0.1, 400), -1);
}

TEST_F(ValidatorTest, FindsAStuckSensorAlsoAfterTheClockWasSetBack) {
  Validator<T> moving(table()), resting(table());
  for (Validator<T>* v : {&moving, &resting}) ASSERT_TRUE(v->check(reading(10000)));
  const int found = rows_until_stuck(moving, 1.0, 200);
  EXPECT_GT(found, 60);
  EXPECT_LT(found, 90);
  EXPECT_EQ(rows_until_stuck(resting, 0.1, 400), -1);
}

TEST_F(ValidatorTest, AStuckSensorIsLostUntilItMoves) {
  Validator<T> v(table());
  const int found = rows_until_stuck(v, 1.0, 200);
  ASSERT_GT(found, 0);
  int lost = 0;
  for (int k = found + 1; k < found + 200; ++k) {  // peers move on, and their window begins anew three times
    Reading<T> r = reading(k);
    for (int i = 0; i < L::rooms; ++i) r.value(i) = 25.0 + 0.1 * i + std::sin(0.05 * k);
    r.value(2) = 25.2;
    lost += v.check(r) ? 0 : 1;
    EXPECT_EQ(v.faults()[2], Fault::stuck) << k - found;
  }
  EXPECT_GT(lost, 190);
  Reading<T> r = reading(found + 200);
  r.value(2) = 25.4;
  EXPECT_TRUE(v.check(r));
  EXPECT_EQ(v.faults()[2], Fault::none);
}

/// Room 0 at `degc` for long enough that the jump is believed. Returns the last check.
Expected<ValidReading<T>> one_room_at(Validator<T>& validator, double degc, int second_room = -1) {
  Expected<ValidReading<T>> seen = tl::unexpected(Fault::no_reading);
  for (int row = 0; row < 6; ++row) {
    Reading<T> r = reading(row);
    r.value(0) = degc + 0.01 * (row % 2);
    if (second_room >= 0) r.value(second_room) = degc;
    seen = validator.check(r);
  }
  return seen;
}

TEST_F(ValidatorTest, TakesTheMedianForOneRoomFarFromAllOthers) {
  const auto seen = one_room_at(validator, 38.0);
  ASSERT_TRUE(seen);
  EXPECT_FALSE(seen->learnable());
  EXPECT_EQ(validator.faults()[0], Fault::disagrees);
  EXPECT_NEAR(seen->value()(0), 25.3, 0.02) << "of 25.1, 25.2, 25.3, 25.4 and the hot one";
}

TEST_F(ValidatorTest, LeavesARoomThatIsOnlyWarmAlone) {
  const auto seen = one_room_at(validator, 31.0);
  ASSERT_TRUE(seen);
  EXPECT_TRUE(seen->learnable()) << "6 K is what a closed box does";
}

TEST_F(ValidatorTest, BelievesNobodyWhereTwoRoomsDisagree) {
  const auto seen = one_room_at(validator, 38.0, 3);
  ASSERT_FALSE(seen);
  EXPECT_EQ(seen.error(), Fault::disagrees);
}

TEST_F(ValidatorTest, RefusesADeviceThatRepeatsEveryDigitForAnHour) {
  Reading<T> r = reading(0);
  int row_of_refusal = -1;
  for (int i = 0; i < 20 && row_of_refusal < 0; ++i) {
    r.time = reading(i).time;
    const auto seen = validator.check(r);
    if (seen) continue;
    row_of_refusal = i;
    EXPECT_EQ(seen.error(), Fault::frozen);
  }
  EXPECT_EQ(row_of_refusal, 11) << "the first row after more than 3600 s";
  r.value(1) += 0.01;
  r.time.seconds += row_s;
  EXPECT_TRUE(validator.check(r)) << "one digit that moves is life enough";
}

TEST_F(ValidatorTest, CallsNoDeviceFrozenInWhichOneSignalMoves) { settle(50); }

TEST_F(ValidatorTest, FindsNoMedianAmongTwoGoodRooms) {
  settle(3);
  Reading<T> r = reading(row++);
  for (int i = 0; i < 3; ++i) r.value(i) = nan;
  r.value(3) = 27.0;
  const auto seen = validator.check(r);
  ASSERT_TRUE(seen) << "nobody can say which of two is wrong";
  EXPECT_EQ(seen->held(), 3);
  EXPECT_EQ(validator.faults()[3], Fault::none);
}

TEST_F(ValidatorTest, CountsAFrozenDeviceAnewWhereTheClockWasSetBack) {
  Reading<T> r = reading(0);
  for (int i = 0; i < 10; ++i, r.time.seconds += row_s) EXPECT_TRUE(validator.check(r));
  r.time = reading(-50).time;
  for (int i = 0; i < 10; ++i, r.time.seconds += row_s) EXPECT_TRUE(validator.check(r)) << i;
  EXPECT_TRUE(validator.check(r));
  r.time.seconds += row_s;
  EXPECT_EQ(validator.check(r).error(), Fault::frozen);
}

TEST_F(ValidatorTest, NamesTheFirstOfSeveralLostSignals) {
  Reading<T> r = reading(0);
  r.value(2) = nan;
  r.value(4) = 1e9;
  EXPECT_EQ(validator.check(r).error(), Fault::not_finite);
  EXPECT_EQ(validator.lost_signal(), 2);
}

}  // namespace
}  // namespace airside
