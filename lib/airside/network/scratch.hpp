#pragma once
// Working memory of the network: one tile of samples with all its activations, and packed copies of weights.
// Owned by the caller, never saved; what it holds between calls changes no result.

#include <array>
#include <cstddef>

#include "airside/memory_size.hpp"
#include "airside/network/kernels/kernels.hpp"
#include "airside/network/network.hpp"
#include "airside/network/target_cache.hpp"
#include "airside/topology.hpp"

namespace airside {

constexpr int padded_columns(int columns) { return (columns + kernel_columns - 1) / kernel_columns * kernel_columns; }

/// One set of weights as the forward pass wants it: W^T, columns padded with zeros to the kernels' multiple.
/// Shape: layer l is inputs x padded(outputs) at `offset(l)`; then the decoder's padded bias.
template <Topology T, class Scalar>
struct PackedWeights {
  static constexpr int offset(Layer layer) {
    int at = 0;
    for (int l = 0; l < static_cast<int>(layer); ++l) {
      const LayerShape s = network_layers<T>()[static_cast<std::size_t>(l)];
      at += s.inputs * padded_columns(s.outputs) + padded_columns(s.outputs);
    }
    return at;
  }
  static constexpr int bias_offset(Layer layer) {
    return offset(layer) + layer_shape<T>(layer).inputs * padded_columns(layer_shape<T>(layer).outputs);
  }
  static constexpr int stored = bias_offset(Layer::dec) + padded_columns(Layout<T>::rooms);

  alignas(64) std::array<Scalar, static_cast<std::size_t>(stored)> values{};

  const Scalar* weight(Layer layer) const { return values.data() + offset(layer); }
  const Scalar* bias(Layer layer) const { return values.data() + bias_offset(layer); }
};

/// Rows of one tile at one place of the network. Shape: Rows x Width, rows contiguous.
template <class Scalar, int Rows, int Width>
struct TileRows {
  static constexpr int width = Width;
  alignas(64) std::array<Scalar, static_cast<std::size_t>(Rows) * static_cast<std::size_t>(Width)> values;

  Scalar* row(int r) { return values.data() + r * Width; }
  const Scalar* row(int r) const { return values.data() + r * Width; }
};

/// Activations of one forward pass. Rows 0..n-1 hold values; where Rows is twice a tile, rows n..n+m-1 hold the
/// tangents of the m samples that violate the gradient constraint (docs/method.md 4.4, step 4), so that one kernel call
/// sums both weight gradients.
template <Topology T, class Scalar, int Rows>
struct TileActivations {
  static constexpr int signals_width = padded_columns(Layout<T>::signals);
  static constexpr int exogenous_width = padded_columns(Layout<T>::exogenous + 1);

  TileRows<Scalar, Rows, signals_width> input_s;    ///< S E
  TileRows<Scalar, Rows, exogenous_width> input_a;  ///< E A
  TileRows<Scalar, Rows, encoder_width> enc_s, enc_a;
  TileRows<Scalar, Rows, share_width> joint;  ///< f_S f_A
  TileRows<Scalar, Rows, share_width> share_0, share_1, share_2;
  TileRows<Scalar, Rows, branch_width> strb_0;
  TileRows<Scalar, Rows, latent_width> strb_1;  ///< f_short
  TileRows<Scalar, tile_samples, branch_width> tdb_0;
  TileRows<Scalar, tile_samples, latent_width> tdb_1;  ///< f_res
};

/// Signals of the reverse pass, derivative with respect to pre-activations. Rows 0..n-1 of the loss, rows n..2n-1
/// of the sum of S' (docs/method.md 4.4, step 2); then rows n..n+m-1 those of the samples that violate the constraint.
template <class Scalar>
struct TileDeltas {
  static constexpr int rows = 2 * tile_samples;
  TileRows<Scalar, rows, encoder_width> enc_s, enc_a;
  TileRows<Scalar, rows, share_width> joint, share_0, share_1, share_2;
  TileRows<Scalar, rows, branch_width> strb_0;
  TileRows<Scalar, rows, latent_width> strb_1;
  TileRows<Scalar, tile_samples, branch_width> tdb_0;
  TileRows<Scalar, tile_samples, latent_width> tdb_1;
};

/// Rows of decoder outputs, or derivatives with respect to them.
template <Topology T, class Scalar>
using TileOutputs = TileRows<Scalar, tile_samples, padded_columns(Layout<T>::rooms)>;

/// Samples whose bootstrap targets stand side by side: a whole batch, in whole tiles.
constexpr int group_samples = (max_batch + tile_samples - 1) / tile_samples * tile_samples;

template <Topology T, class Scalar>
struct NetworkScratch {
  using Activations = TileActivations<T, Scalar, 2 * tile_samples>;

  Kernels<Scalar> kernels = strict_kernels<Scalar>();
  Shape site = capacity_of<T>();  ///< losses are means over its rooms

  /// Rooms of the site: the decoder's first outputs.
  int rooms() const { return rooms_of<T>(site); }

  /// The network that runs. In a batch the target network stands here first, then the one in training; between batches
  /// it is whatever its user packed last.
  PackedWeights<T, Scalar> packed;
  /// W of the two input layers with rows padded to the kernels' multiple, and their gradients.
  TileRows<Scalar, encoder_width, Activations::signals_width> weight_s, gradient_s;
  TileRows<Scalar, encoder_width, Activations::exogenous_width> weight_a, gradient_a;
  NetworkWeights<T, Scalar> gradient;

  Activations act;
  TileDeltas<Scalar> delta;
  TileOutputs<T, Scalar> short_term, deviation, reconstruction;
  TileOutputs<T, Scalar> d_short_term, d_deviation, d_reconstruction;
  /// Y of a group's samples. Shape: group_samples x rooms.
  std::array<Scalar, static_cast<std::size_t>(group_samples) * static_cast<std::size_t>(Layout<T>::rooms)> bootstrap;
  /// Y of the replay's slots, as far as it is still known.
  TargetCache<Scalar, Layout<T>::rooms, cached_targets> targets;
  /// Samples of the tile that violate the gradient constraint, in order.
  std::array<int, tile_samples> violating;
  /// dF by the two encoders' inputs.
  TileRows<Scalar, tile_samples, Activations::signals_width> slope_s;
  TileRows<Scalar, tile_samples, Activations::exogenous_width> slope_a;

  /// Y of sample i of the batch, while its group is at work.
  Scalar* bootstrap_of(int i) { return bootstrap.data() + i % group_samples * Layout<T>::rooms; }
};

}  // namespace airside
