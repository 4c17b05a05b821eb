// Buildings that differ: how much a right model may be off, asked of rooms of another structure.

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>

#include "sim/rc/rc_room_file.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "tools/gap/blind/blind.hpp"
#include "tools/gap/inference/structure_ensemble.hpp"
#include "tools/gap/model/counted_engine.hpp"
#include "tools/gap/model/log_window.hpp"
#include "tools/gap/model/stretches.hpp"
#include "tools/gap/verdict/fitted_case.hpp"
#include "tools/gap/verdict/locked_days.hpp"

namespace airside::tools::gap {
namespace {

/// A room of another structure than its twin, in which nothing is hidden: six days of reference, six measured.
struct OtherRoom {
  sim::RcRoom twin = sim::load_room("301");
  RcEngine engine{twin};
  std::shared_ptr<const sim::Weather> weather = sim::synthetic_weather(11);
  std::vector<sim::Effect> effects = sim::load_effects(sim::find_effects());
  CaseData data;
  WindowResponses responses;

  explicit OtherRoom(std::uint64_t seed) {
    const sim::RcRoom real = with_other_structure(measured_room(twin, seed, true), seed);
    MeasuredRun run{sim::civil_midnight(2021, 7, 1), 6, seed, true, 0};
    data.reference = window_of(measure(real, weather, run), engine.channels(), weather, "reference");
    run.start.seconds += run.days * seconds_per_day;
    run.seed += 1;
    data.test = window_of(measure(real, weather, run), engine.channels(), weather, "log");
    const Library all = library_of(engine, effects);
    Library library{all.parameters, {}};
    for (const sim::EffectAt& at : all.candidates) {
      if (at.effect->name == "vav_flow" || at.effect->name == "fan_power") library.candidates.push_back(at);
    }
    const auto of = [&](const Window& window) {
      return simulate_responses(engine, library, window.recording, true, 2);
    };
    responses = {of(data.reference), of(data.test)};
  }
};

double left(const FittedCase& c) {
  const Refit none =
      c.refitter.at({}, Eigen::VectorXd::Zero(std::ssize(c.responses.test.parameters)), c.refitter.tangent());
  return none.distance / c.samples() / c.fit.residual_ratio;
}

TEST(StructureEnsemble, KnowsWhatTheReferenceCannot) {
  const OtherRoom room(6);
  Rules rules;
  FittedCase alone(room.engine, room.data, room.responses, rules, 2);
  const double without = left(alone);
  alone.draw_buildings();
  EXPECT_TRUE(alone.ensemble.directions.empty()) << "none are asked for";
  EXPECT_EQ(left(alone), without);

  rules.buildings = 24;
  FittedCase c(room.engine, room.data, room.responses, rules, 2);
  c.draw_buildings();
  ASSERT_FALSE(c.ensemble.directions.empty());
  EXPECT_LE(c.ensemble.directions.size(), 24U);
  EXPECT_LT(left(c), without) << "some of what a right model leaves is how buildings differ";
  EXPECT_GT(left(c), 0.5 * without) << "and noise stays noise";
  const double common =
      c.fit.noise.whiten(c.ensemble.mean, counted_bins(c.ensemble.mean.rows()), c.data.test.measured).squaredNorm();
  double varying = 0;
  for (const Eigen::MatrixXd& direction : c.ensemble.directions)
    varying += c.fit.noise.whiten(direction, counted_bins(direction.rows()), c.data.test.measured).squaredNorm();
  EXPECT_GT(common, 0.5 * varying)
      << "all have a slab, ducts with inertia and heat in the return air, which the twin has not";
  double before = std::numeric_limits<double>::infinity();
  for (const Eigen::MatrixXd& direction : c.ensemble.directions) {
    EXPECT_EQ(direction.rows(), room.data.test.measured.rows());
    EXPECT_EQ(direction.cols(), room.data.test.measured.cols());
    const double size =
        c.fit.noise.whiten(direction, counted_bins(direction.rows()), c.data.test.measured).squaredNorm();
    EXPECT_LE(size, before * (1 + 1e-9)) << "the largest comes first";
    before = size;
  }
}

TEST(StructureEnsemble, DoesNotDependOnTheNumberOfThreads) {
  const OtherRoom room(7);
  Rules rules;
  rules.buildings = 3;
  FittedCase one(room.engine, room.data, room.responses, rules, 1),
      two(room.engine, room.data, room.responses, rules, 2);
  one.draw_buildings();
  two.draw_buildings();
  ASSERT_EQ(one.ensemble.directions.size(), two.ensemble.directions.size());
  for (std::size_t k = 0; k < one.ensemble.directions.size(); ++k) {
    EXPECT_EQ(one.ensemble.directions[k], two.ensemble.directions[k]);
  }
}

TEST(StructureEnsemble, TakesTheBuildingsThatResponsesHave) {
  const OtherRoom room(8);
  Rules rules;
  rules.buildings = 5;
  WindowResponses with = room.responses;
  std::atomic<int> drawn = 0;
  const auto draw = [&](Responses& responses, const Window& window) {
    responses.buildings =
        drawn_buildings(room.engine, {}, responses.base, window.recording, rules.buildings, 2, [&drawn] { ++drawn; });
  };
  draw(with.reference, room.data.reference);
  draw(with.test, room.data.test);
  EXPECT_EQ(drawn, 10);
  std::atomic<int> runs = 0;
  const CountedEngine counted(room.engine, [&runs] { ++runs; });
  FittedCase c(counted, room.data, with, rules, 2);
  runs = 0;
  c.draw_buildings();
  EXPECT_EQ(runs, 0) << "no simulation";
  EXPECT_EQ(c.ensemble.rooms, 5);
  EXPECT_GT(c.ensemble.adds, 0);
  EXPECT_LT(c.ensemble.adds, c.ensemble.adds_alone);
  EXPECT_FALSE(c.ensemble.directions.empty());

  // Another number of them is drawn anew, about the fitted model; its own runs are counted too.
  rules.buildings = 4;
  FittedCase other(counted, room.data, with, rules, 2);
  runs = 0;
  other.draw_buildings();
  EXPECT_EQ(runs, 2 * 4 + 2);
  EXPECT_EQ(other.ensemble.rooms, 4);

  rules.buildings = 1;
  FittedCase alone(room.engine, room.data, with, rules, 2);
  alone.draw_buildings();
  EXPECT_EQ(alone.ensemble.adds, alone.ensemble.adds_alone) << "there are no others";
}

TEST(StructureEnsemble, IsEmptyWhereNoBuildingIsDrawn) {
  const OtherRoom room(9);
  class NoBuildings final : public ForwardingEngine {
   public:
    using ForwardingEngine::ForwardingEngine;
    sim::ChannelTable simulate(const Changes& changes, const sim::Recording& recording) const override {
      return engine().simulate(changes, recording);
    }
    bool draws_buildings() const override { return false; }
  };
  const NoBuildings engine(room.engine);
  Rules rules;
  rules.buildings = 5;
  FittedCase c(engine, room.data, room.responses, rules, 2);
  c.draw_buildings();
  EXPECT_EQ(c.ensemble.rooms, 0);
  EXPECT_TRUE(c.ensemble.directions.empty());
}

TEST(LockedDays, ARightModelLeavesNoiseAndHowBuildingsDiffer) {
  const OtherRoom room(10);
  const Rules rules;
  FittedCase c(room.engine, room.data, room.responses, rules, 2);
  const Eigen::Index bins = room.data.test.measured.rows(), channels = room.data.test.measured.cols();
  const Eigen::Index first = locked_from(rules, bins), half = first + (bins - first) / 2;
  const double noise = c.fit.noise.spread()(0);
  Eigen::MatrixXd before = Eigen::MatrixXd::Zero(bins, channels), after = before;
  before.col(0).setConstant(3 * noise);
  after.col(0).setConstant(-noise);
  before.col(0).tail(bins - half).setConstant(std::numeric_limits<double>::quiet_NaN());
  after.col(0).tail(bins - half).setConstant(std::numeric_limits<double>::quiet_NaN());
  const LockedDays alone = locked_days(c, before, after);
  EXPECT_NEAR(alone.score_before, 3, 1e-9);
  EXPECT_NEAR(alone.score_after, 1, 1e-9);
  EXPECT_EQ(alone.score_floor, 1) << "the effect moves one channel";
  EXPECT_EQ(alone.score_right, 1) << "no buildings are drawn";

  // Two drawn buildings differ by 2 and by 1 of the noise where there was a measurement, elsewhere by much more; how
  // they differ in other channels or earlier days does not count.
  for (const double size : {2.0, 1.0}) {
    Eigen::MatrixXd one = Eigen::MatrixXd::Constant(bins, channels, 50 * noise);
    one.col(0).segment(first, half - first).setConstant(size * noise);
    c.ensemble.directions.push_back(one);
  }
  const LockedDays drawn = locked_days(c, before, after);
  EXPECT_NEAR(drawn.score_right, std::sqrt(1.0 + 4.0 + 1.0), 1e-9);
  EXPECT_EQ(drawn.score_floor, 1);
}

TEST(StructureEnsemble, LivesThroughEachStretchOnItsOwn) {
  const RcEngine engine{sim::load_room("301")};
  const auto weather = sim::synthetic_weather(11);
  const auto days = [&](int day) {
    return window_of(measure(engine.room(), weather, {sim::civil_midnight(2021, 7, day), 2, 3, false, 0}),
                     engine.channels(), weather, "log");
  };
  const Window first = days(1), second = days(8);
  const StretchedEngine stretched(engine);
  const sim::ChannelTable all = stretched.simulate_differing(5, {}, stacked_windows({first, second}).recording);
  const sim::ChannelTable one = engine.simulate_differing(5, {}, first.recording),
                          other = engine.simulate_differing(5, {}, second.recording);
  ASSERT_EQ(all.rows(), one.rows() + other.rows());
  EXPECT_TRUE(all.topRows(one.rows()).isApprox(one));
  EXPECT_TRUE(all.bottomRows(other.rows()).isApprox(other));
  EXPECT_FALSE(one.isApprox(engine.simulate({}, first.recording), 1e-6)) << "it is another building";
  EXPECT_FALSE(one.isApprox(engine.simulate_differing(6, {}, first.recording), 1e-6)) << "and each seed is one";
}

}  // namespace
}  // namespace airside::tools::gap
