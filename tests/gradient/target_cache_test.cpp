// What is remembered or left out to save time changes no bit: targets of the replay's slots, and the constraint's part
// of samples that keep to it.

#include "airside/network/target_cache.hpp"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cstdint>
#include <memory>
#include <set>
#include <span>
#include <vector>

#include "airside/learning/replay_ring.hpp"
#include "airside/network/learner.hpp"

namespace airside {
namespace {

using Ring = ReplayRing<ThreeVav, float>;
using Net = NetworkWeights<ThreeVav, float>;

TEST(Fingerprint, AnyOneOrTwoBitsCount) {
  for (const std::size_t size : {1U, 2U, 7U, 9U, 11U}) {
    std::vector<std::uint32_t> bits(size, 0x3F9D70A4U);
    std::set<std::uint64_t> seen;
    const auto add = [&seen, &bits](std::uint64_t seed) {
      std::vector<float> numbers;
      for (const std::uint32_t b : bits) numbers.push_back(std::bit_cast<float>(b));
      EXPECT_TRUE(seen.insert(fingerprint(std::span<const float>(numbers), seed)).second);
    };
    add(1), add(2);
    for (std::size_t i = 0; i < 32 * size; ++i) {
      bits[i / 32] ^= 1U << (i % 32);
      add(1);
      for (std::size_t j = i + 1; j < 32 * size; ++j) {
        bits[j / 32] ^= 1U << (j % 32);
        add(1);
        bits[j / 32] ^= 1U << (j % 32);
      }
      bits[i / 32] ^= 1U << (i % 32);
    }
  }
}

TEST(Fingerprint, OrderAndLengthCount) {
  const std::vector<double> numbers{1, 2, 3, 0, 0};
  std::vector<double> other{2, 1, 3, 0, 0};
  const auto all = fingerprint(std::span<const double>(numbers), 0);
  EXPECT_NE(all, fingerprint(std::span<const double>(other), 0));
  EXPECT_NE(all, fingerprint(std::span<const double>(numbers).first(4), 0));
}

TEST(TargetCache, KnowsWhatItWasGivenUnderThatKeyAlone) {
  TargetCache<float, 2, 3> cache;
  const std::array<float, 2> y{0.5F, -1.5F};
  cache.keep(2, 77, y.data());
  ASSERT_NE(cache.find(2, 77), nullptr);
  EXPECT_EQ(cache.find(2, 77)[1], -1.5F);
  EXPECT_EQ(cache.find(2, 78), nullptr);
  EXPECT_EQ(cache.find(1, 77), nullptr);
  cache.keep(3, 77, y.data());
  EXPECT_EQ(cache.find(3, 77), nullptr) << "a slot beyond the last";
}

struct Learning {
  std::unique_ptr<Net> weights = std::make_unique<Net>();
  std::unique_ptr<Learner<ThreeVav, float>> learner = std::make_unique<Learner<ThreeVav, float>>();
  std::unique_ptr<NetworkScratch<ThreeVav, float>> scratch = std::make_unique<NetworkScratch<ThreeVav, float>>();

  explicit Learning(const Kernels<float>& kernels) {
    SplitMix64 generator(3);
    initialise_golden(*weights, generator);
    learner->reset(*weights);
    scratch->kernels = kernels;
  }
};

Ring::Row drawn(SplitMix64& generator) {
  Ring::Row row;
  for (float& x : row) x = static_cast<float>(1.5 * generator.symmetric());
  return row;
}

TEST(TargetCache, LearningFromAMemoryHasTheBitsOfLearningFromCopies) {
  LearnerSettings<ThreeVav> settings;
  settings.sync_every = 4;
  for (const Kernels<float>& kernels : {strict_kernels<float>(), select_kernels<float>()}) {
    Learning remembering(kernels), forgetful(kernels);
    const auto ring = std::make_unique<Ring>();
    SplitMix64 generator(4);
    for (int i = 0; i < 150; ++i) ring->push(drawn(generator));
    for (int step = 0; step < 30; ++step) {
      std::vector<std::uint32_t> index(step % 3 == 0 ? 7 : 120);
      ring->sample(generator, index);
      std::vector<float> copies;
      for (const std::uint32_t slot : index)
        copies.insert(copies.end(), ring->slot(static_cast<int>(slot)).begin(),
                      ring->slot(static_cast<int>(slot)).end());
      const BatchView<ThreeVav, float> copied{copies.data(), nullptr, static_cast<int>(index.size())};
      const LossTerms a =
          remembering.learner->step(*remembering.weights, ring->view(index), settings, *remembering.scratch);
      const LossTerms b = forgetful.learner->step(*forgetful.weights, copied, settings, *forgetful.scratch);
      ASSERT_EQ(a.total, b.total) << "step " << step;
      ASSERT_EQ(remembering.weights->values, forgetful.weights->values) << "step " << step;
      // A slot whose transition is exchanged, and a whole other target.
      if (step % 5 == 0) ring->slot(static_cast<int>(index.front())) = drawn(generator);
      if (step == 17) {
        remembering.learner->reset(*remembering.weights);
        forgetful.learner->reset(*forgetful.weights);
      }
    }
  }
}

TEST(TargetCache, ATargetIsComputedOnce) {
  Learning l(strict_kernels<float>());
  const auto ring = std::make_unique<Ring>();
  SplitMix64 generator(5);
  for (int i = 0; i < 60; ++i) ring->push(drawn(generator));
  std::vector<std::uint32_t> index(60);
  ring->sample(generator, index);
  const LossSettings<ThreeVav> settings;
  const LossTerms first = l.learner->evaluate(*l.weights, ring->view(index), settings, *l.scratch);
  // Another target behind the cache's back would show in the loss if it were asked again.
  const std::uint64_t seed =
      fingerprint(std::span<const float>(l.learner->target().values), std::bit_cast<std::uint64_t>(settings.gamma));
  const std::array<float, 3> other{9, 9, 9};
  for (const std::uint32_t slot : index) {
    const std::uint64_t key = target_key<ThreeVav>(ring->slot(static_cast<int>(slot)).data(), seed);
    ASSERT_NE(l.scratch->targets.find(slot, key), nullptr);
    l.scratch->targets.keep(slot, key, other.data());
  }
  EXPECT_GT(l.learner->evaluate(*l.weights, ring->view(index), settings, *l.scratch).tdb, first.tdb + 1);
}

// None, some and all samples of a tile violate the constraint: each adds what it would add alone.
TEST(Constraint, WhatSamplesAddDependsOnNoOther) {
  using L = Layout<ThreeVav>;
  const auto weights = std::make_unique<NetworkWeights<ThreeVav, double>>();
  const auto scratch = std::make_unique<NetworkScratch<ThreeVav, double>>();
  SplitMix64 generator(6);
  initialise_golden(*weights, generator);
  constexpr int n = 40;
  std::vector<double> rows(static_cast<std::size_t>(n * L::transition));
  for (double& x : rows) x = 1.5 * generator.symmetric();
  LossSettings<ThreeVav> settings;
  settings.weights = {0, 0, 1, 0, 0};
  for (const int labelled : {0, 1, 2, L::inputs}) {
    settings.labels.fill(0);
    for (int j = 0; j < labelled; ++j) settings.labels[static_cast<std::size_t>(j)] = j % 2 == 0 ? 1 : -1;
    const LossTerms whole =
        batch_gradient(*weights, *weights, BatchView<ThreeVav, double>{rows.data(), nullptr, n}, settings, *scratch);
    const auto gradient = scratch->gradient.values;
    auto mean = gradient;
    mean.fill(0);
    int violating = 0;
    for (int i = 0; i < n; ++i) {
      const BatchView<ThreeVav, double> one{rows.data() + i * L::transition, nullptr, 1};
      violating += batch_gradient(*weights, *weights, one, settings, *scratch).gc > 0 ? 1 : 0;
      for (std::size_t p = 0; p < mean.size(); ++p) mean[p] += scratch->gradient.values[p] / n;
    }
    if (labelled == 0) {
      EXPECT_EQ(whole.gc, 0);
      EXPECT_EQ(violating, 0);
    } else if (labelled == L::inputs) {
      EXPECT_EQ(violating, n);
    } else {
      EXPECT_GT(violating, 0) << labelled;
      EXPECT_LT(violating, n) << labelled;
    }
    for (std::size_t p = 0; p < mean.size(); ++p) ASSERT_NEAR(gradient[p], mean[p], 1e-13) << labelled << " " << p;
  }
}

}  // namespace
}  // namespace airside
