// Batches made from seeds, and what the network says about them.

#include "golden_files.hpp"

namespace airside::golden {
namespace {

constexpr int transition = Layout<FiveZone>::transition;

TEST(GoldenBatch, RowsAndColumnSumsAgree) {
  const json check = read_json("batch_check.json");
  for (const int n : {1, 32, 1000}) {
    const json& expected = check.at(std::to_string(n));
    const std::vector<double> rows = make_batch("batch" + std::to_string(n), n);
    for (std::size_t r = 0; r < expected.at("rows").size(); ++r)
      for (std::size_t c = 0; c < transition; ++c)
        ASSERT_EQ(rows[r * transition + c], expected.at("rows")[r][c].get<double>()) << n << " " << r << " " << c;
    for (std::size_t c = 0; c < transition; ++c) {
      double sum = 0;
      for (std::size_t r = c; r < rows.size(); r += transition) sum += rows[r];
      ASSERT_LT(error_of(sum, expected.at("col_sum")[c]), 1e-12) << n << " " << c;
    }
  }
}

/// S' D' S^ Y F of every sample, 46 numbers each, through the tiles of the loss evaluation.
template <class Scalar>
std::vector<std::vector<double>> outputs_of(int n, Kernels<Scalar> kernels) {
  using L = Layout<FiveZone>;
  const auto weights = weights_of<Scalar>("weights");
  const auto target = weights_of<Scalar>("target_weights");
  const std::vector<Scalar> rows = as<Scalar>(make_batch("batch" + std::to_string(n), n));
  const auto scratch = make_scratch<Scalar>(kernels);
  std::vector<std::vector<double>> out;
  LossTerms sum;
  begin_batch(weights, *scratch);
  for (int first = 0; first < n; first += tile_samples) {
    const int count = std::min(tile_samples, n - first);
    tile_losses(weights, target, view_of(rows), first, count, settings_of_meta().loss, *scratch, sum);
    for (int r = 0; r < count; ++r) {
      std::vector<double> row;
      for (const Scalar* part : {scratch->short_term.row(r), scratch->deviation.row(r), scratch->reconstruction.row(r),
                                 scratch->bootstrap_of(first + r)})
        for (int i = 0; i < L::rooms; ++i) row.push_back(static_cast<double>(part[i]));
      for (int j = 0; j < L::inputs; ++j) {
        const double by_s = j < L::signals ? static_cast<double>(scratch->slope_s.row(r)[j]) : 0;
        const double by_a = j >= L::rooms ? static_cast<double>(scratch->slope_a.row(r)[j - L::rooms]) : 0;
        row.push_back(by_s + by_a);
      }
      out.push_back(row);
    }
  }
  return out;
}

/// All errors against forward_N.json.
std::vector<double> forward_errors(int n, const std::vector<std::vector<double>>& rows) {
  const json expected = read_json("forward_" + std::to_string(n) + ".json");
  std::vector<double> errors;
  for (std::size_t k = 0; k < expected.at("row_index").size(); ++k) {
    const auto& row = rows[expected.at("row_index")[k].get<std::size_t>()];
    EXPECT_EQ(row.size(), expected.at("rows")[k].size());
    for (std::size_t c = 0; c < row.size(); ++c) errors.push_back(error_of(row[c], expected.at("rows")[k][c]));
  }
  return errors;
}

TEST(GoldenForward, DoubleAgreesToTwelveDigits) {
  for (const int n : {1, 32, 1000})
    EXPECT_LT(quantile(forward_errors(n, outputs_of(n, strict_kernels<double>())), 1), 1e-12) << n;
}

TEST(GoldenForward, ColumnSumsOfTheLargeBatchAgree) {
  const auto rows = outputs_of(1000, strict_kernels<double>());
  const json expected = read_json("forward_1000.json");
  for (std::size_t c = 0; c < rows[0].size(); ++c) {
    double sum = 0, abs_sum = 0;
    for (const auto& row : rows) {
      sum += row[c];
      abs_sum += std::abs(row[c]);
    }
    EXPECT_LT(error_of(sum, expected.at("col_sum")[c]), 1e-12) << c;
    EXPECT_LT(error_of(abs_sum, expected.at("col_abs_sum")[c]), 1e-12) << c;
  }
}

TEST(GoldenForward, FloatAgreesWithEveryKernel) {
  for (const Kernels<float>& kernels : all_float_kernels())
    for (const int n : {1, 32, 1000})
      // F jumps where a pre-activation changes its side of the kink, so not the maximum but a quantile.
      EXPECT_LT(quantile(forward_errors(n, outputs_of(n, kernels)), 0.95), 2e-6) << text_of(kernels.kind) << " " << n;
}

TEST(GoldenForward, CandidatesSharingAStateGetTheSameForecastAsSamples) {
  using L = Layout<FiveZone>;
  const std::vector<double> rows = make_batch("batch1000", 100);
  const auto weights = weights_of<double>("weights");
  const auto scratch = make_scratch<double>();
  PackedWeights<FiveZone, double> packed;
  pack(weights, scratch->kernels, packed);
  std::vector<double> samples = rows, setpoints;
  for (std::size_t i = 0; i < 100; ++i) {
    std::copy_n(rows.begin(), L::signals, samples.begin() + static_cast<std::ptrdiff_t>(i * transition));
    setpoints.push_back(rows[i * transition + L::signals]);
  }
  std::vector<RoomForecast<FiveZone, double>> forecasts(100);
  forecast_candidates(packed, std::span<const double, L::signals>(rows.data(), L::signals),
                      std::span<const double>(setpoints), *scratch,
                      std::span<RoomForecast<FiveZone, double>>(forecasts));
  LossTerms sum;
  begin_batch(weights, *scratch);
  for (int first = 0; first < 100; first += tile_samples) {
    const int count = std::min(tile_samples, 100 - first);
    tile_losses(weights, weights, view_of(samples), first, count, {}, *scratch, sum);
    for (int r = 0; r < count; ++r)
      for (std::size_t i = 0; i < L::rooms; ++i) {
        const auto& f = forecasts[static_cast<std::size_t>(first + r)];
        EXPECT_NEAR(f.short_term[i], scratch->short_term.row(r)[i], 1e-12);
        EXPECT_NEAR(f.deviation[i], scratch->deviation.row(r)[i], 1e-12);
      }
  }
}

}  // namespace
}  // namespace airside::golden
