// Recursive least squares with a prior.

#include <gtest/gtest.h>

#include "airside/demand/recursive_least_squares.hpp"
#include "airside/splitmix64.hpp"

namespace {

using airside::RecursiveLeastSquares;

TEST(RecursiveLeastSquares, FindsTheCoefficientsOfALaw) {
  RecursiveLeastSquares<3> law;
  law.reset({0, 0, 0}, {10, 10, 10});
  airside::SplitMix64 random(1);
  const auto uniform = [&] { return static_cast<double>(random.next() >> 11) / 9007199254740992.0; };
  for (int i = 0; i < 500; ++i) {
    const double a = uniform(), b = uniform();
    law.update({1, a, b}, 2 + 3 * a - 1 * b + 0.1 * (uniform() - 0.5), 0.05);
  }
  EXPECT_NEAR(law.theta()[0], 2, 0.03);
  EXPECT_NEAR(law.theta()[1], 3, 0.03);
  EXPECT_NEAR(law.theta()[2], -1, 0.03);
}

TEST(RecursiveLeastSquares, WhatIsNeverSeenIsNeitherSurerNorLessSureThanThePrior) {
  RecursiveLeastSquares<2> law;
  law.reset({1, 5}, {2, 3});
  for (int i = 0; i < 1000; ++i) {
    law.update({1, 0}, 1, 0.1);
    law.forget(0.01);
  }
  EXPECT_NEAR(law.theta()[1], 5, 1e-9);
  EXPECT_NEAR(law.sd({0, 1}), 3, 1e-6);
  EXPECT_LT(law.sd({1, 0}), 0.5);
}

TEST(RecursiveLeastSquares, AnInputThatIsNoNumberChangesNothing) {
  RecursiveLeastSquares<2> law;
  law.reset({1, 5}, {2, 3});
  EXPECT_TRUE(std::isnan(law.update({1, 1}, std::nan(""), 0.1)));
  EXPECT_TRUE(std::isnan(law.update({1, std::nan("")}, 1, 0.1)));
  EXPECT_EQ(law.theta()[0], 1);
  EXPECT_TRUE(law.finite());
}

TEST(RecursiveLeastSquares, ABoundTakesTheOtherCoefficientsAlong) {
  RecursiveLeastSquares<2> law;
  law.reset({0, 0}, {1, 1});
  for (int i = 0; i < 50; ++i) law.update({1, 1}, 1, 0.01);  // only the sum is known
  law.bound(0, 0.9, 2);
  EXPECT_NEAR(law.theta()[0], 0.9, 1e-12);
  EXPECT_NEAR(law.theta()[0] + law.theta()[1], 1, 1e-3);
}

TEST(RecursiveLeastSquares, AnOutlierMovesNoFurtherThanThreeDeviations) {
  RecursiveLeastSquares<1> law, same;
  law.reset({0}, {1});
  same.reset({0}, {1});
  law.update({1}, 1e9, 1);
  same.update({1}, 3 * std::sqrt(2.0), 1);
  EXPECT_NEAR(law.theta()[0], same.theta()[0], 1e-12);
}

}  // namespace
