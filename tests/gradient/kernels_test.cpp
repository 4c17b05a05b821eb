// Fast kernels agree with the strict ones for every shape, and the strict ones give the same bits in every build.

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <memory>
#include <vector>

#include "airside/network/learner.hpp"

namespace airside {
namespace {

std::vector<Kernels<float>> fast_kernels() {
  std::vector<Kernels<float>> all;
  for (const KernelKind kind : {KernelKind::avx2, KernelKind::avx512})
    if (cpu_has(kind)) all.push_back(float_kernels(kind));
  return all;
}

std::vector<float> random(std::size_t n, SplitMix64& generator) {
  std::vector<float> values(n);
  for (float& v : values) v = static_cast<float>(generator.symmetric());
  return values;
}

void expect_near(const std::vector<float>& a, const std::vector<float>& b, float bound, const char* what) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) ASSERT_NEAR(a[i], b[i], bound) << what << " " << i;
}

TEST(Kernels, TableSaysWhatItIs) {
  EXPECT_EQ(strict_kernels<float>().kind, KernelKind::strict);
  for (const Kernels<float>& k : fast_kernels()) EXPECT_NE(k.kind, KernelKind::strict);
  EXPECT_TRUE(cpu_has(select_kernels<float>().kind));
  EXPECT_EQ(select_kernels<double>().kind, KernelKind::strict);
}

TEST(Kernels, ProductsAgreeForEveryRowCountWidthAndEnding) {
  SplitMix64 generator(5);
  for (const Kernels<float>& fast : fast_kernels()) {
    for (int rows = 1; rows <= tile_samples; ++rows) {
      for (const int cols : {16, 32, 48, 64}) {
        for (const int stride : {64, 32, 21}) {
          const int depth = std::min(stride, rows + 3);
          const std::vector<float> x = random(static_cast<std::size_t>(rows * stride), generator);
          const std::vector<float> w = random(static_cast<std::size_t>(depth * cols), generator);
          const std::vector<float> bias = random(static_cast<std::size_t>(cols), generator);
          const std::vector<float> gate = random(static_cast<std::size_t>(rows * cols), generator);
          const std::vector<float> start = random(static_cast<std::size_t>(rows * cols), generator);
          for (int mode = 0; mode < 5; ++mode) {
            std::vector<float> out = start;
            std::vector<float> expected = start;
            for (const bool strict : {true, false}) {
              ProductArgs<float> p{x.data(), stride, w.data(), cols, strict ? expected.data() : out.data(),
                                   cols,     rows,   depth,    cols};
              if (mode == 1 || mode == 2) p.bias = bias.data();
              p.leaky = mode == 2;
              if (mode >= 3) p.gate = gate.data();
              p.gate_stride = cols;
              p.accumulate = mode == 4;
              (strict ? strict_kernels<float>() : fast).product(p);
            }
            expect_near(out, expected, 1e-5F, text_of(fast.kind));
          }
        }
      }
    }
  }
}

TEST(Kernels, WeightGradientsAgreeForEveryShape) {
  SplitMix64 generator(6);
  for (const Kernels<float>& fast : fast_kernels())
    for (const int samples : {1, 2, 7, 96})
      for (int rows = 1; rows <= 64; rows += 3)
        for (const int cols : {16, 32, 48, 64}) {
          const std::vector<float> d = random(static_cast<std::size_t>(samples * 64), generator);
          const std::vector<float> x = random(static_cast<std::size_t>(samples * cols), generator);
          std::vector<float> g = random(static_cast<std::size_t>(rows * cols), generator);
          std::vector<float> expected = g;
          fast.outer({d.data(), 64, x.data(), cols, g.data(), cols, samples, rows, cols});
          strict_kernels<float>().outer({d.data(), 64, x.data(), cols, expected.data(), cols, samples, rows, cols});
          expect_near(g, expected, 2e-5F, text_of(fast.kind));
        }
}

TEST(Kernels, TransposesAreExactForEveryShape) {
  SplitMix64 generator(7);
  for (const Kernels<float>& fast : fast_kernels())
    for (const int rows : {3, 5, 8, 32, 64})
      for (const int cols : {8, 10, 21, 22, 25, 29, 32, 64}) {
        const std::vector<float> w = random(static_cast<std::size_t>(rows * cols), generator);
        std::vector<float> out(static_cast<std::size_t>(64 * cols), 9.0F);
        std::vector<float> expected = out;
        fast.transpose({w.data(), rows, cols, out.data(), 64});
        strict_kernels<float>().transpose({w.data(), rows, cols, expected.data(), 64});
        ASSERT_EQ(out, expected) << rows << " x " << cols;
      }
}

TEST(Kernels, AdamAgreesOverManyMagnitudesAndLeavesZerosAlone) {
  SplitMix64 generator(8);
  constexpr std::size_t n = 1024;
  for (const Kernels<float>& fast : fast_kernels()) {
    std::vector<float> w = random(n, generator), m(n), v(n), g(n);
    for (std::size_t i = 16; i < n; ++i)
      g[i] = static_cast<float>(generator.symmetric() * std::pow(10.0, -12 * generator.uniform()));
    std::vector<float> w2 = w, m2 = m, v2 = v;
    const std::vector<float> before = w;
    for (int step = 0; step < 3; ++step) {
      const auto run = [&](const Kernels<float>& k, auto& weights, auto& first, auto& second) {
        k.adam({weights.data(), first.data(), second.data(), g.data(), n, 0.9F, 0.1F, 0.999F, 0.001F, 0.01F, 1000.0F,
                1e-8F});
      };
      run(fast, w, m, v);
      run(strict_kernels<float>(), w2, m2, v2);
    }
    expect_near(w, w2, 2e-7F, text_of(fast.kind));
    for (std::size_t i = 0; i < 16; ++i) EXPECT_EQ(w[i], before[i]) << "a parameter without gradient stays";
  }
}

/// What a product of random numbers and its ending give.
std::vector<float> product_of(const Kernels<float>& kernels, int rows, int cols, int stride, int mode) {
  SplitMix64 generator(static_cast<std::uint64_t>(rows * 1000 + cols * 10 + mode));
  const int depth = std::min(stride, rows + 3);
  const std::vector<float> x = random(static_cast<std::size_t>(rows * stride), generator);
  const std::vector<float> w = random(static_cast<std::size_t>(depth * cols), generator);
  const std::vector<float> bias = random(static_cast<std::size_t>(cols), generator);
  const std::vector<float> gate = random(static_cast<std::size_t>(rows * cols), generator);
  std::vector<float> out = random(static_cast<std::size_t>(rows * cols), generator);
  ProductArgs<float> p{x.data(), stride, w.data(), cols, out.data(), cols, rows, depth, cols};
  if (mode == 1 || mode == 2) p.bias = bias.data();
  p.leaky = mode == 2;
  if (mode >= 3) p.gate = mode == 5 ? out.data() : gate.data();
  p.gate_stride = cols;
  p.accumulate = mode == 4;
  kernels.product(p);
  return out;
}

/// Weights and moments after three steps of Adam on gradients of many magnitudes, some of them 0.
std::vector<float> adam_of(const Kernels<float>& kernels) {
  constexpr std::size_t n = 512;
  SplitMix64 generator(8);
  std::vector<float> w = random(3 * n, generator), g(n);
  std::fill(w.begin() + n, w.end(), 0.0F);
  for (std::size_t i = 16; i < n; ++i)
    g[i] = static_cast<float>(generator.symmetric() * std::pow(10.0, -12 * generator.uniform()));
  for (int step = 0; step < 3; ++step)
    kernels.adam(
        {w.data(), w.data() + n, w.data() + 2 * n, g.data(), n, 0.9F, 0.1F, 0.999F, 0.001F, 0.01F, 1000.0F, 1e-8F});
  return w;
}

TEST(Kernels, StrictOnesGiveTheSameBitsByVectorsOfEveryWidth) {
  const Kernels<float> narrow = strict_kernels_by(KernelKind::strict);
  for (const KernelKind width : {KernelKind::avx2, KernelKind::avx512}) {
    const Kernels<float> wide = strict_kernels_by(width);
    EXPECT_EQ(wide.kind, KernelKind::strict);
    if (!cpu_has(width)) continue;
    EXPECT_NE(wide.product, narrow.product) << text_of(width);
    for (int rows = 1; rows <= tile_samples; ++rows)
      for (const int cols : {16, 32, 48, 64})
        for (const int stride : {64, 32, 21})
          for (int mode = 0; mode < 6; ++mode)
            ASSERT_EQ(product_of(wide, rows, cols, stride, mode), product_of(narrow, rows, cols, stride, mode))
                << text_of(width) << ' ' << rows << " x " << cols << ", stride " << stride << ", ending " << mode;
    SplitMix64 generator(6);
    for (const int samples : {1, 2, 7, 96})
      for (int rows = 1; rows <= 64; rows += 3)
        for (const int cols : {16, 32, 48, 64}) {
          const std::vector<float> d = random(static_cast<std::size_t>(samples * 64), generator);
          const std::vector<float> x = random(static_cast<std::size_t>(samples * cols), generator);
          std::vector<float> g(static_cast<std::size_t>(rows * cols), 0.5F), expected = g;
          wide.outer({d.data(), 64, x.data(), cols, g.data(), cols, samples, rows, cols});
          narrow.outer({d.data(), 64, x.data(), cols, expected.data(), cols, samples, rows, cols});
          ASSERT_EQ(g, expected) << text_of(width) << ' ' << samples << ' ' << rows << " x " << cols;
        }
    ASSERT_EQ(adam_of(wide), adam_of(narrow)) << text_of(width);
  }
}

/// FNV-1a over the bits of all weights.
template <class Scalar>
std::uint64_t digest(const NetworkWeights<FiveZone, Scalar>& weights) {
  std::uint64_t hash = 0xcbf29ce484222325u;
  for (const Scalar value : weights.flat()) {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    for (int shift = 0; shift < 32; shift += 8) hash = (hash ^ (bits >> shift & 0xff)) * 0x100000001b3u;
  }
  return hash;
}

void expect_the_bits_of_all_machines(const Kernels<float>& kernels) {
  constexpr int n = 100;
  const auto weights = std::make_unique<NetworkWeights<FiveZone, float>>();
  const auto learner = std::make_unique<Learner<FiveZone, float>>();
  const auto scratch = std::make_unique<NetworkScratch<FiveZone, float>>();
  SplitMix64 generator(9);
  scratch->kernels = kernels;
  initialise_uniform(*weights, generator);
  learner->reset(*weights);
  const std::vector<float> rows = random(static_cast<std::size_t>(n * Layout<FiveZone>::transition), generator);
  LearnerSettings<FiveZone> settings;
  settings.sync_every = 7;
  for (int step = 0; step < 30; ++step) learner->step(*weights, {rows.data(), nullptr, n}, settings, *scratch);
  // Measured equal with GCC 12 and clang 14 on x86-64, and with GCC 12 on arm64 and armhf.
  EXPECT_EQ(digest(*weights), 11018313918926906046u);
}

TEST(Kernels, StrictTrainingGivesTheSameBitsOnEveryCompilerAndArchitecture) {
  for (const KernelKind width : {KernelKind::strict, KernelKind::avx2, KernelKind::avx512})
    expect_the_bits_of_all_machines(strict_kernels_by(width));
}

}  // namespace
}  // namespace airside
