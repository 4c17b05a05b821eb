// The generator, the initial weights and the layer table against the reference.

#include "golden_files.hpp"

namespace airside::golden {
namespace {

TEST(GoldenWeights, GeneratorGivesTheSameStream) {
  SplitMix64 generator(seed("weights"));
  for (const json& expected : meta().at("prng_first8_of_weights_seed"))
    EXPECT_EQ(std::to_string(generator.next()), expected.get<std::string>());
}

TEST(GoldenWeights, LayersHaveTheSameShapesInTheSameOrder) {
  using Weights = NetworkWeights<FiveZone, double>;
  ASSERT_EQ(meta().at("n_param").get<int>(), Weights::count);
  ASSERT_EQ(meta().at("layers").size(), Weights::layers.size());
  for (std::size_t l = 0; l < layer_count; ++l) {
    EXPECT_EQ(meta().at("layers")[l][1].get<int>(), Weights::layers[l].outputs) << l;
    EXPECT_EQ(meta().at("layers")[l][2].get<int>(), Weights::layers[l].inputs) << l;
  }
}

TEST(GoldenWeights, EveryInitialWeightIsEqualToTheLastBit) {
  const auto weights = weights_of<double>("weights");
  const std::vector<double> expected = read_csv("weights_eval.csv");
  ASSERT_EQ(expected.size(), weights.flat().size());
  for (std::size_t i = 0; i < expected.size(); ++i) ASSERT_EQ(weights.values[i], expected[i]) << i;
}

TEST(GoldenWeights, BothNetworksHaveTheirOwnStream) {
  const json check = read_json("weights_check.json");
  EXPECT_LT(checksum_error(weights_of<double>("weights"), check.at("eval")), 1e-12);
  EXPECT_LT(checksum_error(weights_of<double>("target_weights"), check.at("target")), 1e-12);
  EXPECT_GT(checksum_error(weights_of<double>("weights"), check.at("target")), 1e-3);
}

TEST(GoldenWeights, NamedViewsReadTheCanonicalArray) {
  auto weights = weights_of<double>("weights");
  EXPECT_EQ(weights.weight<Layer::enc_s_0>()(1, 2), weights.values[27]);
  EXPECT_EQ(weights.bias<Layer::enc_s_0>()(3), weights.values[803]);
  weights.weight<Layer::dec>()(4, 31) = 7;
  EXPECT_EQ(weights.values[28767], 7);
  EXPECT_EQ(weights.bias<Layer::dec>()(4), weights.flat().back());
}

}  // namespace
}  // namespace airside::golden
