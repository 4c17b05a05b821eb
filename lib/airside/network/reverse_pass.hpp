#pragma once
// The reverse and tangent passes of one tile, by hand. LeakyReLU networks are piecewise linear, so the gradient
// constraint needs no second derivative (docs/method.md 4.4):
//   delta_l = d(sum S')/d(pre-activation l), u_l = tangent of v after layer l:  dL_GC/dW_l = delta_l u_{l-1}^T.
// Rows 0..n-1 carry the losses' own gradient, rows n..n+m-1 that of the constraint, for the m samples that violate it:
// one product sums both.

#include <algorithm>
#include <array>
#include <cstddef>

#include "airside/network/kernels/kernels.hpp"
#include "airside/network/network.hpp"
#include "airside/network/scratch.hpp"
#include "airside/topology.hpp"

namespace airside {

/// dx = phi'(gate) * (start + dz W), W in its canonical layout: one step of the reverse pass.
/// Shape: dz rows x outputs; dx rows x inputs.
template <class Scalar>
void layer_reverse(const Kernels<Scalar>& kernels, int rows, const Scalar* dz, int dz_width, const Scalar* w,
                   int outputs, int inputs, Scalar* dx, int dx_stride, const Scalar* gate, bool accumulate = false) {
  ProductArgs<Scalar> p{dz, dz_width, w, inputs, dx, dx_stride, rows, outputs, inputs};
  p.accumulate = accumulate;
  p.gate = gate;
  p.gate_stride = dx_stride;
  kernels.product(p);
}

/// Reverse pass of the constraint rows n..2n-1: delta with the output seed ones, and F to slope_s, slope_a.
template <Topology T, class Scalar>
void constraint_reverse(const NetworkWeights<T, Scalar>& w, int n, NetworkScratch<T, Scalar>& s) {
  const Kernels<Scalar>& k = s.kernels;
  auto& d = s.delta;
  const auto& a = s.act;
  std::array<Scalar, latent_width> column_sum{};
  const Scalar* const dec = w.weight_of(Layer::dec);
  for (int o = 0; o < s.rooms(); ++o)
    for (int i = 0; i < latent_width; ++i) column_sum[static_cast<std::size_t>(i)] += dec[o * latent_width + i];
  std::array<Scalar, latent_width> column_below;
  for (std::size_t i = 0; i < latent_width; ++i) column_below[i] = static_cast<Scalar>(leaky_slope) * column_sum[i];
  for (int r = 0; r < n; ++r) {
    const Scalar* const activation = a.strb_1.row(r);
    Scalar* const delta = d.strb_1.row(n + r);
    for (std::size_t i = 0; i < latent_width; ++i) {
      const Scalar above = column_sum[i], below = column_below[i];
      delta[i] = activation[i] > 0 ? above : below;
    }
  }
  const auto back = [&](Layer layer, auto& dz, int column, auto& dx, const auto& gate) {
    const LayerShape shape = layer_shape<T>(layer);
    layer_reverse(k, n, dz.row(n) + column, dz.width, w.weight_of(layer), shape.outputs, shape.inputs, dx.row(n),
                  dx.width, gate.row(0));
  };
  back(Layer::strb_1, d.strb_1, 0, d.strb_0, a.strb_0);
  back(Layer::strb_0, d.strb_0, 0, d.share_2, a.share_2);
  back(Layer::share_2, d.share_2, 0, d.share_1, a.share_1);
  back(Layer::share_1, d.share_1, 0, d.share_0, a.share_0);
  back(Layer::share_0, d.share_0, 0, d.joint, a.joint);
  back(Layer::enc_s_1, d.joint, 0, d.enc_s, a.enc_s);
  back(Layer::enc_a_1, d.joint, encoder_width, d.enc_a, a.enc_a);
  k.product({d.enc_s.row(n), encoder_width, s.weight_s.row(0), s.weight_s.width, s.slope_s.row(0), s.slope_s.width, n,
             encoder_width, s.slope_s.width});
  k.product({d.enc_a.row(n), encoder_width, s.weight_a.row(0), s.weight_a.width, s.slope_a.row(0), s.slope_a.width, n,
             encoder_width, s.slope_a.width});
}

/// Reverse pass of the losses, rows 0..n-1, from scratch.d_*.
template <Topology T, class Scalar>
void losses_reverse(const NetworkWeights<T, Scalar>& w, int n, NetworkScratch<T, Scalar>& s) {
  const Kernels<Scalar>& k = s.kernels;
  auto& d = s.delta;
  const auto& a = s.act;
  constexpr int width = TileOutputs<T, Scalar>::width;
  const auto decoder = [&](const auto& dy, Scalar* dx, int stride, const Scalar* gate) {
    layer_reverse(k, n, dy.row(0), width, w.weight_of(Layer::dec), s.rooms(), latent_width, dx, stride, gate);
  };
  const auto back = [&](Layer layer, const auto& dz, int column, auto& dx, const Scalar* gate, bool accumulate) {
    const LayerShape shape = layer_shape<T>(layer);
    layer_reverse(k, n, dz.row(0) + column, dz.width, w.weight_of(layer), shape.outputs, shape.inputs, dx.row(0),
                  dx.width, gate, accumulate);
  };
  decoder(s.d_short_term, d.strb_1.row(0), latent_width, a.strb_1.row(0));
  decoder(s.d_deviation, d.tdb_1.row(0), latent_width, a.tdb_1.row(0));
  back(Layer::strb_1, d.strb_1, 0, d.strb_0, a.strb_0.row(0), false);
  back(Layer::tdb_1, d.tdb_1, 0, d.tdb_0, a.tdb_0.row(0), false);
  back(Layer::strb_0, d.strb_0, 0, d.share_2, nullptr, false);
  back(Layer::tdb_0, d.tdb_0, 0, d.share_2, a.share_2.row(0), true);
  back(Layer::share_2, d.share_2, 0, d.share_1, a.share_1.row(0), false);
  back(Layer::share_1, d.share_1, 0, d.share_0, a.share_0.row(0), false);
  decoder(s.d_reconstruction, d.joint.row(0), share_width, nullptr);
  for (int r = 0; r < n; ++r) std::fill_n(d.joint.row(r) + encoder_width, encoder_width, Scalar(0));
  back(Layer::share_0, d.share_0, 0, d.joint, a.joint.row(0), true);
  back(Layer::enc_s_1, d.joint, 0, d.enc_s, a.enc_s.row(0), false);
  back(Layer::enc_a_1, d.joint, encoder_width, d.enc_a, a.enc_a.row(0), false);
}

/// Moves the deltas of the m violating samples, and copies their activations, to rows n..n+m-1, where both are wanted:
/// the activations are the gates of the tangent pass until its results take their place.
/// Cost: copies of 840 numbers a sample; none where all violate.
template <Topology T, class Scalar>
void gather_violating(int n, int m, NetworkScratch<T, Scalar>& s) {
  const auto pick = [&](auto& rows, int from) {
    for (int i = 0; i < m; ++i) {
      const Scalar* const row = rows.row(from + s.violating[static_cast<std::size_t>(i)]);
      if (row != rows.row(n + i)) std::copy_n(row, rows.width, rows.row(n + i));
    }
  };
  const auto pick_all = [&](auto& of, int from) {
    pick(of.enc_s, from);
    pick(of.enc_a, from);
    pick(of.joint, from);
    pick(of.share_0, from);
    pick(of.share_1, from);
    pick(of.share_2, from);
    pick(of.strb_0, from);
    pick(of.strb_1, from);
  };
  pick_all(s.delta, n);
  pick_all(s.act, 0);
}

/// Tangent pass u_l = phi' (W_l u_{l-1}) from the m seeds in rows n..n+m-1 of the inputs.
/// Source: docs/method.md 4.4, step 4.
template <Topology T, class Scalar>
void constraint_tangent(int n, int m, NetworkScratch<T, Scalar>& s) {
  if (m == 0) return;
  const int gates = m < n ? n : 0;
  if (m < n) gather_violating(n, m, s);
  auto& a = s.act;
  const auto along = [&](Layer layer, const auto& x, auto& out, int column) {
    const LayerShape shape = layer_shape<T>(layer);
    ProductArgs<Scalar> p{x.row(n),  x.width, s.packed.weight(layer), shape.outputs, out.row(n) + column,
                          out.width, m,       shape.inputs,           shape.outputs};
    p.gate = out.row(gates) + column;
    p.gate_stride = out.width;
    s.kernels.product(p);
  };
  along(Layer::enc_s_0, a.input_s, a.enc_s, 0);
  along(Layer::enc_s_1, a.enc_s, a.joint, 0);
  along(Layer::enc_a_0, a.input_a, a.enc_a, 0);
  along(Layer::enc_a_1, a.enc_a, a.joint, encoder_width);
  along(Layer::share_0, a.joint, a.share_0, 0);
  along(Layer::share_1, a.share_0, a.share_1, 0);
  along(Layer::share_2, a.share_1, a.share_2, 0);
  along(Layer::strb_0, a.share_2, a.strb_0, 0);
  along(Layer::strb_1, a.strb_0, a.strb_1, 0);
}

}  // namespace airside
