// Which value of the rooms is held (docs/method.md 16.7), and that whoever forecasts or judges it means the same one.

#include "airside/held_rooms.hpp"

#include <gtest/gtest.h>

#include <memory>

#include "airside/forecast/candidate_search.hpp"
#include "airside/forecast/head_features.hpp"
#include "airside/presets.hpp"
#include "airside/splitmix64.hpp"

namespace airside {
namespace {

using Room = ThreeVav;
using RoomLayout = Layout<Room>;
using RoomVector = Reading<Room>::Vector;

constexpr Shape site = capacity_of<Room>();

RoomVector rooms_at(double a, double b, double c) {
  RoomVector v = RoomVector::Zero();
  v.head(3) << a, b, c;
  v.segment(RoomLayout::vav_on, 3).setOnes();
  return v;
}
HeldRooms by_weights(double a, double b, double c) { return {HoldRule::weighted, {a, b, c}}; }

TEST(HeldRooms, MeanIsThePlainMeanToTheBit) {
  const RoomVector v = rooms_at(24.1, 25.3, 27.7);
  EXPECT_EQ(held_degc<Room>({}, site, v), v.head(3).mean());
}

TEST(HeldRooms, WeightsOfOneAreTheMeanAndOneWeightAloneIsThatRoom) {
  const RoomVector v = rooms_at(24, 25, 28);
  EXPECT_NEAR(held_degc<Room>(by_weights(1, 1, 1), site, v), v.head(3).mean(), 1e-12);
  EXPECT_NEAR(held_degc<Room>(by_weights(0, 3, 0), site, v), 25, 1e-12);
  EXPECT_NEAR(held_degc<Room>(by_weights(1, 1, 2), site, v), (24 + 25 + 2 * 28) / 4.0, 1e-12);
}

TEST(HeldRooms, MiddleIsAsFarFromTheWarmestAsFromTheColdest) {
  EXPECT_NEAR(held_degc<Room>({HoldRule::middle}, site, rooms_at(24, 25, 28)), 26, 1e-12);
}

TEST(HeldRooms, MiddleLeavesOutRoomsWhoseBoxIsClosedUnlessAllAre) {
  RoomVector v = rooms_at(24, 25, 28);
  v(RoomLayout::vav_on + 2) = 0;
  EXPECT_NEAR(held_degc<Room>({HoldRule::middle}, site, v), 24.5, 1e-12);
  EXPECT_NEAR(held_degc<Room>(by_weights(0, 0, 1), site, v), 28, 1e-12) << "weights are the site's own wish";
  v.segment(RoomLayout::vav_on, 3).setZero();
  EXPECT_NEAR(held_degc<Room>({HoldRule::middle}, site, v), 26, 1e-12);
}

TEST(HeldRooms, ABoxThatClosesOrOpensIsNoChangeOfTemperature) {
  const HeldRooms middle{HoldRule::middle};
  const RoomVector open = rooms_at(24, 25, 28);
  RoomVector closed = open;
  closed(RoomLayout::vav_on + 2) = 0;
  EXPECT_EQ(held_change_k<Room>(middle, site, open, closed), 0);
  EXPECT_EQ(held_change_k<Room>(middle, site, closed, open), 0);
  EXPECT_EQ(held_after_degc<Room>(middle, site, open, closed), 26) << "what a forecast made with three rooms meant";
  EXPECT_EQ(held_degc<Room>(middle, site, closed), 24.5);
  closed.head(3) << 24.1, 25.3, 30;
  EXPECT_NEAR(held_change_k<Room>(middle, site, open, closed), 0.2, 1e-12) << "of the two rooms that are open in both";
}

TEST(HeldRooms, RegressorsOfTheHeadAreChangesOfTheHeldValue) {
  const RoomVector before = rooms_at(24, 25, 26), recent = rooms_at(24, 25, 27), now = rooms_at(24, 25, 27.5);
  const HeldRooms mean, last = by_weights(0, 0, 1), middle{HoldRule::middle};
  const auto of = [&](const HeldRooms& held) {
    return head_features<Room>({before, recent, now, 21.0, 0.0, held}, site, 1.0);
  };
  EXPECT_NEAR(of(mean).x(HeadFeatures::room_change), 0.5, 1e-12);
  EXPECT_NEAR(of(last).x(HeadFeatures::room_change), 1.5, 1e-12);
  EXPECT_NEAR(of(last).x(HeadFeatures::room_change_recent), 0.5, 1e-12);
  EXPECT_NEAR(of(middle).x(HeadFeatures::room_change), 0.75, 1e-12);
}

/// A network with drawn weights, and what it expects of a state under a rule.
struct Drawn {
  Drawn() {
    SplitMix64 draw(5);
    initialise_uniform<Room, double>(*weights, draw);
    pack(*weights, scratch->kernels, scratch->packed);
    scaler.mean.setConstant(25);
    scaler.scale.setConstant(2);
    settings.shape = site;
  }
  double expected(const HeldRooms& held, const RoomVector& now) {
    settings.held = held;
    search.configure(settings);
    return search.expected_degc(settings, {scaler, scratch->packed, *scratch}, now, 22.0);
  }
  std::unique_ptr<NetworkWeights<Room, double>> weights = std::make_unique<NetworkWeights<Room, double>>();
  std::unique_ptr<NetworkScratch<Room, double>> scratch = std::make_unique<NetworkScratch<Room, double>>();
  Scaler<Room> scaler;
  ControllerSettings settings = product_settings();
  CandidateSearch<Room, double> search;
};

TEST(HeldRooms, NetworkJudgesItsPredictedRoomsByTheSameRule) {
  Drawn drawn;
  RoomVector now = rooms_at(24, 25, 26);
  const double a = drawn.expected(by_weights(1, 0, 0), now), b = drawn.expected(by_weights(0, 1, 0), now),
               c = drawn.expected(by_weights(0, 0, 1), now);
  EXPECT_NEAR(drawn.expected({}, now), (a + b + c) / 3, 1e-9);
  EXPECT_NEAR(drawn.expected({HoldRule::middle}, now), 0.5 * (std::min({a, b, c}) + std::max({a, b, c})), 1e-9);
  EXPECT_GT(std::abs(a - b) + std::abs(b - c), 1e-3) << "a network that says the same of every room would show nothing";
}

TEST(HeldRooms, WeightsMustLetSomeRoomCount) {
  EXPECT_TRUE(held_rooms_valid({}, 3));
  EXPECT_TRUE(held_rooms_valid(by_weights(0, 0, 0.1), 3));
  EXPECT_FALSE(held_rooms_valid(by_weights(0, 0, 0), 3));
  EXPECT_FALSE(held_rooms_valid(by_weights(0, 0, 1), 2)) << "the weight of a room that the site does not have";
  EXPECT_FALSE(held_rooms_valid(by_weights(1, -1, 1), 3));
  ControllerSettings s = product_settings();
  s.shape = site;
  s.held = by_weights(1, -1, 1);
  EXPECT_FALSE(settings_valid(s));
}

}  // namespace
}  // namespace airside
