// How confidence grows and falls (docs/method.md 6.2), and what it makes of two setpoints.

#include "airside/supervision/confidence.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "airside/presets.hpp"

namespace airside {
namespace {

TEST(Confidence, IsTheFormula) {
  ControllerSettings s = paper_settings();
  s.confidence_smoothing = 0.3;
  s.confidence_scale = 2.0;
  EXPECT_NEAR(confidence_step(s, 0.6, 0.5), 0.3 * std::exp(-0.25) + 0.7 * 0.6, 1e-15);
}

TEST(Confidence, GrowsToOneWhileForecastsComeTrue) {
  const ControllerSettings s = paper_settings();
  double c = s.confidence_initial;
  for (int night_cycle = 0; night_cycle < 23; ++night_cycle) c = confidence_step(s, c, 0.0);
  EXPECT_GT(c, 0.98) << "docs/method.md 6.2: before work begins on the first day";
  EXPECT_LT(c, 1.0);
}

TEST(Confidence, FallsAfterASurpriseAndNeverBelowZero) {
  const ControllerSettings s = paper_settings();
  double c = 1.0;
  c = confidence_step(s, c, 50.0);
  EXPECT_NEAR(c, 0.8, 1e-12);
  for (int i = 0; i < 200; ++i) c = confidence_step(s, c, 1e300);
  EXPECT_GE(c, 0.0);
  EXPECT_LT(c, 1e-15);
}

TEST(Confidence, TakesALossThatIsNoNumberForACompleteSurprise) {
  const ControllerSettings s = paper_settings();
  for (const double loss : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
                            -std::numeric_limits<double>::infinity()}) {
    EXPECT_NEAR(confidence_step(s, 0.5, loss), 0.4, 1e-12);
  }
}

TEST(Confidence, LeavesNoOffsetOnceFull) {
  ControllerSettings s = paper_settings();
  EXPECT_NEAR(effective_confidence(s, 0.95), 0.95, 1e-15);
  s.confidence_full = 0.9;
  EXPECT_EQ(effective_confidence(s, 0.95), 1.0);
  EXPECT_EQ(effective_confidence(s, 0.9), 1.0);
  EXPECT_NEAR(effective_confidence(s, 0.45), 0.5, 1e-15);
}

TEST(Confidence, WeighsAgentAndExpert) {
  EXPECT_EQ(fuse(1.0, 23.4, 20.5), 23.4);
  EXPECT_EQ(fuse(0.0, 23.4, 20.5), 20.5);
  EXPECT_NEAR(fuse(0.25, 24.5, 20.5), 21.5, 1e-12);
}

}  // namespace
}  // namespace airside
