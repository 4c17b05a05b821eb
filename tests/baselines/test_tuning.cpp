// The search for gains finds the lowest point, says where its grid ends, and what it found is what the tables drive.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "hal/text/input_error.hpp"
#include "tools/baselines/tuning.hpp"
#include "tools/study/control_methods.hpp"

namespace airside::tools {
namespace {

using Gains = std::vector<double>;

CandidateCosts costs_by(double (*cost)(const Gains&)) {
  return [cost](std::span<const Gains> candidates) {
    std::vector<double> out;
    for (const Gains& g : candidates) out.push_back(cost(g));
    return out;
  };
}

const std::vector<TuningAxis> square = {{"x", {0, 1, 2, 3, 4, 5}, false}, {"y", {0, 1, 2, 3, 4, 5}, false}};

TEST(GainSearch, FindsTheLowestPointOfANarrowValleyOnADiagonal) {
  const auto valley =
      costs_by([](const Gains& g) { return 10 * std::pow(g[0] - g[1], 2) + std::pow(g[0] + g[1] - 8, 2); });
  const Gains corner = {0, 0};
  const GridSearch walked = descend_grid(square, corner, valley);
  const GridSearch all = search_grid(square, valley);
  EXPECT_EQ(walked.best.gains, (Gains{4, 4}));
  EXPECT_EQ(all.best.gains, walked.best.gains);
  EXPECT_EQ(all.trials.size(), 36U);
  EXPECT_LT(walked.trials.size(), 36U);
  EXPECT_TRUE(walked.edges.empty());
}

TEST(GainSearch, TellsAnEdgeUnlessTheGainItselfEndsThere) {
  const auto downhill = costs_by([](const Gains& g) { return g[0] - g[1]; });
  std::vector<TuningAxis> axes = square;
  EXPECT_EQ(search_grid(axes, downhill).edges, (std::vector<std::string>{"x", "y"}));
  axes[0].ends_at_first = true;
  EXPECT_EQ(search_grid(axes, downhill).edges, (std::vector<std::string>{"y"}));
}

TEST(GainSearch, ACostThatIsNoNumberLosesAndNoneAtAllIsRefused) {
  const auto holes =
      costs_by([](const Gains& g) { return g[0] < 3 ? std::numeric_limits<double>::quiet_NaN() : g[0]; });
  EXPECT_EQ(search_grid(square, holes).best.gains[0], 3);
  const auto nothing = costs_by([](const Gains&) { return std::numeric_limits<double>::infinity(); });
  EXPECT_THROW(search_grid(square, nothing), hal::InputError);
}

TEST(TunedGains, StandOnTheirGridAndNotOnItsEdge) {
  for (const PlantKind plant : {PlantKind::rc, PlantKind::energyplus}) {
    for (const TunablePeer& peer : tunable_peers()) {
      const Gains frozen = peer.frozen(tuned_gains(plant));
      ASSERT_EQ(frozen.size(), peer.axes.size());
      for (std::size_t a = 0; a < frozen.size(); ++a) {
        const auto& values = peer.axes[a].values;
        const auto at = std::find(values.begin(), values.end(), frozen[a]);
        ASSERT_NE(at, values.end()) << peer.method << ' ' << peer.axes[a].name;
        EXPECT_NE(at + 1, values.end()) << peer.method << ' ' << peer.axes[a].name;
        if (!peer.axes[a].ends_at_first) {
          EXPECT_NE(at, values.begin()) << peer.method << ' ' << peer.axes[a].name;
        }
      }
    }
  }
}

Trial tuning_room(const std::string& room) {
  Trial trial{built_in_site(), {}, 5, 7};
  trial.plant.kind = "rc";
  trial.plant.room = room;
  trial.plant.start = "2021-07-10";
  return trial;
}

/// Mean DAE over the rooms of `airside study tune --plant rc`.
double mean_dae(const TunablePeer& peer, const Gains& gains) {
  constexpr int rooms = 8;
  double sum = 0;
  for (int i = 0; i < rooms; ++i) {
    const Trial trial = tuning_room("tuning-" + std::to_string(i));
    Prepared prepared = prepare(trial);
    const auto baseline = peer.make(trial.site.settings, gains);
    sum +=
        metrics_of(trial.site, run_baseline(trial.site, prepared.room(), *baseline, prepared.history, prepared.until))
            .dae_degc /
        rooms;
  }
  return sum;
}

TEST(TunedGains, OfRcRoomsAreBetterThanTheirNeighboursOnTheTuningRooms) {
  for (const TunablePeer& peer : tunable_peers()) {
    const Gains frozen = peer.frozen(tuned_gains(PlantKind::rc));
    const double best = mean_dae(peer, frozen);
    for (std::size_t a = 0; a < frozen.size(); ++a) {
      const auto& values = peer.axes[a].values;
      const auto at = std::find(values.begin(), values.end(), frozen[a]) - values.begin();
      for (const auto to : {at - 1, at + 1}) {
        if (to < 0 || to >= static_cast<std::ptrdiff_t>(values.size())) continue;
        Gains other = frozen;
        other[a] = values[static_cast<std::size_t>(to)];
        EXPECT_GE(mean_dae(peer, other), best) << peer.method << ' ' << peer.axes[a].name << ' ' << other[a];
      }
    }
  }
}

TEST(TunedGains, AreWhatTheTablesDrive) {
  const Trial trial = tuning_room("tuning-0");
  for (const TunablePeer& peer : tunable_peers()) {
    Prepared by_name = prepare(trial), by_gains = prepare(trial);
    const auto baseline = peer.make(trial.site.settings, peer.frozen(tuned_gains(PlantKind::rc)));
    const ControlRun named = run_method(trial, by_name, peer.method);
    const ControlRun made = run_baseline(trial.site, by_gains.room(), *baseline, by_gains.history, by_gains.until);
    ASSERT_EQ(named.cycles.size(), made.cycles.size());
    for (std::size_t i = 0; i < named.cycles.size(); ++i) {
      ASSERT_EQ(named.cycles[i].setpoint_degc, made.cycles[i].setpoint_degc) << peer.method;
    }
    for (const PlantKind plant : {PlantKind::rc, PlantKind::energyplus}) {
      const auto by_plant = make_baseline(peer.method, trial.site.settings, plant);
      const auto again = peer.make(trial.site.settings, peer.frozen(tuned_gains(plant)));
      CycleObservation now{{86400 * 4 + 12 * 3600}, prepare(trial).room().sensors(), 22.5, 25.25};
      EXPECT_EQ(by_plant->decide(now), again->decide(now)) << peer.method;
    }
  }
}

}  // namespace
}  // namespace airside::tools
