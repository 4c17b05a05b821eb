// Between which sizes an effect lies: a factor of the way from its null either way, and what the sensors leave open.

#include "tools/gap/verdict/magnitude.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace airside::tools::gap {
namespace {

constexpr double z95 = 1.96;

class MagnitudeTest : public ::testing::Test {
 protected:
  MagnitudeTest() {
    flow.name = "vav_flow";
    flow.unit = "1";
    flow.null_value = 1;
    flow.low = 0.1;
    flow.high = 2;
  }
  Finding sized(double magnitude, double sd, double share) const {
    Finding f;
    f.at = {&flow, 0};
    f.magnitude = magnitude;
    f.sd = sd;
    f.share = share;
    return f;
  }

  sim::Effect flow;
};

TEST_F(MagnitudeTest, TwinsOtherErrorsAreAFactorOfTheWayFromNull) {
  const MagnitudeInterval up = interval_of(sized(1.4, 0.3 * 0.4, 0.3));
  EXPECT_NEAR(up.low, 1 + 0.4 * std::exp(-z95 * 0.3), 1e-9);
  EXPECT_NEAR(up.high, 1 + 0.4 * std::exp(z95 * 0.3), 1e-9);
  const MagnitudeInterval down = interval_of(sized(0.6, 0.3 * 0.4, 0.3));
  EXPECT_NEAR(down.low, 1 - 0.4 * std::exp(z95 * 0.3), 1e-9);
  EXPECT_NEAR(down.high, 1 - 0.4 * std::exp(-z95 * 0.3), 1e-9);
}

TEST_F(MagnitudeTest, WhatSensorsLeaveOpenIsTheSameEitherWay) {
  const MagnitudeInterval alone = interval_of(sized(1.4, 0.1, 0));
  EXPECT_NEAR(alone.low, 1.4 - z95 * 0.1, 1e-9);
  EXPECT_NEAR(alone.high, 1.4 + z95 * 0.1, 1e-9);
  const MagnitudeInterval both = interval_of(sized(1.4, std::hypot(0.1, 0.3 * 0.4), 0.3));
  EXPECT_NEAR(1.4 - both.low, std::hypot(z95 * 0.1, 0.4 * (1 - std::exp(-z95 * 0.3))), 1e-9);
  EXPECT_NEAR(both.high - 1.4, std::hypot(z95 * 0.1, 0.4 * (std::exp(z95 * 0.3) - 1)), 1e-9);
}

TEST_F(MagnitudeTest, IntervalsEndAtTheEffectsBounds) {
  const MagnitudeInterval wide = interval_of(sized(1.8, 2, 0.3));
  EXPECT_EQ(wide.low, flow.low);
  EXPECT_EQ(wide.high, flow.high);
}

TEST_F(MagnitudeTest, TextHasBothEndsAndTheUnit) {
  EXPECT_EQ(magnitude_text(sized(0.6, 0.12, 0.3)), "factor 0.6 (0.28 to 0.778)");
  sim::Effect bias = flow;
  bias.unit = "K";
  bias.null_value = 0;
  bias.low = -3;
  bias.high = 3;
  Alternative a;
  a.at = {&bias, 0};
  a.magnitude = -1;
  a.sd = 0.2;
  EXPECT_EQ(magnitude_text(a), "-1 K (-1.39 to -0.608)");
}

}  // namespace
}  // namespace airside::tools::gap
