#pragma once
// The forward pass: over a tile of samples, and over many setpoints that share one state.

#include <algorithm>
#include <array>
#include <cstddef>
#include <span>

#include "airside/memory_size.hpp"
#include "airside/network/kernels/kernels.hpp"
#include "airside/network/network.hpp"
#include "airside/network/scratch.hpp"
#include "airside/topology.hpp"

namespace airside {

/// Copies `weights` into the layout of the forward pass.
/// Cost: about 5 us; needed once after the weights change.
template <Topology T, class Scalar>
void pack(const NetworkWeights<T, Scalar>& weights, const Kernels<Scalar>& kernels, PackedWeights<T, Scalar>& out) {
  using Packed = PackedWeights<T, Scalar>;
  for (int l = 0; l < layer_count; ++l) {
    const Layer layer = static_cast<Layer>(l);
    const LayerShape s = layer_shape<T>(layer);
    Scalar* const w = out.values.data() + Packed::offset(layer);
    kernels.transpose({weights.weight_of(layer), s.outputs, s.inputs, w, padded_columns(s.outputs)});
    std::copy_n(weights.bias_of(layer), s.outputs, out.values.data() + Packed::bias_offset(layer));
  }
}

/// out = phi(W x + b) for `rows` rows, LeakyReLU phi.  Source: docs/method.md 3.2.
template <Topology T, class Scalar>
void layer_forward(const Kernels<Scalar>& kernels, const PackedWeights<T, Scalar>& w, Layer layer, int rows,
                   const Scalar* x, int x_stride, Scalar* out, int out_stride) {
  const LayerShape s = layer_shape<T>(layer);
  ProductArgs<Scalar> p{x,          x_stride, w.weight(layer), padded_columns(s.outputs), out,
                        out_stride, rows,     s.inputs,        padded_columns(s.outputs)};
  p.bias = w.bias(layer);
  p.leaky = layer != Layer::dec;
  kernels.product(p);
}

/// From joint = [f_S f_A] on: P_share and both branches.
template <Topology T, class Scalar, int Rows>
void branches_forward(const Kernels<Scalar>& kernels, const PackedWeights<T, Scalar>& w, int rows,
                      TileActivations<T, Scalar, Rows>& a) {
  const auto run = [&](Layer layer, const auto& x, auto& out) {
    layer_forward(kernels, w, layer, rows, x.row(0), x.width, out.row(0), out.width);
  };
  run(Layer::share_1, a.share_0, a.share_1);
  run(Layer::share_2, a.share_1, a.share_2);
  run(Layer::strb_0, a.share_2, a.strb_0);
  run(Layer::strb_1, a.strb_0, a.strb_1);
  run(Layer::tdb_0, a.share_2, a.tdb_0);
  run(Layer::tdb_1, a.tdb_0, a.tdb_1);
}

/// All activations of `rows` samples whose inputs stand in a.input_s and a.input_a.
/// Cost: 28,500 multiply-adds a sample for FiveZone.
template <Topology T, class Scalar, int Rows>
void tile_forward(const Kernels<Scalar>& kernels, const PackedWeights<T, Scalar>& w, int rows,
                  TileActivations<T, Scalar, Rows>& a) {
  const auto run = [&](Layer layer, const auto& x, auto& out, int column) {
    layer_forward(kernels, w, layer, rows, x.row(0), x.width, out.row(0) + column, out.width);
  };
  run(Layer::enc_s_0, a.input_s, a.enc_s, 0);
  run(Layer::enc_s_1, a.enc_s, a.joint, 0);
  run(Layer::enc_a_0, a.input_a, a.enc_a, 0);
  run(Layer::enc_a_1, a.enc_a, a.joint, encoder_width);
  run(Layer::share_0, a.joint, a.share_0, 0);
  branches_forward(kernels, w, rows, a);
}

/// S' = W_dec f_short + b, D' = W_dec f_res (the bias cancels).
template <Topology T, class Scalar, int Rows>
void decode(const Kernels<Scalar>& kernels, const PackedWeights<T, Scalar>& w, int rows,
            const TileActivations<T, Scalar, Rows>& a, TileOutputs<T, Scalar>& short_term,
            TileOutputs<T, Scalar>& deviation) {
  constexpr int width = TileOutputs<T, Scalar>::width;
  layer_forward(kernels, w, Layer::dec, rows, a.strb_1.row(0), latent_width, short_term.row(0), width);
  kernels.product(
      {a.tdb_1.row(0), latent_width, w.weight(Layer::dec), width, deviation.row(0), width, rows, latent_width, width});
}

/// What the network foresees for one setpoint. Units: scaled (docs/method.md, open point 7).
template <Topology T, class Scalar>
struct RoomForecast {
  std::array<Scalar, Layout<T>::rooms> short_term;  ///< S', one cycle ahead
  std::array<Scalar, Layout<T>::rooms> deviation;   ///< D', long-term minus short-term
};

/// Forecasts of many setpoints in one state; the state's encoder, and its share of every first layer, run once.
/// Shape: signals = [S E]; out.size() >= setpoints.size().  Units: scaled.
/// Cost: 24,100 multiply-adds a setpoint for FiveZone, linear in setpoints.
template <Topology T, class Scalar>
void forecast_candidates(const PackedWeights<T, Scalar>& w, std::span<const Scalar, Layout<T>::signals> signals,
                         std::span<const Scalar> setpoints, NetworkScratch<T, Scalar>& scratch,
                         std::span<RoomForecast<T, Scalar>> out) {
  using L = Layout<T>;
  auto& a = scratch.act;
  const Kernels<Scalar>& k = scratch.kernels;
  alignas(64) std::array<Scalar, share_width> share_start;
  alignas(64) std::array<Scalar, encoder_width> enc_a_start;

  // f_S in row 0, then W_share [f_S 0] + b and W_a [E 0] + b, where every setpoint starts from.
  layer_forward(k, w, Layer::enc_s_0, 1, signals.data(), L::signals, a.enc_s.row(0), encoder_width);
  layer_forward(k, w, Layer::enc_s_1, 1, a.enc_s.row(0), encoder_width, a.joint.row(0), share_width);
  ProductArgs<Scalar> share{
      a.joint.row(0), share_width, w.weight(Layer::share_0), share_width, share_start.data(), share_width, 1,
      encoder_width,  share_width};
  share.bias = w.bias(Layer::share_0);
  k.product(share);
  ProductArgs<Scalar> first{signals.data() + L::rooms,
                            L::exogenous,
                            w.weight(Layer::enc_a_0),
                            encoder_width,
                            enc_a_start.data(),
                            encoder_width,
                            1,
                            L::exogenous,
                            encoder_width};
  first.bias = w.bias(Layer::enc_a_0);
  k.product(first);

  const int count = static_cast<int>(setpoints.size());
  for (int begin = 0; begin < count; begin += tile_samples) {
    const int rows = std::min(tile_samples, count - begin);
    ProductArgs<Scalar> setpoint{setpoints.data() + begin,
                                 1,
                                 w.weight(Layer::enc_a_0) + L::exogenous * encoder_width,
                                 encoder_width,
                                 a.enc_a.row(0),
                                 encoder_width,
                                 rows,
                                 1,
                                 encoder_width};
    setpoint.bias = enc_a_start.data();
    setpoint.leaky = true;
    k.product(setpoint);
    layer_forward(k, w, Layer::enc_a_1, rows, a.enc_a.row(0), encoder_width, a.joint.row(0) + encoder_width,
                  share_width);
    share = {a.joint.row(0) + encoder_width,
             share_width,
             w.weight(Layer::share_0) + encoder_width * share_width,
             share_width,
             a.share_0.row(0),
             share_width,
             rows,
             encoder_width,
             share_width};
    share.bias = share_start.data();
    share.leaky = true;
    k.product(share);
    branches_forward(k, w, rows, a);
    decode(k, w, rows, a, scratch.short_term, scratch.deviation);
    for (int r = 0; r < rows; ++r) {
      RoomForecast<T, Scalar>& forecast = out[static_cast<std::size_t>(begin + r)];
      std::copy_n(scratch.short_term.row(r), L::rooms, forecast.short_term.begin());
      std::copy_n(scratch.deviation.row(r), L::rooms, forecast.deviation.begin());
    }
  }
}

}  // namespace airside
