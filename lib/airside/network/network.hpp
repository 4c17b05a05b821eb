#pragma once
// The network's shape and its weights: one flat array in one canonical order, with named views of every layer.
//
//   Enc_S : [S E] -> 32 -> 32 = f_S          P_share : [f_S f_A] -> 64 -> 64 -> 64 = z
//   Enc_A : [E A] -> 32 -> 32 = f_A          P_STRB  : z -> 64 -> 32 = f_short
//   Dec   : 32 -> rooms, shared              P_TDB   : z -> 64 -> 32 = f_res
//   S' = Dec(f_short)   D' = Dec(f_res + f_short) - S' = W_dec f_res   S^ = Dec(f_S)
// LeakyReLU after every layer but Dec.  Source: docs/method.md 3.2.

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>

#include "airside/splitmix64.hpp"
#include "airside/topology.hpp"

namespace airside {

constexpr int encoder_width = 32;  ///< f_S and f_A
constexpr int share_width = 64;    ///< concat(f_S, f_A) and every shared layer
constexpr int branch_width = 64;   ///< first layer of P_STRB and P_TDB
constexpr int latent_width = 32;   ///< what the decoder takes
static_assert(share_width == 2 * encoder_width && latent_width == encoder_width, "Dec takes f_S, f_short and f_res");

/// Layers in the canonical order of weights in files and generators.
enum class Layer : std::uint8_t {
  enc_s_0,
  enc_s_1,
  enc_a_0,
  enc_a_1,
  share_0,
  share_1,
  share_2,
  strb_0,
  strb_1,
  tdb_0,
  tdb_1,
  dec
};
constexpr int layer_count = 12;

/// One linear layer y = W x + b: W is outputs x inputs, row-major, at `weight`; b follows at `bias`.
struct LayerShape {
  int outputs, inputs, weight, bias;
};

/// All layers of topology T with their offsets in the flat array.
template <Topology T>
constexpr std::array<LayerShape, layer_count> network_layers() {
  using L = Layout<T>;
  std::array<LayerShape, layer_count> layers{{{encoder_width, L::signals, 0, 0},
                                              {encoder_width, encoder_width, 0, 0},
                                              {encoder_width, L::exogenous + 1, 0, 0},
                                              {encoder_width, encoder_width, 0, 0},
                                              {share_width, share_width, 0, 0},
                                              {share_width, share_width, 0, 0},
                                              {share_width, share_width, 0, 0},
                                              {branch_width, share_width, 0, 0},
                                              {latent_width, branch_width, 0, 0},
                                              {branch_width, share_width, 0, 0},
                                              {latent_width, branch_width, 0, 0},
                                              {L::rooms, latent_width, 0, 0}}};
  int at = 0;
  for (LayerShape& layer : layers) {
    layer.weight = at;
    layer.bias = at + layer.outputs * layer.inputs;
    at = layer.bias + layer.outputs;
  }
  return layers;
}

template <Topology T>
constexpr LayerShape layer_shape(Layer layer) {
  return network_layers<T>()[static_cast<std::size_t>(layer)];
}

/// All parameters of one network (or one number a parameter: moments, gradients).
/// Shape: `count` values in canonical order, then zeros up to a multiple of 64 bytes, so that there is no padding
/// and every layer starts on a cache line. Saved byte for byte.
template <Topology T, class Scalar>
struct NetworkWeights {
  static constexpr std::array<LayerShape, layer_count> layers = network_layers<T>();
  static constexpr int count = layers.back().bias + layers.back().outputs;
  static constexpr int line = 64 / static_cast<int>(sizeof(Scalar));
  static constexpr int stored = (count + line - 1) / line * line;

  alignas(64) std::array<Scalar, static_cast<std::size_t>(stored)> values{};

  std::span<Scalar, static_cast<std::size_t>(count)> flat() {
    return std::span(values).template first<static_cast<std::size_t>(count)>();
  }
  std::span<const Scalar, static_cast<std::size_t>(count)> flat() const {
    return std::span(values).template first<static_cast<std::size_t>(count)>();
  }

  template <Layer L>
  using Weight = Eigen::Matrix<Scalar, layer_shape<T>(L).outputs, layer_shape<T>(L).inputs, Eigen::RowMajor>;
  template <Layer L>
  using Bias = Eigen::Matrix<Scalar, layer_shape<T>(L).outputs, 1>;

  /// W of layer L. Shape: outputs x inputs.
  template <Layer L>
  Eigen::Map<Weight<L>> weight() {
    return Eigen::Map<Weight<L>>(values.data() + layer_shape<T>(L).weight);
  }
  template <Layer L>
  Eigen::Map<const Weight<L>> weight() const {
    return Eigen::Map<const Weight<L>>(values.data() + layer_shape<T>(L).weight);
  }
  /// b of layer L. Shape: outputs.
  template <Layer L>
  Eigen::Map<Bias<L>> bias() {
    return Eigen::Map<Bias<L>>(values.data() + layer_shape<T>(L).bias);
  }
  template <Layer L>
  Eigen::Map<const Bias<L>> bias() const {
    return Eigen::Map<const Bias<L>>(values.data() + layer_shape<T>(L).bias);
  }

  const Scalar* weight_of(Layer layer) const { return values.data() + layer_shape<T>(layer).weight; }
  const Scalar* bias_of(Layer layer) const { return values.data() + layer_shape<T>(layer).bias; }
  Scalar* weight_of(Layer layer) { return values.data() + layer_shape<T>(layer).weight; }
  Scalar* bias_of(Layer layer) { return values.data() + layer_shape<T>(layer).bias; }
};

static_assert(sizeof(NetworkWeights<FiveZone, float>) == sizeof(float) * NetworkWeights<FiveZone, float>::stored);

/// Inputs of a layer that a site of this shape has: those of the two encoders' first layers depend on it.
template <Topology T>
constexpr int inputs_of(const Shape& site, Layer layer) {
  if (layer == Layer::enc_s_0) return site.inputs() - 1;
  if (layer == Layer::enc_a_0) return site.inputs() - site.vavs;
  return layer_shape<T>(layer).inputs;
}

/// Whether input `i` of a layer is one that the site has.
template <Topology T>
constexpr bool has_input(const Shape& site, Layer layer, int i) {
  if (layer == Layer::enc_s_0) return is_present<T>(site, i);
  if (layer == Layer::enc_a_0) return is_present<T>(site, Layout<T>::rooms + i);
  return true;
}

/// Calls f(layer, index) for every parameter of the site's own network, in canonical order: all of an exact topology,
/// in a class those that an exact topology of this shape would have.
template <Topology T, class F>
constexpr void for_each_parameter(const Shape& site, F&& f) {
  for (int l = 0; l < layer_count; ++l) {
    const Layer layer = static_cast<Layer>(l);
    const LayerShape at = layer_shape<T>(layer);
    const int outputs = layer == Layer::dec ? site.vavs : at.outputs;
    for (int o = 0; o < outputs; ++o) {
      for (int i = 0; i < at.inputs; ++i) {
        if (has_input<T>(site, layer, i)) f(layer, at.weight + o * at.inputs + i);
      }
    }
    for (int o = 0; o < outputs; ++o) f(layer, at.bias + o);
  }
}

/// Number of parameters of the site's own network.
template <Topology T>
constexpr int parameters_of(const Shape& site) {
  int count = 0;
  for (int l = 0; l < layer_count; ++l) {
    const Layer layer = static_cast<Layer>(l);
    const int outputs = layer == Layer::dec ? site.vavs : layer_shape<T>(layer).outputs;
    count += outputs * (inputs_of<T>(site, layer) + 1);
  }
  return count;
}

static_assert(NetworkWeights<FiveZone, float>::count == 28773, "the method's network");
static_assert(parameters_of<UpTo32>(capacity_of<FiveZone>()) == 28773, "a class holds the networks of its shapes");

/// Draws all weights from one stream: W and b uniform in +-weight_gain/sqrt(fan_in), +-1/sqrt(fan_in); what the site
/// has no place for is 0, and stays so.
/// `weight_gain_squared` is 1 for the product, 6 for the golden vectors.
template <Topology T, class Scalar>
void initialise(NetworkWeights<T, Scalar>& weights, SplitMix64& generator, double weight_gain_squared,
                const Shape& site = capacity_of<T>()) {
  weights.values.fill(Scalar(0));
  for_each_parameter<T>(site, [&](Layer layer, int i) {
    const double fan_in = inputs_of<T>(site, layer);
    const double bound =
        i < layer_shape<T>(layer).bias ? std::sqrt(weight_gain_squared / fan_in) : 1.0 / std::sqrt(fan_in);
    weights.values[static_cast<std::size_t>(i)] = static_cast<Scalar>(generator.symmetric() * bound);
  });
}

/// Weights and biases uniform in +-1/sqrt(fan_in).  Source: docs/method.md, open point 6.
template <Topology T, class Scalar>
void initialise_uniform(NetworkWeights<T, Scalar>& weights, SplitMix64& generator,
                        const Shape& site = capacity_of<T>()) {
  initialise(weights, generator, 1.0, site);
}

/// Weights uniform in +-sqrt(6/fan_in), biases in +-1/sqrt(fan_in), as the golden vectors have them.
template <Topology T, class Scalar>
void initialise_golden(NetworkWeights<T, Scalar>& weights, SplitMix64& generator) {
  initialise(weights, generator, 6.0);
}

template <Topology T, class Scalar>
bool all_finite(const NetworkWeights<T, Scalar>& weights) {
  for (const Scalar value : weights.flat())
    if (!std::isfinite(value)) return false;
  return true;
}

}  // namespace airside
