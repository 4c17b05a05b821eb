// Every parameter's gradient against central differences, in double, for every topology.
//
// With all kinks held on their sides the total loss is a quadratic in any one parameter, so a central difference has
// no truncation error at all: what is left is rounding. A parameter whose step of +-h makes any pre-activation,
// constraint slope or residual change sides is not differentiable there; it is counted and left out, and the count
// has a bound.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include "airside/network/learner.hpp"

namespace airside {
namespace {

template <Topology T>
class Differences {
 public:
  using L = Layout<T>;
  static constexpr int samples = 2;

  explicit Differences(std::uint64_t seed) {
    SplitMix64 generator(seed);
    initialise_golden(*weights, generator);
    initialise_golden(*target, generator);
    for (double& x : rows) x = 1.5 * generator.symmetric();
    // Distinct weights, so that a term that takes another's place shows.
    settings.weights = {0.7, 1.3, 0.4, 2.1, 0.9};
    settings.labels = relation_labels<T>(-1.0);
  }

  LossTerms losses() { return batch_losses(*weights, *target, batch(), settings, *scratch); }
  BatchView<T, double> batch() const { return {rows.data(), nullptr, samples}; }

  /// On which side of its kink every piecewise linear thing lies after losses().
  std::vector<bool> sides() const {
    std::vector<bool> out;
    const auto add = [&](const auto& tile) {
      for (int i = 0; i < samples * tile.width; ++i) out.push_back(tile.row(0)[i] > 0);
    };
    const auto& a = scratch->act;
    add(a.enc_s), add(a.enc_a), add(a.joint), add(a.share_0), add(a.share_1), add(a.share_2);
    add(a.strb_0), add(a.strb_1), add(a.tdb_0), add(a.tdb_1);
    for (int r = 0; r < samples; ++r) {
      for (int j = 0; j < L::inputs; ++j) {
        const double by_s = j < L::signals ? scratch->slope_s.row(r)[j] : 0;
        const double by_a = j >= L::rooms ? scratch->slope_a.row(r)[j - L::rooms] : 0;
        out.push_back(by_s + by_a > 0);
      }
      for (int i = 0; i < L::rooms; ++i) out.push_back(scratch->deviation.row(r)[i] > 0);
    }
    return out;
  }

  void check_every_parameter() {
    constexpr double h = 1e-5;
    constexpr int count = NetworkWeights<T, double>::count;
    const LossTerms here = batch_gradient(*weights, *target, batch(), settings, *scratch);
    ASSERT_GT(here.gc, 0) << "the constraint must be active to be tested";
    ASSERT_GT(here.rc, 0) << "the residual constraint must be active to be tested";
    const NetworkWeights<T, double> gradient = scratch->gradient;
    losses();
    const std::vector<bool> side = sides();
    int left_out = 0;
    int nonzero = 0;
    double worst = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double value = weights->values[i];
      weights->values[i] = value + h;
      const double above = losses().total;
      const bool same_above = sides() == side;
      weights->values[i] = value - h;
      const double below = losses().total;
      const bool same_below = sides() == side;
      weights->values[i] = value;
      if (!same_above || !same_below) {
        ++left_out;
        continue;
      }
      const double difference = (above - below) / ((value + h) - (value - h));
      const double error = std::abs(difference - gradient.values[i]) / std::max(1.0, std::abs(difference));
      nonzero += gradient.values[i] != 0 ? 1 : 0;
      worst = std::max(worst, error);
      ASSERT_LT(error, 2e-9) << T::name << " parameter " << i << ": " << difference << " against "
                             << gradient.values[i];
    }
    EXPECT_LT(left_out, count / 200) << T::name;
    EXPECT_GT(nonzero, count * 9 / 10) << T::name;
    RecordProperty("left_out", left_out);
    std::printf("%s: %d parameters, %d left out at kinks, worst error %.1e\n", T::name, count, left_out, worst);
  }

  std::unique_ptr<NetworkWeights<T, double>> weights = std::make_unique<NetworkWeights<T, double>>();
  std::unique_ptr<NetworkWeights<T, double>> target = std::make_unique<NetworkWeights<T, double>>();
  std::unique_ptr<NetworkScratch<T, double>> scratch = std::make_unique<NetworkScratch<T, double>>();
  std::vector<double> rows = std::vector<double>(static_cast<std::size_t>(samples * L::transition));
  LossSettings<T> settings;

 private:
  static void RecordProperty(const char* key, int value) { ::testing::Test::RecordProperty(key, value); }
};

TEST(Gradient, EveryParameterOfFiveZoneAgreesWithCentralDifferences) {
  Differences<FiveZone>(11).check_every_parameter();
}

TEST(Gradient, EveryParameterOfThreeVavAgreesWithCentralDifferences) {
  Differences<ThreeVav>(12).check_every_parameter();
}

TEST(Gradient, EveryParameterOfEightVavFourFcuAgreesWithCentralDifferences) {
  Differences<EightVavFourFcu>(13).check_every_parameter();
}

TEST(Gradient, ALargeStepCrossesKinksAndIsNoticed) {
  Differences<FiveZone> d(11);
  d.losses();
  const std::vector<bool> side = d.sides();
  d.weights->weight<Layer::share_0>()(0, 0) += 3;
  d.losses();
  EXPECT_NE(d.sides(), side);
}

TEST(Gradient, InputSlopesAgreeWithCentralDifferences) {
  using L = Layout<FiveZone>;
  Differences<FiveZone> d(14);
  d.losses();
  std::vector<double> slopes;
  for (int j = 0; j < L::inputs; ++j) {
    const double by_s = j < L::signals ? d.scratch->slope_s.row(0)[j] : 0;
    const double by_a = j >= L::rooms ? d.scratch->slope_a.row(0)[j - L::rooms] : 0;
    slopes.push_back(by_s + by_a);
  }
  const auto sum_of_short_term = [&](std::size_t j, double change) {
    const double value = d.rows[j];
    d.rows[j] = value + change;
    d.losses();
    d.rows[j] = value;
    double sum = 0;
    for (int i = 0; i < L::rooms; ++i) sum += d.scratch->short_term.row(0)[i];
    return sum;
  };
  for (std::size_t j = 0; j < L::inputs; ++j)
    EXPECT_NEAR(slopes[j], (sum_of_short_term(j, 1e-6) - sum_of_short_term(j, -1e-6)) / 2e-6, 1e-8) << j;
}

TEST(Gradient, TilesAddUpToTheWholeBatch) {
  using L = Layout<ThreeVav>;
  constexpr int n = 3 * tile_samples + 7;
  Differences<ThreeVav> d(15);
  SplitMix64 generator(16);
  std::vector<double> rows(static_cast<std::size_t>(n * L::transition));
  for (double& x : rows) x = 1.5 * generator.symmetric();
  batch_gradient(*d.weights, *d.target, BatchView<ThreeVav, double>{rows.data(), nullptr, n}, d.settings, *d.scratch);
  const NetworkWeights<ThreeVav, double> whole = d.scratch->gradient;
  NetworkWeights<ThreeVav, double> mean;
  for (std::uint32_t i = 0; i < n; ++i) {
    batch_gradient(*d.weights, *d.target, BatchView<ThreeVav, double>{rows.data(), &i, 1}, d.settings, *d.scratch);
    for (std::size_t p = 0; p < mean.values.size(); ++p) mean.values[p] += d.scratch->gradient.values[p] / n;
  }
  for (std::size_t p = 0; p < mean.values.size(); ++p) ASSERT_NEAR(whole.values[p], mean.values[p], 1e-11) << p;
}

}  // namespace
}  // namespace airside
