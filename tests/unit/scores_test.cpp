// The law of the score (docs/method.md 6.1): what it prefers follows from its two weights alone; and the rule for ties.

#include "airside/forecast/scores.hpp"
#include "airside/forecast/candidate_record.hpp"
#include "airside/presets.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

namespace airside {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();

/// Long-term room temperature of the best candidate, where candidate k leads to `first + k * step`.
double preferred(double alpha, double beta, double room_degc, double last_degc = 23) {
  ControllerSettings s = paper_settings();
  s.score_alpha = alpha;
  s.score_beta = beta;
  std::vector<double> candidates, outcomes, scores;
  for (int k = 0; k <= 60; ++k) {
    candidates.push_back(20 + 0.1 * k);
    outcomes.push_back(24 + 0.05 * k);  // 24 .. 27: room and target lie on this grid
    scores.push_back(setpoint_score(s, room_degc, outcomes.back(), 0));
  }
  const int best = best_candidate(s, scores, candidates, last_degc);
  return outcomes[static_cast<std::size_t>(best)];
}

TEST(ScoreLaw, GoesToTheTargetWhereTheTargetWeighsMore) {
  for (const double room : {24.25, 24.9, 25.25, 25.6, 26.5}) {
    EXPECT_NEAR(preferred(1.0, 0.9, room), 25.25, 1e-9) << room;
    EXPECT_NEAR(preferred(1.0, 0.0, room), 25.25, 1e-9) << room;
  }
}

TEST(ScoreLaw, HoldsTheRoomWhereRestWeighsMore) {
  for (const double room : {24.25, 24.9, 25.6, 26.5}) {
    EXPECT_NEAR(preferred(0.75, 0.9, room), room, 1e-9);
    EXPECT_NEAR(preferred(1.0, 1.1, room), room, 1e-9);
  }
}

TEST(ScoreLaw, TiesBetweenRoomAndTargetWhereBothWeighTheSame) {
  // Every outcome between ties, so the one nearest to the last setpoint is kept: 23.0 leads to 25.5.
  EXPECT_NEAR(preferred(1.0, 1.0, 26.0, 23.0), 25.5, 1e-9);
  // The last setpoint leads past the tie's end: the nearer end is taken.
  EXPECT_NEAR(preferred(1.0, 1.0, 26.0, 20.0), 25.25, 1e-9);
  EXPECT_NEAR(preferred(1.0, 1.0, 26.0, 26.0), 26.0, 1e-9);
}

TEST(ScoreLaw, TakesTheNearestReachableWhereTheTargetIsOutOfReach) {
  ControllerSettings s = paper_settings();
  const std::vector<double> candidates = {20, 21, 22}, outcomes = {26.5, 26.8, 27.0};
  std::vector<double> scores;
  for (const double o : outcomes) scores.push_back(setpoint_score(s, 27.5, o, 0));
  EXPECT_EQ(best_candidate(s, scores, candidates, 25), 0);
}

TEST(ScoreLaw, IsTheFormula) {
  ControllerSettings s = paper_settings();
  s.score_alpha = 0.8;
  s.score_beta = 0.3;
  s.move_penalty = 0.1;
  EXPECT_NEAR(setpoint_score(s, 26.0, 25.0, 2.0), 0.75 - 0.8 * 0.25 - 0.3 * 1.0 - 0.1 * 4.0, 1e-12);
}

TEST(TieRule, PrefersTheNearestToTheLastSetpointThenTheLower) {
  const ControllerSettings s = paper_settings();
  const std::vector<double> candidates = {20, 21, 22, 23};
  const std::vector<double> all_same(4, -1.0);
  EXPECT_EQ(best_candidate(s, all_same, candidates, 22.2), 2);
  EXPECT_EQ(best_candidate(s, all_same, candidates, 21.5), 1) << "as near as 22, and lower";
  EXPECT_EQ(best_candidate(s, all_same, candidates, 99), 3);
  EXPECT_EQ(best_candidate(s, all_same, {candidates.data(), 4}, nan), 3) << "unknown: the middle of the range, 23";
}

TEST(TieRule, CountsOnlyScoresWithinAMillionth) {
  const ControllerSettings s = paper_settings();
  const std::vector<double> candidates = {20, 21, 22};
  EXPECT_EQ(best_candidate(s, std::vector<double>{-1.0, -1.0 - 0.9e-6, -2}, candidates, 21), 1);
  EXPECT_EQ(best_candidate(s, std::vector<double>{-1.0, -1.0 - 1.1e-6, -2}, candidates, 21), 0);
}

TEST(TieRule, LeavesOutWhatIsNoNumber) {
  const ControllerSettings s = paper_settings();
  const std::vector<double> candidates = {20, 21, 22};
  EXPECT_EQ(best_candidate(s, std::vector<double>{nan, -3.0, nan}, candidates, 20), 1);
  EXPECT_EQ(best_candidate(s, std::vector<double>{HUGE_VAL, -3.0, -4.0}, candidates, 20), 1);
  EXPECT_EQ(best_candidate(s, std::vector<double>{nan, nan, -HUGE_VAL}, candidates, 20), -1);
  EXPECT_EQ(best_candidate(s, {}, {}, 20), -1);
}

TEST(CandidateRecord, TakesAGridWholeAndAFinerOneInStrides) {
  CandidateRecord record;
  EXPECT_EQ(record.take_grid(20, 0.1, 61), 1);
  EXPECT_EQ(record.count, 61);
  EXPECT_EQ(record.take_grid(20, 0.05, 121), 2);
  EXPECT_EQ(record.count, 61);
  EXPECT_DOUBLE_EQ(record.from_degc + record.step_k * (record.count - 1), 26.0);
  for (int n = 0; n <= 401; ++n) {
    const int stride = record.take_grid(20, 0.05, n);
    ASSERT_LE(record.count, CandidateRecord::most) << n;
    if (n > 0) {
      ASSERT_LT((record.count - 1) * stride, n) << "beyond the grid's end";
    }
  }
}

}  // namespace
}  // namespace airside
