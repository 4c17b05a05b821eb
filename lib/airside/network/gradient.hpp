#pragma once
// Losses of a batch and the gradient of their weighted total, tile by tile: targets, forward pass, losses, the passes
// of reverse_pass.hpp, and the sums that they leave for each weight.

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "airside/memory_size.hpp"
#include "airside/network/forward.hpp"
#include "airside/network/kernels/kernels.hpp"
#include "airside/network/losses.hpp"
#include "airside/network/network.hpp"
#include "airside/network/reverse_pass.hpp"
#include "airside/network/scratch.hpp"
#include "airside/network/target_cache.hpp"
#include "airside/topology.hpp"

namespace airside {

/// Loads samples first .. first+rows-1 as network inputs: [S E], [E A].
template <Topology T, class Scalar>
void load_tile(const BatchView<T, Scalar>& batch, int first, int rows, NetworkScratch<T, Scalar>& s) {
  using L = Layout<T>;
  for (int r = 0; r < rows; ++r) {
    const Scalar* const sample = batch.row(first + r);
    std::copy_n(sample, L::signals, s.act.input_s.row(r));
    std::copy_n(sample + L::rooms, L::exogenous + 1, s.act.input_a.row(r));
  }
}

/// Y = g (F_TDB + F_STRB - S1) with the target network, which is the one packed, on (S1, E1, A): Dec(f_res + f_short)
/// is both. Shape: of the batch's samples `samples`, at most a tile.  Source: docs/method.md 4, term 2.
template <Topology T, class Scalar>
void bootstrap_tile(const BatchView<T, Scalar>& batch, std::span<const int> samples, double gamma,
                    NetworkScratch<T, Scalar>& s) {
  using L = Layout<T>;
  const int rows = static_cast<int>(samples.size());
  for (int r = 0; r < rows; ++r) {
    const Scalar* const sample = batch.row(samples[static_cast<std::size_t>(r)]);
    std::copy_n(sample + L::inputs, L::signals, s.act.input_s.row(r));
    std::copy_n(sample + L::inputs + L::rooms, L::exogenous, s.act.input_a.row(r));
    s.act.input_a.row(r)[L::exogenous] = sample[L::signals];
  }
  tile_forward(s.kernels, s.packed, rows, s.act);
  Scalar* const f_long = s.act.strb_1.row(0);
  const Scalar* const f_res = s.act.tdb_1.row(0);
  for (int i = 0; i < rows * latent_width; ++i) f_long[i] += f_res[i];
  constexpr int width = TileOutputs<T, Scalar>::width;
  layer_forward(s.kernels, s.packed, Layer::dec, rows, f_long, latent_width, s.short_term.row(0), width);
  const Scalar g = static_cast<Scalar>(gamma);
  for (int r = 0; r < rows; ++r) {
    const int sample = samples[static_cast<std::size_t>(r)];
    const Scalar* const s1 = batch.row(sample) + L::inputs;
    const Scalar* const later = s.short_term.row(r);
    Scalar* const y = s.bootstrap_of(sample);
    for (int i = 0; i < L::rooms; ++i) y[i] = g * (later[i] - s1[i]);
  }
}

/// bias += column sums of rows 0..n-1; sixteen sums at a time stay in registers.
template <class Scalar>
void add_column_sums(int n, int width, const Scalar* rows, int stride, Scalar* bias) {
  constexpr int at_once = 16;
  for (int left = width; left > 0; left -= at_once, rows += at_once, bias += at_once) {
    if (left < at_once) {
      for (int r = 0; r < n; ++r)
        for (int i = 0; i < left; ++i) bias[i] += rows[r * stride + i];
      break;
    }
    std::array<Scalar, at_once> sum;
    std::copy_n(bias, at_once, sum.data());
    for (int r = 0; r < n; ++r) {
      const Scalar* const row = rows + r * stride;
      for (int i = 0; i < at_once; ++i) sum[static_cast<std::size_t>(i)] += row[i];
    }
    std::copy_n(sum.data(), at_once, bias);
  }
}

/// Adds the weight gradients of one tile, n samples and the m that violate the constraint, to scratch.gradient (the
/// input layers' to gradient_s, gradient_a).
template <Topology T, class Scalar>
void accumulate_gradient(int n, int m, NetworkScratch<T, Scalar>& s) {
  const Kernels<Scalar>& k = s.kernels;
  const auto& d = s.delta;
  const auto& a = s.act;
  NetworkWeights<T, Scalar>& g = s.gradient;
  const auto add = [&](Layer layer, int samples, const auto& dz, int column, const auto& x, Scalar* weight, int cols) {
    const int outputs = layer_shape<T>(layer).outputs;
    k.outer({dz.row(0) + column, dz.width, x.row(0), x.width, weight, cols, samples, outputs, cols});
    add_column_sums(n, outputs, dz.row(0) + column, dz.width, g.bias_of(layer));
  };
  const auto add_both = [&](Layer layer, const auto& dz, int column, const auto& x) {
    add(layer, n + m, dz, column, x, g.weight_of(layer), layer_shape<T>(layer).inputs);
  };
  add(Layer::enc_s_0, n + m, d.enc_s, 0, a.input_s, s.gradient_s.row(0), s.gradient_s.width);
  add_both(Layer::enc_s_1, d.joint, 0, a.enc_s);
  add(Layer::enc_a_0, n + m, d.enc_a, 0, a.input_a, s.gradient_a.row(0), s.gradient_a.width);
  add_both(Layer::enc_a_1, d.joint, encoder_width, a.enc_a);
  add_both(Layer::share_0, d.share_0, 0, a.joint);
  add_both(Layer::share_1, d.share_1, 0, a.share_0);
  add_both(Layer::share_2, d.share_2, 0, a.share_1);
  add_both(Layer::strb_0, d.strb_0, 0, a.share_2);
  add_both(Layer::strb_1, d.strb_1, 0, a.strb_0);
  add(Layer::tdb_0, n, d.tdb_0, 0, a.share_2, g.weight_of(Layer::tdb_0), share_width);
  add(Layer::tdb_1, n, d.tdb_1, 0, a.tdb_0, g.weight_of(Layer::tdb_1), branch_width);

  // Dec: three uses, its bias in two of them, and the constraint's seed ones times the last tangent.
  const int rooms = s.rooms();
  constexpr int width = TileOutputs<T, Scalar>::width;
  Scalar* const dec = g.weight_of(Layer::dec);
  k.outer({s.d_short_term.row(0), width, a.strb_1.row(0), latent_width, dec, latent_width, n, rooms, latent_width});
  k.outer({s.d_deviation.row(0), width, a.tdb_1.row(0), latent_width, dec, latent_width, n, rooms, latent_width});
  k.outer({s.d_reconstruction.row(0), width, a.joint.row(0), share_width, dec, latent_width, n, rooms, latent_width});
  add_column_sums(n, rooms, s.d_short_term.row(0), width, g.bias_of(Layer::dec));
  add_column_sums(n, rooms, s.d_reconstruction.row(0), width, g.bias_of(Layer::dec));
  std::array<Scalar, latent_width> tangent_sum{};
  add_column_sums(m, latent_width, a.strb_1.row(n), latent_width, tangent_sum.data());
  for (int o = 0; o < rooms; ++o)
    for (int i = 0; i < latent_width; ++i) dec[o * latent_width + i] += tangent_sum[static_cast<std::size_t>(i)];
}

/// Makes the padded copies, once a batch.
template <Topology T, class Scalar>
void begin_batch(const NetworkWeights<T, Scalar>& weights, NetworkScratch<T, Scalar>& s) {
  using L = Layout<T>;
  s.act.input_s.values.fill(0);
  s.act.input_a.values.fill(0);
  for (int o = 0; o < encoder_width; ++o) {
    std::copy_n(weights.weight_of(Layer::enc_s_0) + o * L::signals, L::signals, s.weight_s.row(o));
    std::fill(s.weight_s.row(o) + L::signals, s.weight_s.row(o + 1), Scalar(0));
    std::copy_n(weights.weight_of(Layer::enc_a_0) + o * (L::exogenous + 1), L::exogenous + 1, s.weight_a.row(o));
    std::fill(s.weight_a.row(o) + L::exogenous + 1, s.weight_a.row(o + 1), Scalar(0));
  }
}

/// What the target of one sample depends on beside the target network: its A, S1 and E1.
template <Topology T, class Scalar>
std::uint64_t target_key(const Scalar* sample, std::uint64_t seed) {
  using L = Layout<T>;
  return fingerprint(std::span<const Scalar>(sample + L::signals, static_cast<std::size_t>(L::signals) + 1), seed);
}

/// Targets of the group that starts at sample `first`; then the network itself is packed. One after the other, so that
/// only one packed network is ever needed. Of samples that lie in a memory, targets that are still known are taken.
template <Topology T, class Scalar>
void begin_group(const NetworkWeights<T, Scalar>& weights, const NetworkWeights<T, Scalar>& target,
                 const BatchView<T, Scalar>& batch, int first, double gamma, NetworkScratch<T, Scalar>& s) {
  const bool may_know = cached_targets > 0 && batch.index != nullptr;
  const std::uint64_t rest = std::bit_cast<std::uint64_t>(gamma) + static_cast<std::uint64_t>(s.kernels.kind);
  const std::uint64_t seed = may_know ? fingerprint(std::span<const Scalar>(target.values), rest) : 0;
  std::array<int, tile_samples> wanted;
  std::size_t waiting = 0;
  bool packed = false;
  const auto work_off = [&] {
    if (!packed) pack(target, s.kernels, s.packed);
    packed = true;
    bootstrap_tile(batch, std::span<const int>(wanted).first(waiting), gamma, s);
    for (std::size_t i = 0; may_know && i < waiting; ++i)
      s.targets.keep(batch.index[wanted[i]], target_key<T>(batch.row(wanted[i]), seed), s.bootstrap_of(wanted[i]));
    waiting = 0;
  };
  const int end = std::min(batch.size, first + group_samples);
  for (int at = first; at < end; ++at) {
    const Scalar* const known =
        may_know ? s.targets.find(batch.index[at], target_key<T>(batch.row(at), seed)) : nullptr;
    if (known != nullptr) {
      std::copy_n(known, Layout<T>::rooms, s.bootstrap_of(at));
      continue;
    }
    wanted[waiting++] = at;
    if (waiting == wanted.size()) work_off();
  }
  if (waiting > 0) work_off();
  pack(weights, s.kernels, s.packed);
}

/// Forward pass, targets and losses of one tile; F included. Tiles come in order, from 0 by tile_samples.
/// Returns how many samples violate the gradient constraint.
template <Topology T, class Scalar>
int tile_losses(const NetworkWeights<T, Scalar>& weights, const NetworkWeights<T, Scalar>& target,
                const BatchView<T, Scalar>& batch, int first, int rows, const LossSettings<T>& settings,
                NetworkScratch<T, Scalar>& s, LossTerms& sum) {
  if (first % group_samples == 0) begin_group(weights, target, batch, first, settings.gamma, s);
  load_tile(batch, first, rows, s);
  tile_forward(s.kernels, s.packed, rows, s.act);
  decode(s.kernels, s.packed, rows, s.act, s.short_term, s.deviation);
  constexpr int width = TileOutputs<T, Scalar>::width;
  layer_forward(s.kernels, s.packed, Layer::dec, rows, s.act.joint.row(0), share_width, s.reconstruction.row(0), width);
  output_losses(batch, first, rows, settings.weights, s, sum);
  constraint_reverse(weights, rows, s);
  return constraint_loss(rows, batch.size, settings, s, sum);
}

/// Losses of the batch, no gradient.
template <Topology T, class Scalar>
LossTerms batch_losses(const NetworkWeights<T, Scalar>& weights, const NetworkWeights<T, Scalar>& target,
                       const BatchView<T, Scalar>& batch, const LossSettings<T>& settings,
                       NetworkScratch<T, Scalar>& s) {
  LossTerms sum;
  begin_batch(weights, s);
  for (int first = 0; first < batch.size; first += tile_samples)
    (void)tile_losses(weights, target, batch, first, std::min(tile_samples, batch.size - first), settings, s, sum);
  return mean_losses(sum, batch.size, s.rooms(), settings.weights);
}

/// Losses of the batch, and the gradient of the weighted total to scratch.gradient.
/// Cost: 106,000 multiply-adds a sample for FiveZone, 44,000 more where it violates the constraint, 28,000 more where
/// its target is not known; linear in the batch.
template <Topology T, class Scalar>
LossTerms batch_gradient(const NetworkWeights<T, Scalar>& weights, const NetworkWeights<T, Scalar>& target,
                         const BatchView<T, Scalar>& batch, const LossSettings<T>& settings,
                         NetworkScratch<T, Scalar>& s) {
  using L = Layout<T>;
  LossTerms sum;
  begin_batch(weights, s);
  s.gradient.values.fill(0);
  s.gradient_s.values.fill(0);
  s.gradient_a.values.fill(0);
  for (int first = 0; first < batch.size; first += tile_samples) {
    const int rows = std::min(tile_samples, batch.size - first);
    const int violating = tile_losses(weights, target, batch, first, rows, settings, s, sum);
    losses_reverse(weights, rows, s);
    constraint_tangent(rows, violating, s);
    accumulate_gradient(rows, violating, s);
  }
  for (int o = 0; o < encoder_width; ++o) {
    std::copy_n(s.gradient_s.row(o), L::signals, s.gradient.weight_of(Layer::enc_s_0) + o * L::signals);
    std::copy_n(s.gradient_a.row(o), L::exogenous + 1, s.gradient.weight_of(Layer::enc_a_0) + o * (L::exogenous + 1));
  }
  return mean_losses(sum, batch.size, s.rooms(), settings.weights);
}

}  // namespace airside
