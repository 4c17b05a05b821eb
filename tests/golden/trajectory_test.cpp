// Adam and target network over many steps: a fixed batch, early synchronisation, and draws from the replay ring.

#include <functional>

#include "golden_files.hpp"

namespace airside::golden {
namespace {

template <class Scalar>
using BatchOfStep = std::function<BatchView<FiveZone, Scalar>(int step)>;

/// Trains as the reference did and hands weights and learner to `at_mark` after each step that the file describes.
template <class Scalar>
void follow(
    const std::string& file, Kernels<Scalar> kernels, const BatchOfStep<Scalar>& batch_of, double loss_tolerance,
    const std::function<void(const std::string& step, const json& expected, const NetworkWeights<FiveZone, Scalar>&,
                             const Learner<FiveZone, Scalar>&)>& at_mark) {
  const json expected = read_json(file);
  auto weights = std::make_unique<NetworkWeights<FiveZone, Scalar>>(weights_of<Scalar>("weights"));
  auto learner = std::make_unique<Learner<FiveZone, Scalar>>();
  learner->reset(weights_of<Scalar>("target_weights"));
  const auto scratch = make_scratch<Scalar>(kernels);
  LearnerSettings<FiveZone> settings = settings_of_meta();
  settings.sync_every = expected.at("sync_every");
  int step = 0;
  int marks = 0;
  for (const json& losses : expected.at("losses_before_each_step")) {
    ++step;
    const LossTerms got = learner->step(*weights, batch_of(step), settings, *scratch);
    ASSERT_LT(error_of(got.total, losses.at("total")), loss_tolerance) << file << " step " << step;
    ASSERT_LT(error_of(got.gc, losses.at("gc")), loss_tolerance) << file << " step " << step;
    ASSERT_LT(error_of(got.tdb, losses.at("tdb")), loss_tolerance) << file << " step " << step;
    const std::string name = std::to_string(step);
    if (!expected.at("after_step").contains(name)) continue;
    ++marks;
    at_mark(name, expected.at("after_step").at(name), *weights, *learner);
  }
  EXPECT_EQ(marks, static_cast<int>(expected.at("after_step").size())) << file;
}

void follow_in_double(const std::string& file, const BatchOfStep<double>& batch_of) {
  follow<double>(
      file, strict_kernels<double>(), batch_of, 1e-12,
      [&](const std::string& step, const json& expected, const auto& weights, const auto& learner) {
        EXPECT_LT(checksum_error(weights, expected.at("eval")), 1e-12) << file << " step " << step;
        for (std::size_t l = 0; l < layer_count; ++l) {
          const std::string name = meta().at("layers")[l][0];
          EXPECT_LT(error_of(abs_sum(learner.target(), l, false), expected.at("target_abs_sum").at(name + ".w")),
                    1e-12);
          EXPECT_LT(error_of(abs_sum(learner.target(), l, true), expected.at("target_abs_sum").at(name + ".b")), 1e-12);
        }
      });
}

TEST(GoldenTrajectory, FixedBatchWithOneSynchronisation) {
  const std::vector<double> rows = make_batch("batch1000", 1000);
  follow_in_double("traj_b1000.json", [&](int) { return view_of(rows); });
}

TEST(GoldenTrajectory, SmallBatchWithEarlySynchronisation) {
  const std::vector<double> rows = make_batch("batch32", 32);
  follow_in_double("traj_b32_sync7.json", [&](int) { return view_of(rows); });
}

TEST(GoldenTrajectory, EveryWeightAfterTwentyStepsAgrees) {
  const std::vector<double> rows = make_batch("batch32", 32);
  const std::vector<double> expected = read_csv("weights_b32_sync7_step20.csv");
  follow<double>(
      "traj_b32_sync7.json", strict_kernels<double>(), [&](int) { return view_of(rows); }, 1e-12,
      [&](const std::string& step, const json&, const auto& weights, const auto&) {
        if (step != "20") return;
        for (std::size_t i = 0; i < expected.size(); ++i)
          ASSERT_LT(error_of(weights.values[i], expected[i]), 1e-12) << i;
      });
}

/// The replay ring filled with the reference's rows, and the draws of its sampler.
template <class Scalar>
struct ReplayDraws {
  using Ring = ReplayRing<FiveZone, Scalar>;
  std::unique_ptr<Ring> ring = std::make_unique<Ring>();
  SplitMix64 sampler{seed("replay_sampler")};
  std::vector<std::uint32_t> index = std::vector<std::uint32_t>(1000);

  ReplayDraws() {
    const std::vector<Scalar> rows = as<Scalar>(make_batch("replay", replay_capacity));
    for (std::size_t r = 0; r < replay_capacity; ++r) {
      typename Ring::Row row;
      std::copy_n(rows.begin() + static_cast<std::ptrdiff_t>(r * row.size()), row.size(), row.begin());
      ring->push(row);
    }
  }
  BatchView<FiveZone, Scalar> draw() {
    ring->sample_with_replacement(sampler, index);
    return ring->view(index);
  }
};

TEST(GoldenTrajectory, ReplayRingHoldsAndDrawsTheSameRows) {
  ReplayDraws<double> replay;
  const json expected = read_json("replay_check.json");
  for (std::size_t c = 0; c < Layout<FiveZone>::transition; ++c) {
    EXPECT_EQ(replay.ring->slot(0)[c], expected.at("row0")[c].get<double>());
    EXPECT_EQ(replay.ring->newest(0)[c], expected.at("row_last")[c].get<double>());
    double sum = 0;
    for (int r = 0; r < replay_capacity; ++r) sum += replay.ring->slot(r)[c];
    EXPECT_LT(error_of(sum, expected.at("col_sum")[c]), 1e-11);
  }
  replay.draw();
  for (std::size_t i = 0; i < 16; ++i)
    EXPECT_EQ(replay.index[i], expected.at("first16_indices_step1")[i].get<std::uint32_t>());
}

TEST(GoldenTrajectory, BatchesDrawnFromTheReplayRing) {
  ReplayDraws<double> replay;
  follow_in_double("traj_replay.json", [&](int) { return replay.draw(); });
}

/// The float reference's own drift from double is the yardstick. `flips` is what a pre-activation on the other side of
/// its kink may add once training has run on from there; with 1000 samples a batch, some seeds have one at once.
void follow_in_float(const std::string& file, const Kernels<float>& kernels, double flips,
                     const BatchOfStep<float>& batch_of) {
  follow<float>(
      file, kernels, batch_of, 2e-2,
      [&](const std::string& step, const json& expected, const auto& weights, const auto&) {
        std::vector<double> errors;
        for (std::size_t l = 0; l < layer_count; ++l) {
          const std::string name = meta().at("layers")[l][0];
          for (const bool bias : {false, true}) {
            const json& tensor = expected.at("eval").at(name + (bias ? ".b" : ".w"));
            const int begin = bias ? weights.layers[l].bias : weights.layers[l].weight;
            for (std::size_t i = 0; i < tensor.at("idx").size(); ++i) {
              const std::size_t at = static_cast<std::size_t>(begin) + tensor.at("idx")[i].template get<std::size_t>();
              errors.push_back(
                  std::abs(static_cast<double>(weights.values[at]) - tensor.at("val")[i].template get<double>()));
            }
          }
        }
        const json& guide = expected.at("float32_oracle_abs_err");
        EXPECT_LT(quantile(errors, 0.99), 8 * guide.at("p99").get<double>() + (step == "1" ? 1e-6 : flips))
            << file << " step " << step << " " << text_of(kernels.kind);
        EXPECT_LT(quantile(errors, 0.5), 8 * guide.at("mean").get<double>() + (step == "1" ? 1e-7 : flips / 8))
            << file << " step " << step << " " << text_of(kernels.kind);
      });
}

TEST(GoldenTrajectory, FloatStaysAsNearAsTheFloatReferenceWithEveryKernel) {
  const std::vector<float> large = as<float>(make_batch("batch1000", 1000));
  const std::vector<float> small = as<float>(make_batch("batch32", 32));
  for (const Kernels<float>& kernels : all_float_kernels()) {
    follow_in_float("traj_b32_sync7.json", kernels, 1e-4, [&](int) { return view_of(small); });
    follow_in_float("traj_b1000.json", kernels, 2e-3, [&](int) { return view_of(large); });
    ReplayDraws<float> replay;
    follow_in_float("traj_replay.json", kernels, 5e-4, [&](int) { return replay.draw(); });
  }
}

}  // namespace
}  // namespace airside::golden
