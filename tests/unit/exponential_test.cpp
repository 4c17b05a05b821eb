#include "airside/exponential.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace airside {
namespace {

double units_in_last_place(double value, double truth) {
  return std::abs(value - truth) / (std::nextafter(truth, HUGE_VAL) - truth);
}

TEST(FixedExponential, IsTheCLibrarysToTheLastBits) {
  double worst = 0;
  for (int i = -700000; i <= 700000; i += 7) {
    const double x = i / 1000.0;
    worst = std::max(worst, units_in_last_place(fixed_exponential(x), std::exp(x)));
  }
  EXPECT_LE(worst, 2.0);
  for (int i = -20000; i <= 0; ++i) {  // where confidence and the head's prior use it
    const double x = i / 1000.0;
    ASSERT_LE(units_in_last_place(fixed_exponential(x), std::exp(x)), 2.0) << x;
  }
}

TEST(FixedExponential, GivesTheseBitsOnEveryMachine) {
  EXPECT_EQ(fixed_exponential(0), 1);
  EXPECT_EQ(fixed_exponential(-0.25), 0x1.8ebef9eac820bp-1);
  EXPECT_EQ(fixed_exponential(-1), 0x1.78b56362cef38p-2);
  EXPECT_EQ(fixed_exponential(-13.7), 0x1.2d4ded4836777p-20);
}

TEST(FixedExponential, EndsInZeroInfinityAndNotANumber) {
  EXPECT_EQ(fixed_exponential(-709), 0.0);
  EXPECT_EQ(fixed_exponential(-HUGE_VAL), 0.0);
  EXPECT_EQ(fixed_exponential(710), HUGE_VAL);
  EXPECT_TRUE(std::isnan(fixed_exponential(std::nan(""))));
}

}  // namespace
}  // namespace airside
