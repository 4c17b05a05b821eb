// The room head's recursive estimate finds a linear room's gain and daily profile.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <memory>

#include "airside/forecast/room_head.hpp"
#include "airside/presets.hpp"
#include "airside/splitmix64.hpp"
#include "support/default_cycle.hpp"
#include "unit/monday.hpp"

namespace airside {
namespace {

using T = FiveZone;
using Head = RoomHead<T>;

constexpr double true_gain = 0.8, true_memory = 0.3;

double profile_k(CivilTime t) { return 0.06 * std::sin(6.2831853 * t.second_of_day() / 86400.0); }

ControllerSettings settings() {
  ControllerSettings s = product_settings();
  s.head_moving_average = 0;
  return s;
}

/// A room that moves by memory * last move + gain * setpoint change + profile + noise, for so many days.
void live(Head& head, const ControllerSettings& s, int days, double noise_k, double gain = true_gain) {
  SplitMix64 draw(11);
  double moved = 0;
  for (int i = 0; i < days * cycles_per_day; ++i) {
    const CivilTime t{monday.seconds + i * static_cast<std::int64_t>(cycle_s)};
    HeadFeatures f;
    f.x(0) = moved;
    f.x(HeadFeatures::setpoint_change) = 0.2 * draw.symmetric();
    moved = true_memory * moved + gain * f.x(HeadFeatures::setpoint_change) + profile_k(t) + noise_k * draw.symmetric();
    head.grow(s, 1.0 / cycles_per_day);
    head.update(s, t, f, moved);
  }
}

TEST(RoomHead, FindsGainMemoryAndProfileOfALinearRoom) {
  const ControllerSettings s = settings();
  auto head = std::make_unique<Head>();
  head->reset(s, 0.6, 0.3);
  live(*head, s, 20, 0.02);
  EXPECT_NEAR(head->gain(s), true_gain, 0.03);
  EXPECT_NEAR(head->theta()(0), true_memory, 0.05);
  EXPECT_LT(head->gain_sd(), 0.05);
  double worst = 0;
  for (int slot = 0; slot < cycles_per_day; ++slot) {
    const CivilTime t{monday.seconds + 21 * 86400LL + slot * cycle_s};
    worst = std::max(worst, std::abs(head->drift_k(s, t, {}) - profile_k(t)));
  }
  EXPECT_LT(worst, 0.02);
  EXPECT_TRUE(head->finite());
  EXPECT_EQ(head->updates(), 20U * cycles_per_day);
}

TEST(RoomHead, ChoosesTheSetpointThatReachesTheTarget) {
  ControllerSettings s = settings();
  s.head_correction = 1.0;
  auto head = std::make_unique<Head>();
  head->reset(s, 0.6, 0.3);
  live(*head, s, 20, 0.0);
  const CivilTime t{monday.seconds + 21 * 86400LL + 40 * cycle_s};
  HeadFeatures f;
  f.x(0) = 0.1;
  const double room = 25.6, last = 23.0;
  const double a = head->setpoint_degc(s, t, f, room, last);
  const double reached = room + true_memory * 0.1 + true_gain * (a - last) + profile_k(t);
  EXPECT_NEAR(reached, s.target_degc, 0.02);
}

TEST(RoomHead, KeepsTheGainInItsBounds) {
  const ControllerSettings s = settings();
  auto head = std::make_unique<Head>();
  head->reset(s, 5.0, 0.3);
  EXPECT_EQ(head->gain(s), s.head_gain_max);
  head->reset(s, -5.0, 0.3);
  EXPECT_EQ(head->gain(s), s.head_gain_min);
}

TEST(RoomHead, BeginsWithItsPriorAndNoDrift) {
  const ControllerSettings s = settings();
  auto head = std::make_unique<Head>();
  head->reset(s, 0.55, 0.2);
  EXPECT_EQ(head->gain(s), 0.55);
  EXPECT_NEAR(head->gain_sd(), 0.2, 1e-12);
  EXPECT_EQ(head->drift_k(s, monday, {}), 0.0);
  EXPECT_EQ(head->updates(), 0U);
}

TEST(RoomHead, LearnsNothingFromWhatIsNoNumber) {
  const ControllerSettings s = settings();
  auto head = std::make_unique<Head>();
  head->reset(s, 0.6, 0.3);
  live(*head, s, 2, 0.02);
  const Head::State before = head->theta();
  EXPECT_TRUE(std::isnan(head->update(s, monday, {}, std::nan(""))));
  HeadFeatures f;
  f.x(2) = std::nan("");
  EXPECT_TRUE(std::isnan(head->update(s, monday, f, 0.1)));
  EXPECT_EQ(head->theta(), before);
  EXPECT_TRUE(head->finite());
}

TEST(RoomHead, ClipsASurprise) {
  const ControllerSettings s = settings();
  auto calm = std::make_unique<Head>(), wild = std::make_unique<Head>();
  for (Head* head : {calm.get(), wild.get()}) {
    head->reset(s, 0.6, 0.3);
    live(*head, s, 5, 0.02);
  }
  calm->update(s, monday, {}, s.head_clip_k + calm->drift_k(s, monday, {}));
  EXPECT_NEAR(wild->update(s, monday, {}, 1e6), 1e6, 1.0);
  EXPECT_TRUE(calm->theta().isApprox(wild->theta(), 1e-12));
}

TEST(RoomHead, StaysSoundForTwoMonthsWithoutNoise) {
  // The estimate is as sure as it can get: the covariance stays symmetric, and its diagonal positive.
  const ControllerSettings s = settings();
  auto head = std::make_unique<Head>();
  head->reset(s, 0.6, 0.3);
  live(*head, s, 60, 0.0);
  const auto p = head->covariance();
  EXPECT_TRUE((p.diagonal().array() >= 0).all());
  EXPECT_LT((p - p.transpose()).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(RoomHead, IsNeverLessSureOfAnHourItHasNotSeenThanAtTheStart) {
  ControllerSettings s = settings();
  s.head_day_types = 2;
  auto head = std::make_unique<Head>();
  head->reset(s, 0.6, 0.3);
  for (int year = 0; year < 5; ++year) head->grow(s, 365.0);
  for (int day = 0; day < 400; ++day) head->grow(s, 1.0);
  const double prior = s.head_profile_sd_k * s.head_profile_sd_k;
  EXPECT_LE(head->covariance().diagonal().tail<Head::slots * Head::day_types>().maxCoeff(), prior * (1 + 1e-9));
  const Eigen::MatrixXd p = head->covariance();
  EXPECT_GT(p.ldlt().vectorD().minCoeff(), 0) << "a covariance";
}

TEST(RoomHead, FindsTheNewGainOfAValveThatWasChangedAfterAYear) {
  const ControllerSettings s = settings();
  auto head = std::make_unique<Head>();
  head->reset(s, 0.6, 0.3);
  live(*head, s, 365, 0.02);
  ASSERT_NEAR(head->gain(s), true_gain, 0.03);
  live(*head, s, 28, 0.02, 0.5 * true_gain);
  EXPECT_NEAR(head->gain(s), 0.5 * true_gain, 0.1);
}

TEST(RoomHead, KeepsDaysOffApartAndSharesThePrior) {
  ControllerSettings s = settings();
  s.head_day_types = 2;
  auto head = std::make_unique<Head>();
  head->reset(s, 0.6, 0.3);
  for (int day = 0; day < 5; ++day) {
    for (int i = 0; i < cycles_per_day; ++i) head->update(s, {monday.seconds + day * 86400LL + i * cycle_s}, {}, 0.05);
  }
  const CivilTime noon{monday.seconds + 40 * cycle_s}, saturday_noon{noon.seconds + 5 * 86400LL};
  EXPECT_NEAR(head->drift_k(s, noon, {}), 0.05, 0.01);
  EXPECT_LT(head->drift_k(s, saturday_noon, {}), 0.8 * head->drift_k(s, noon, {}));
  EXPECT_GT(head->drift_k(s, saturday_noon, {}), 0.0) << "most of the prior is shared";
}

TEST(RoomHead, DaysOffKnowTheMoreOfWorkingDaysTheMoreAlikeTheyAre) {
  double before = -1;
  for (const double alike : {0.0, 0.5, 0.8, 1.0}) {
    ControllerSettings s = settings();
    s.head_day_types = 2;
    s.head_days_alike = alike;
    auto head = std::make_unique<Head>();
    head->reset(s, 0.6, 0.3);
    for (int day = 0; day < 5; ++day) {
      for (int i = 0; i < cycles_per_day; ++i) {
        head->update(s, {monday.seconds + day * 86400LL + i * cycle_s}, {}, 0.05);
      }
    }
    const CivilTime noon{monday.seconds + 40 * cycle_s}, saturday_noon{noon.seconds + 5 * 86400LL};
    const double share = head->drift_k(s, saturday_noon, {}) / head->drift_k(s, noon, {});
    EXPECT_NEAR(share, alike, 0.1);
    EXPECT_GT(share, before);
    before = share;
  }
}

TEST(RoomHead, KeepsDaysOffApartWhereTheSiteHasDaysOffUnlessToldOtherwise) {
  for (const int day_types : {0, 1}) {
    ControllerSettings s = settings();
    s.weekday_only = 1;
    s.head_day_types = day_types;
    auto head = std::make_unique<Head>();
    head->reset(s, 0.6, 0.3);
    const auto fed = [&](int day, double moved_k) {
      for (int i = 0; i < cycles_per_day; ++i) {
        head->update(s, {monday.seconds + day * 86400LL + i * cycle_s}, {}, moved_k);
      }
    };
    for (int day = 0; day < 5; ++day) fed(day, 0.05);
    for (int day = 5; day < 7; ++day) fed(day, -0.05);
    const CivilTime noon{monday.seconds + 40 * cycle_s}, saturday_noon{noon.seconds + 5 * 86400LL};
    const double apart_k = head->drift_k(s, noon, {}) - head->drift_k(s, saturday_noon, {});
    EXPECT_EQ(apart_k > 0.05, day_types == 0) << apart_k;
    EXPECT_EQ(apart_k == 0, day_types == 1) << apart_k;
  }
}

TEST(RoomHead, BeginsDaysOffFromWorkingDaysWhereItKnewOneProfileOnly) {
  ControllerSettings s = settings();
  s.head_day_types = 1;
  auto head = std::make_unique<Head>();
  head->reset(s, 0.6, 0.3);
  live(*head, s, 10, 0.02);
  const CivilTime noon{monday.seconds + 40 * cycle_s}, saturday_noon{noon.seconds + 5 * 86400LL};
  const double working = head->drift_k(s, noon, {});
  s.head_day_types = 2;
  ASSERT_EQ(head->drift_k(s, saturday_noon, {}), 0.0);
  head->complete_day_types(s);
  EXPECT_EQ(head->drift_k(s, saturday_noon, {}), working);
  EXPECT_EQ(head->drift_k(s, noon, {}), working);
  EXPECT_LT((head->covariance() - head->covariance().transpose()).cwiseAbs().maxCoeff(), 1e-12);
  const Eigen::MatrixXd p = head->covariance();
  EXPECT_GT(p.ldlt().vectorD().minCoeff(), 0) << "a covariance";
  for (int week = 0; week < 4; ++week) {
    for (int i = 0; i < cycles_per_day; ++i) {
      head->update(s, {monday.seconds + (5 + 7 * week) * 86400LL + i * cycle_s}, {}, -0.1);
    }
  }
  EXPECT_NEAR(head->drift_k(s, saturday_noon, {}), -0.1, 0.02) << "and then goes its own way";
  const double told = head->drift_k(s, saturday_noon, {});
  head->complete_day_types(s);
  EXPECT_EQ(head->drift_k(s, saturday_noon, {}), told) << "a profile that is there stays";
}

}  // namespace
}  // namespace airside
