// The residual forecaster: what it sees, what it computes, and how its gate decides whether it is asked.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "airside/forecast/residual_forecaster.hpp"
#include "airside/presets.hpp"
#include "airside/settings.hpp"
#include "airside/splitmix64.hpp"
#include "airside/topology.hpp"

namespace airside {
namespace {

using F = ResidualFeatures;
using Net = ResidualNetwork;
using Room = ThreeVav;
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

Net drawn_network(std::uint64_t seed) {
  SplitMix64 draw(seed);
  std::vector<float> values;
  for (int i = 0; i < Net::parameters; ++i) values.push_back(0.2f * static_cast<float>(draw.symmetric()));
  for (int i = 0; i < Net::inputs; ++i)
    values[static_cast<std::size_t>(Net::inputs + i)] = 0.5f + 0.1f * static_cast<float>(i);
  Net net;
  net.take(values);
  return net;
}

/// The same by another way: in double, unit by unit, from the description of the layout.
double by_hand(const Net& net, const F& f) {
  std::vector<double> in;
  for (std::size_t i = 0; i < Net::inputs; ++i) {
    const double z = static_cast<double>((f.x(static_cast<int>(i)) - net.values[i]) / net.values[Net::inputs + i]);
    in.push_back(std::min(8.0, std::max(-8.0, z)));
  }
  std::size_t at = 2 * Net::inputs;
  for (const std::size_t units : {std::size_t{32}, std::size_t{16}, std::size_t{1}}) {
    std::vector<double> out;
    for (std::size_t u = 0; u < units; ++u, at += in.size() + 1) {
      auto y = static_cast<double>(net.values[at + in.size()]);
      for (std::size_t k = 0; k < in.size(); ++k) y += static_cast<double>(net.values[at + k]) * in[k];
      out.push_back(units > 1 && y < 0 ? y / 100 : y);
    }
    in = out;
  }
  EXPECT_EQ(at, net.values.size());
  return std::min(0.5, std::max(-0.5, in[0]));
}

TEST(ResidualNetwork, ComputesWhatItsDescriptionSays) {
  SplitMix64 draw(5);
  int inside = 0;
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const Net net = drawn_network(seed);
    F f;
    for (int i = 0; i < F::count; ++i) f.x(i) = static_cast<float>(3 * draw.symmetric());
    const double wanted = by_hand(net, f);
    EXPECT_NEAR(net.forecast_k(f), wanted, 1e-5);
    inside += std::abs(wanted) < 0.5 ? 1 : 0;
  }
  EXPECT_GT(inside, 10) << "else the limit alone was compared";
}

TEST(ResidualNetwork, ForecastsAtMostHalfAKelvin) {
  Net net = drawn_network(1);
  for (std::size_t i = 2 * Net::inputs; i < net.values.size(); ++i) net.values[i] = 900.0f;
  F f;
  f.x.setConstant(1000.0f);
  EXPECT_EQ(net.forecast_k(f), 0.5);
  for (std::size_t i = net.values.size() - 17; i < net.values.size(); ++i) net.values[i] = -900.0f;
  EXPECT_EQ(net.forecast_k(f), -0.5);
}

TEST(ResidualGate, TrustsAtFirstAndNeverWhatErrsMore) {
  ResidualGate gate;
  EXPECT_EQ(gate.share(), 1.0);
  for (int i = 0; i < 200; ++i) gate.judge(0.05, -0.05);  // always the wrong way
  EXPECT_EQ(gate.share(), 0.0);
  for (int i = 0; i < 2000; ++i) gate.judge(0.05, 0.05);
  EXPECT_EQ(gate.share(), 1.0);
  for (int i = 0; i < 2000; ++i) gate.judge(0.05, 0.10);  // right, and twice too large
  EXPECT_EQ(gate.share(), 0.5);
}

TEST(ResidualGate, OneBadCycleDoesNotEndTheTrust) {
  ResidualGate gate;
  gate.judge(0.05, -0.05);
  EXPECT_EQ(gate.share(), 1.0) << "what was pretrained has a head start";
  for (int i = 0; i < 40; ++i) gate.judge(0.05, -0.05);
  EXPECT_EQ(gate.share(), 0.0) << "of less than a day";
}

TEST(ResidualGate, LearnsNothingFromWhatIsNotKnown) {
  ResidualGate gate;
  gate.judge(0.05, -0.05);
  const auto before = gate.error_k;
  gate.judge(unknown, 0.1);
  gate.judge(0.1, unknown);
  EXPECT_EQ(gate.error_k, before);
}

struct Instant {
  Reading<Room>::Vector before = Reading<Room>::Vector::Zero(), recent = before, now = before;
  ResidualMemory<Layout<Room>::rooms> memory;
  ControllerSettings settings = product_settings();

  Instant() {
    settings.shape = capacity_of<Room>();
    for (auto* v : {&before, &recent, &now}) {
      v->head(3) << 25.0, 25.5, 26.0;
      v->segment(Layout<Room>::vav_on, 3).setOnes();
    }
    memory.end_cycle(0.02);
    memory.end_cycle(-0.03);
  }
  F features(double head_degc = 21.0) const {
    const HeadInstants<Room> at{before, recent, now, 20.5, 0.5, settings.held};
    return residual_features<Room>(settings, CivilTime{15 * 3600}, at, memory, head_degc);
  }
};

TEST(ResidualFeatures, AreThoseOfTheInstant) {
  Instant in;
  in.recent.head(3) << 25.0, 25.4, 25.9;
  in.before.head(3) << 24.9, 25.2, 25.8;
  const F f = in.features();
  EXPECT_NEAR(f.x(F::error), -0.03, 1e-6);
  EXPECT_NEAR(f.x(F::error_before), 0.02, 1e-6);
  EXPECT_NEAR(f.x(F::hour), 0.25, 1e-6);
  EXPECT_NEAR(f.x(F::hour_squared), 0.0625, 1e-6);
  EXPECT_NEAR(f.x(F::deviation), 25.5 - in.settings.target_degc, 1e-6);
  EXPECT_NEAR(f.x(F::change_recent), 0.2 / 3, 1e-5);
  EXPECT_NEAR(f.x(F::change), 0.6 / 3, 1e-5);
  EXPECT_NEAR(f.x(F::move), 0.5, 1e-6);
  EXPECT_NEAR(f.x(F::move_before), 0.5, 1e-6);
  EXPECT_NEAR(f.x(F::to_supply), -4.5, 1e-6);
  for (int i = F::closed; i < F::count; ++i) EXPECT_EQ(f.x(i), 0.0f) << "no box is closed: regressor " << i;
}

TEST(ResidualFeatures, FollowABoxThatClosesAndOpens) {
  Instant in;
  auto on = in.now.segment(Layout<Room>::vav_on, 3);
  on(2) = 0;
  in.now(2) = 26.3;
  in.memory.count_closed(on);
  F f = in.features();
  EXPECT_NEAR(f.x(F::closed), 1.0 / 3, 1e-6);
  EXPECT_NEAR(f.x(F::opened_recent), -1.0 / 3, 1e-6);
  EXPECT_EQ(f.x(F::longest_closed), 1.0f);
  EXPECT_NEAR(f.x(F::closed_deviation), (26.3 - 25.6) / 3, 1e-5);
  EXPECT_NEAR(f.x(F::closed_change), 0.1, 1e-5);
  EXPECT_NEAR(f.x(F::reopening), -(26.3 - 21.0) / 3, 1e-5);
  for (int i = 0; i < 30; ++i) in.memory.count_closed(on);
  f = in.features();
  EXPECT_EQ(f.x(F::longest_closed), 20.0f) << "at most six hours";
  EXPECT_NEAR(f.x(F::mean_closed), 20.0 / 3, 1e-5);
  on(2) = 1;
  in.memory.count_closed(on);
  EXPECT_EQ(in.features().x(F::longest_closed), 0.0f);
}

TEST(ResidualMemory, IsCompleteAfterTwoCyclesThatWereSeen) {
  ResidualMemory<3> memory;
  EXPECT_FALSE(memory.is_complete());
  memory.end_cycle(0.1);
  EXPECT_FALSE(memory.is_complete());
  memory.end_cycle(0.2);
  EXPECT_TRUE(memory.is_complete());
  memory.end_cycle(unknown);
  EXPECT_FALSE(memory.is_complete());
}

}  // namespace
}  // namespace airside
