#include "airside/learning/replay_ring.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <set>
#include <vector>

namespace airside {
namespace {

using Ring = ReplayRing<ThreeVav, float, 100>;

/// A ring after `pushes` rows whose first number is their order.
Ring filled(int pushes) {
  Ring ring;
  for (int i = 0; i < pushes; ++i) {
    Ring::Row row{};
    row[0] = static_cast<float>(i);
    ring.push(row);
  }
  return ring;
}

TEST(ReplayRing, ForgetsTheOldestFirst) {
  Ring ring = filled(250);
  EXPECT_EQ(ring.size(), 100);
  EXPECT_EQ(ring.total_pushed(), 250u);
  for (int age = 0; age < 100; ++age) EXPECT_EQ(ring.newest(age)[0], static_cast<float>(249 - age));
  EXPECT_EQ(ring.slot(250 % 100)[0], 150.0F) << "the next push overwrites the oldest";
  ring.clear();
  EXPECT_EQ(ring.size(), 0);
}

TEST(ReplayRing, PartlyFilledRingHoldsOnlyWhatWasPushed) {
  const Ring ring = filled(7);
  EXPECT_EQ(ring.size(), 7);
  EXPECT_EQ(ring.newest(0)[0], 6.0F);
  EXPECT_EQ(ring.newest(6)[0], 0.0F);
}

TEST(ReplayRing, DrawsWithoutReplacementAndNeverOutsideWhatItHolds) {
  SplitMix64 generator(1);
  for (const int pushes : {40, 100, 163}) {
    const Ring ring = filled(pushes);
    for (int round = 0; round < 200; ++round) {
      std::vector<std::uint32_t> index(30);
      ASSERT_EQ(ring.sample(generator, index, round % 30), 30);
      const std::set<std::uint32_t> different(index.begin(), index.end());
      ASSERT_EQ(different.size(), 30u);
      ASSERT_LT(*different.rbegin(), static_cast<std::uint32_t>(ring.size()));
    }
  }
}

TEST(ReplayRing, SmallRingIsDrawnWhole) {
  const Ring ring = filled(12);
  SplitMix64 generator(2);
  std::vector<std::uint32_t> index(30, 99);
  EXPECT_EQ(ring.sample(generator, index, 5), 12);
  for (std::uint32_t i = 0; i < 12; ++i) EXPECT_EQ(index[i], i);
  EXPECT_EQ(index[12], 99u);
}

TEST(ReplayRing, RecentTransitionsAreInEveryBatch) {
  const Ring ring = filled(130);
  SplitMix64 generator(3);
  for (int round = 0; round < 100; ++round) {
    std::vector<std::uint32_t> index(20);
    ring.sample(generator, index, 8);
    for (int age = 0; age < 8; ++age)
      ASSERT_NE(std::find(index.begin(), index.end(), static_cast<std::uint32_t>(ring.slot_of_age(age))), index.end());
  }
}

TEST(ReplayRing, EverySlotIsDrawnEquallyOften) {
  const Ring ring = filled(164);
  SplitMix64 generator(4);
  std::vector<int> hits(100);
  constexpr int rounds = 20000;
  for (int round = 0; round < rounds; ++round) {
    std::vector<std::uint32_t> index(25);
    ring.sample(generator, index);
    for (const std::uint32_t slot : index) ++hits[slot];
  }
  // Binomial(20000, 1/4): mean 5000, sd 61; five sd.
  for (const int hit : hits) EXPECT_NEAR(hit, rounds / 4, 310);
}

TEST(ReplayRing, TheRestOfABatchWithRecentOnesIsUniformOverTheOlder) {
  const Ring ring = filled(100);
  SplitMix64 generator(5);
  std::vector<int> hits(100);
  constexpr int rounds = 20000;
  for (int round = 0; round < rounds; ++round) {
    std::vector<std::uint32_t> index(30);
    ring.sample(generator, index, 20);
    for (const std::uint32_t slot : index) ++hits[slot];
  }
  for (std::size_t slot = 0; slot < 80; ++slot) EXPECT_NEAR(hits[slot], rounds / 8, 240) << slot;
  for (std::size_t slot = 80; slot < 100; ++slot) EXPECT_EQ(hits[slot], rounds) << slot;
}

TEST(ReplayRing, SameGeneratorStateDrawsTheSameBatch) {
  const Ring ring = filled(100);
  SplitMix64 one(6);
  std::vector<std::uint32_t> a(30), b(30), c(30);
  ring.sample(one, a);
  SplitMix64 other(one.state());
  ring.sample(one, b);
  ring.sample(other, c);
  EXPECT_EQ(b, c);
  EXPECT_NE(a, b);
}

TEST(ReplayRing, EmptyRingDrawsNothing) {
  const Ring ring;
  SplitMix64 generator(7);
  std::vector<std::uint32_t> index(3, 5);
  EXPECT_EQ(ring.sample(generator, index, 2), 0);
  EXPECT_EQ(ring.sample_with_replacement(generator, index), 0);
  EXPECT_EQ(index[0], 5u);
}

TEST(ReplayRing, BytesCarryTheWholeState) {
  const Ring ring = filled(137);
  std::vector<std::byte> bytes(sizeof(Ring));
  std::memcpy(bytes.data(), &ring, sizeof(Ring));
  Ring copy;
  std::memcpy(&copy, bytes.data(), sizeof(Ring));
  EXPECT_EQ(copy.total_pushed(), 137u);
  EXPECT_EQ(copy.newest(99)[0], 37.0F);
}

}  // namespace
}  // namespace airside
