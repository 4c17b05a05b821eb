// Adam and target network over many steps: a fixed batch, early synchronisation, and draws from the replay ring.

#include <functional>
#include <utility>

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

// ------------------------------------------------------------------ float beside double

/// On which side of its kink everything that has one lies, over the batch: LeakyReLU's pre-activations, the gradient
/// constraint's active inputs, the residual constraint's sign of D'. The scratch holds them tile by tile.
template <class Scalar>
std::vector<bool> sides(const NetworkWeights<FiveZone, Scalar>& weights, const Learner<FiveZone, Scalar>& learner,
                        const BatchView<FiveZone, Scalar>& batch, const LossSettings<FiveZone>& settings,
                        NetworkScratch<FiveZone, Scalar>& s) {
  std::vector<bool> above;
  LossTerms sum;
  begin_batch(weights, s);
  for (int first = 0; first < batch.size; first += tile_samples) {
    const int n = std::min(tile_samples, batch.size - first);
    tile_losses(weights, learner.target(), batch, first, n, settings, s, sum);
    const auto add = [&](const auto& rows, int from, int width) {
      for (int r = 0; r < n; ++r)
        for (int c = 0; c < width; ++c) above.push_back(rows.row(from + r)[c] > 0);
    };
    const auto add_all = [&](const auto&... layer) { (add(layer, 0, layer.width), ...); };
    const auto& a = s.act;
    add_all(a.enc_s, a.enc_a, a.joint, a.share_0, a.share_1, a.share_2, a.strb_0, a.strb_1, a.tdb_0, a.tdb_1);
    add(s.deviation, 0, Layout<FiveZone>::rooms);
    // The constraint's seeds v, 0 where it holds and -L_j where not, stand behind the inputs.
    for (const double sign : {1.0, -1.0}) {
      for (int r = 0; r < n; ++r) {
        for (int j = 0; j < Layout<FiveZone>::signals; ++j)
          above.push_back(sign * static_cast<double>(a.input_s.row(n + r)[j]) > 0);
        above.push_back(sign * static_cast<double>(a.input_a.row(n + r)[Layout<FiveZone>::exogenous]) > 0);
      }
    }
  }
  return above;
}

template <class Scalar>
struct Training {
  Kernels<Scalar> kernels;
  std::unique_ptr<NetworkWeights<FiveZone, Scalar>> weights =
      std::make_unique<NetworkWeights<FiveZone, Scalar>>(weights_of<Scalar>("weights"));
  std::unique_ptr<Learner<FiveZone, Scalar>> learner = std::make_unique<Learner<FiveZone, Scalar>>();
  std::unique_ptr<NetworkScratch<FiveZone, Scalar>> scratch = make_scratch<Scalar>(kernels);
  bool turned = false;  ///< something has stood on the other side of its kink than in double
  double most_off = 0;  ///< of all weights, at the last mark

  explicit Training(const Kernels<Scalar>& k) : kernels(k) { learner->reset(weights_of<Scalar>("target_weights")); }
  LossTerms step(const BatchView<FiveZone, Scalar>& batch, const LearnerSettings<FiveZone>& settings) {
    return learner->step(*weights, batch, settings, *scratch);
  }
};

/// What float may be off after `step` steps of a batch of `samples`, and why. In 80 seeds with three kernel sets each,
/// the largest found was two thirds of these bounds or less, where nothing else is said.
struct Allowed {
  double mean, p99, most, loss;
};

/// As long as every kink is on the same side as in double, only rounding differs. A weight below 1 is stored to 3e-8
/// and written once a step, which adds up as a random walk: 4.5e-8 sqrt(step) for 99 of 100 weights (2e-7 after 20
/// steps). Adam divides by the gradient's size: where that is next to zero its rounding counts whole, so `most` is of
/// the weights whose gradient was never within 1e-5 of zero; at the first step, where the size cancels, these are exact
/// to 5.2e-8, later one weight of a batch may be off by 2.6e-6.
Allowed rounding(int step) {
  const double walk = std::sqrt(static_cast<double>(step));
  return {2e-8 * walk, 4.5e-8 * walk, step == 1 ? 1e-7 : 1e-5, 2e-6};
}

/// One sample on the other side of one kink alters the gradient by a share that training then follows and enlarges: the
/// bounds are shares of the way that Adam goes, one learning rate a step. In a batch of 1000 that is one sample in 1000
/// (loss_1000.json: a pre-activation 1.35e-7 from its kink, which the reference's own float run has on the other side
/// from its first step, p99 0.9 % of the way after 110), in one of 32 one in 32. A weight whose gradient changes its
/// sign at the first step goes the other way: two learning rates.
Allowed turned_kink(int step, int samples, double rate) {
  const double way = rate * step;
  const bool few = samples < 100;
  return {(few ? 0.02 : 0.004) * way, (few ? 0.1 : 0.03) * way, 2.1 * rate + (few ? 0.25 : 0.1) * way,
          few ? 0.1 : 0.01};
}

void expect_allowed(const std::string& where, Training<float>& run, const Training<double>& exact,
                    const std::vector<double>& least_gradient, const Allowed& allowed) {
  std::vector<double> errors;
  double sum = 0, most = 0;
  for (std::size_t i = 0; i < exact.weights->flat().size(); ++i) {
    errors.push_back(std::abs(static_cast<double>(run.weights->values[i]) - exact.weights->values[i]));
    sum += errors.back();
    if (run.turned || least_gradient[i] >= 1e-5) most = std::max(most, errors.back());
  }
  EXPECT_LT(sum / static_cast<double>(errors.size()), allowed.mean) << where;
  run.most_off = quantile(errors, 1);
  EXPECT_LT(quantile(errors, 0.99), allowed.p99) << where;
  EXPECT_LT(most, allowed.most) << where;
  if (!run.turned) {
    EXPECT_LT(run.most_off, 2.1e-3) << where << ": two learning rates, whatever the gradient";
  }
}

/// Trains with every float kernel beside double, which is itself compared with the file, and compares all weights and
/// the losses. `batch_of()` is the next batch, in double and in float. Returns the float runs.
template <class BatchOf>
std::vector<Training<float>> follow_in_float(const std::string& file, int samples, const BatchOf& batch_of) {
  const json expected = read_json(file);
  LearnerSettings<FiveZone> settings = settings_of_meta();
  settings.sync_every = expected.at("sync_every");
  Training<double> exact(strict_kernels<double>());
  std::vector<Training<float>> runs;
  for (const Kernels<float>& kernels : all_float_kernels()) runs.emplace_back(kernels);
  std::vector<double> least_gradient(exact.weights->flat().size(), HUGE_VAL);
  int step = 0;
  for (const json& losses : expected.at("losses_before_each_step")) {
    ++step;
    const auto& [double_batch, float_batch] = batch_of();
    const std::vector<bool> right = sides(*exact.weights, *exact.learner, double_batch, settings.loss, *exact.scratch);
    (void)exact.step(double_batch, settings);
    for (std::size_t i = 0; i < least_gradient.size(); ++i)
      least_gradient[i] = std::min(least_gradient[i], std::abs(exact.scratch->gradient.values[i]));
    const std::string name = std::to_string(step);
    const bool is_mark = expected.at("after_step").contains(name);
    if (is_mark) {
      EXPECT_LT(checksum_error(*exact.weights, expected.at("after_step").at(name).at("eval")), 1e-12) << file << name;
    }
    for (Training<float>& run : runs) {
      run.turned = run.turned || sides(*run.weights, *run.learner, float_batch, settings.loss, *run.scratch) != right;
      const LossTerms got = run.step(float_batch, settings);
      const Allowed allowed = run.turned ? turned_kink(step, samples, settings.adam.learning_rate) : rounding(step);
      const std::string where = file + " step " + name + " " + text_of(run.kernels.kind);
      EXPECT_LT(error_of(got.total, losses.at("total")), allowed.loss) << where;
      EXPECT_LT(error_of(got.gc, losses.at("gc")), allowed.loss) << where;
      EXPECT_LT(error_of(got.tdb, losses.at("tdb")), allowed.loss) << where;
      if (is_mark) expect_allowed(where, run, exact, least_gradient, allowed);
    }
  }
  return runs;
}

template <class Scalar>
using View = BatchView<FiveZone, Scalar>;

TEST(FloatTrajectory, SmallBatchStaysWithinRounding) {
  const std::vector<double> rows = make_batch("batch32", 32);
  const std::vector<float> float_rows = as<float>(rows);
  const auto runs = follow_in_float("traj_b32_sync7.json", 32, [&] {
    return std::pair<View<double>, View<float>>(view_of(rows), view_of(float_rows));
  });
  constexpr std::uint64_t own_seed = 0x5EED0001;  // no kink and no zero of a gradient is near
  if (seed("weights") != own_seed) return;
  for (const Training<float>& run : runs) {
    EXPECT_FALSE(run.turned) << text_of(run.kernels.kind);
    EXPECT_LT(run.most_off, 2e-7) << text_of(run.kernels.kind) << ": golden/README, \"max error 2e-7 at step 20\"";
  }
}

TEST(FloatTrajectory, LargeBatchStaysWithinRoundingUntilAKinkTurns) {
  const std::vector<double> rows = make_batch("batch1000", 1000);
  const std::vector<float> float_rows = as<float>(rows);
  (void)follow_in_float("traj_b1000.json", 1000,
                        [&] { return std::pair<View<double>, View<float>>(view_of(rows), view_of(float_rows)); });
}

TEST(FloatTrajectory, BatchesFromTheReplayRingStayWithinRoundingUntilAKinkTurns) {
  ReplayDraws<double> replay;
  ReplayDraws<float> float_replay;
  (void)follow_in_float("traj_replay.json", 1000, [&] {
    const View<double> drawn = replay.draw();
    return std::pair<View<double>, View<float>>(drawn, float_replay.draw());
  });
}

}  // namespace
}  // namespace airside::golden
