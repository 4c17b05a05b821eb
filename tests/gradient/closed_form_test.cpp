// The long-term branch learns what can be written down (docs/method.md 4.3): for the plant s' = s + k (s_inf(a) - s),
// D = -g k (s_1 - s_inf) / (1 - g (1 - k)).

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "airside/learning/replay_ring.hpp"
#include "airside/network/learner.hpp"

namespace airside {
namespace {

TEST(LongTerm, TrainedDeviationApproachesTheClosedFormOfAFirstOrderPlant) {
  using L = Layout<ThreeVav>;
  constexpr double k = 0.4;
  constexpr double g = 0.5;
  constexpr int count = 2000;
  using Ring = ReplayRing<ThreeVav, float, count>;
  const auto ring = std::make_unique<Ring>();
  SplitMix64 generator(3);
  std::vector<double> closed_form;
  for (int n = 0; n < count; ++n) {
    Ring::Row row{};
    const double a = generator.symmetric();
    row[L::signals] = static_cast<float>(a);
    double mean = 0;
    for (std::size_t r = 0; r < L::rooms; ++r) {
      const double s = generator.symmetric();
      const double s1 = s + k * (a - s);
      row[r] = static_cast<float>(s);
      row[L::inputs + r] = static_cast<float>(s1);
      mean += -g * k * (s1 - a) / (1 - g * (1 - k)) / L::rooms;
    }
    closed_form.push_back(mean);
    ring->push(row);
  }

  const auto weights = std::make_unique<NetworkWeights<ThreeVav, float>>();
  const auto learner = std::make_unique<Learner<ThreeVav, float>>();
  const auto scratch = std::make_unique<NetworkScratch<ThreeVav, float>>();
  scratch->kernels = select_kernels<float>();
  initialise_uniform(*weights, generator);
  learner->reset(*weights);
  LearnerSettings<ThreeVav> settings;
  settings.loss.gamma = g;
  settings.loss.weights.gc = 0;
  settings.sync_every = 50;
  std::vector<std::uint32_t> index(64);
  for (int step = 0; step < 1500; ++step) {
    if (step == 1200) settings.adam.learning_rate = 2e-4;
    ring->sample(generator, index);
    learner->step(*weights, ring->view(index), settings, *scratch);
  }

  PackedWeights<ThreeVav, float> packed;
  pack(*weights, scratch->kernels, packed);
  double error = 0;
  double size = 0;
  for (int n = 0; n < count; ++n) {
    const auto& row = ring->slot(n);
    std::array<RoomForecast<ThreeVav, float>, 1> forecast;
    forecast_candidates(packed, std::span<const float, L::signals>(row.data(), L::signals),
                        std::span<const float>(&row[L::signals], 1), *scratch,
                        std::span<RoomForecast<ThreeVav, float>>(forecast));
    double mean = 0;
    for (const float d : forecast[0].deviation) mean += static_cast<double>(d) / L::rooms;
    error += std::abs(mean - closed_form[static_cast<std::size_t>(n)]) / count;
    size += std::abs(closed_form[static_cast<std::size_t>(n)]) / count;
  }
  EXPECT_LT(error, 0.1 * size) << "mean |D' - D| " << error << ", mean |D| " << size;
}

}  // namespace
}  // namespace airside
