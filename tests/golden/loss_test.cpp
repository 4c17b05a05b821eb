// Every loss term and its gradient.

#include "golden_files.hpp"

namespace airside::golden {
namespace {

struct Term {
  const char* name;
  LossWeights weights;
  double LossTerms::*value;
};

const std::vector<Term>& terms() {
  static const std::vector<Term> all = {
      {"strb", {1, 0, 0, 0, 0}, &LossTerms::strb}, {"tdb", {0, 1, 0, 0, 0}, &LossTerms::tdb},
      {"gc", {0, 0, 1, 0, 0}, &LossTerms::gc},     {"rc", {0, 0, 0, 1, 0}, &LossTerms::rc},
      {"rec", {0, 0, 0, 0, 1}, &LossTerms::rec},   {"total", settings_of_meta().loss.weights, &LossTerms::total}};
  return all;
}

template <class Scalar>
LossTerms gradient_of(int n, const LossWeights& w, NetworkScratch<FiveZone, Scalar>& scratch) {
  LossSettings<FiveZone> settings = settings_of_meta().loss;
  settings.weights = w;
  const std::vector<Scalar> rows = as<Scalar>(make_batch("batch" + std::to_string(n), n));
  return batch_gradient(weights_of<Scalar>("weights"), weights_of<Scalar>("target_weights"), view_of(rows), settings,
                        scratch);
}

TEST(GoldenLoss, DoubleTermsAndTheirGradientsAgreeToTwelveDigits) {
  const auto scratch = make_scratch<double>();
  for (const int n : {1, 32, 1000}) {
    const json expected = read_json("loss_" + std::to_string(n) + ".json");
    for (const Term& term : terms()) {
      const LossTerms losses = gradient_of(n, term.weights, *scratch);
      EXPECT_LT(error_of(losses.*term.value, expected.at("terms").at(term.name)), 1e-12) << n << term.name;
      EXPECT_LT(checksum_error(scratch->gradient, expected.at("grad").at(term.name)), 1e-12) << n << term.name;
    }
  }
}

TEST(GoldenLoss, EvaluationWithoutGradientGivesTheSameLosses) {
  const auto scratch = make_scratch<double>();
  const json expected = read_json("loss_1000.json");
  const std::vector<double> rows = make_batch("batch1000", 1000);
  auto learner = std::make_unique<Learner<FiveZone, double>>();
  learner->reset(weights_of<double>("target_weights"));
  const LossTerms losses =
      learner->evaluate(weights_of<double>("weights"), view_of(rows), settings_of_meta().loss, *scratch);
  for (const Term& term : terms())
    EXPECT_LT(error_of(losses.*term.value, expected.at("terms").at(term.name)), 1e-12) << term.name;
}

TEST(GoldenLoss, OneTransitionHasItsOwnLoss) {
  const auto scratch = make_scratch<double>();
  const std::vector<double> row = make_batch("batch1", 1);
  auto learner = std::make_unique<Learner<FiveZone, double>>();
  learner->reset(weights_of<double>("target_weights"));
  constexpr std::size_t size = Layout<FiveZone>::transition;
  const LossTerms losses =
      learner->loss_of(weights_of<double>("weights"), std::span<const double, size>(row.data(), size),
                       settings_of_meta().loss, *scratch);
  EXPECT_LT(error_of(losses.total, read_json("loss_1.json").at("terms").at("total")), 1e-12);
}

TEST(GoldenLoss, FullGradientsAgreeParameterByParameter) {
  const auto scratch = make_scratch<double>();
  for (const auto& [file, weights] : {std::pair{"grad_total_32.csv", settings_of_meta().loss.weights},
                                      std::pair{"grad_gc_32.csv", LossWeights{0, 0, 1, 0, 0}}}) {
    gradient_of(32, weights, *scratch);
    const std::vector<double> expected = read_csv(file);
    ASSERT_EQ(expected.size(), scratch->gradient.flat().size());
    for (std::size_t i = 0; i < expected.size(); ++i)
      ASSERT_LT(error_of(scratch->gradient.values[i], expected[i]), 1e-12) << file << " " << i;
  }
}

TEST(GoldenLoss, FloatTermsAndGradientAgreeWithEveryKernel) {
  for (const Kernels<float>& kernels : all_float_kernels()) {
    const auto scratch = make_scratch<float>(kernels);
    const std::vector<double> expected = read_csv("grad_total_32.csv");
    gradient_of(32, settings_of_meta().loss.weights, *scratch);
    std::vector<double> errors;
    for (std::size_t i = 0; i < expected.size(); ++i)
      errors.push_back(std::abs(static_cast<double>(scratch->gradient.values[i]) - expected[i]));
    const json guide = read_json("loss_32.json").at("float32_closed_form_grad_max_abs_error");
    EXPECT_LT(quantile(errors, 0.999), 4 * guide.get<double>()) << text_of(kernels.kind);
    for (const int n : {1, 32, 1000}) {
      const json terms_expected = read_json("loss_" + std::to_string(n) + ".json").at("terms");
      const LossTerms losses = gradient_of(n, settings_of_meta().loss.weights, *scratch);
      for (const Term& term : terms())
        // Among 1000 samples one may lie so near a kink that its F, and only that, jumps in float.
        EXPECT_LT(error_of(losses.*term.value, terms_expected.at(term.name)), n == 1000 ? 1e-3 : 5e-6)
            << text_of(kernels.kind) << " " << n << " " << term.name;
    }
  }
}

}  // namespace
}  // namespace airside::golden
