#pragma once
// The five losses of one tile: their values and their derivatives by the network's outputs.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>

#include "airside/network/scratch.hpp"
#include "airside/signals.hpp"
#include "airside/topology.hpp"

namespace airside {

/// Weights of the terms in the total; all 1 as printed (Eq 22).
struct LossWeights {
  double strb = 1, tdb = 1, gc = 1, rc = 1, rec = 1;
};

/// strb, tdb, rc, rec: mean over rooms; gc: sum over inputs; all: mean over the batch, unweighted.
/// total: weighted sum.  Units: scaled (docs/method.md, open points 7 and 9).
struct LossTerms {
  double strb = 0, tdb = 0, gc = 0, rc = 0, rec = 0, total = 0;
};

/// L_j of Table I for every input.
template <Topology T>
constexpr std::array<double, Layout<T>::inputs> relation_labels(double vav_label = 1.0) {
  std::array<double, Layout<T>::inputs> labels{};
  for (int j = 0; j < Layout<T>::inputs; ++j) labels[static_cast<std::size_t>(j)] = relation_label<T>(j, vav_label);
  return labels;
}

template <Topology T>
struct LossSettings {
  LossWeights weights;
  double gamma = 0.5;  ///< g, discount of the long-term prediction
  std::array<double, Layout<T>::inputs> labels = relation_labels<T>();
};

/// Transitions [S E A S1 E1], scaled: contiguous rows, all of them or those named by `index`.
template <Topology T, class Scalar>
struct BatchView {
  const Scalar* rows = nullptr;
  const std::uint32_t* index = nullptr;  ///< nullptr: rows 0..size-1
  int size = 0;

  const Scalar* row(int i) const {
    const std::size_t r = index != nullptr ? index[i] : static_cast<std::size_t>(i);
    return rows + r * static_cast<std::size_t>(Layout<T>::transition);
  }
};

/// Sums the output losses of one tile and writes their derivatives, divided by the whole batch's size.
///   L_STRB = mean (S1 - S')^2          L_TDB = mean (D' - Y)^2, no gradient through Y
///   L_RC = mean max(0, -(S1 - S) D')   L_rec = mean (S^ - S)^2
/// Shape: samples first .. first+rows-1 of the batch; outputs in scratch.short_term, deviation, reconstruction,
/// bootstrap_of (Y); derivatives to scratch.d_*.  Source: docs/method.md 4.
template <Topology T, class Scalar>
void output_losses(const BatchView<T, Scalar>& batch, int first, int rows, const LossWeights& weights,
                   NetworkScratch<T, Scalar>& scratch, LossTerms& sum) {
  using L = Layout<T>;
  const int rooms = scratch.rooms();
  const double each = 1.0 / (static_cast<double>(batch.size) * rooms);
  const Scalar strb_rate = static_cast<Scalar>(2 * weights.strb * each);
  const Scalar tdb_rate = static_cast<Scalar>(2 * weights.tdb * each);
  const Scalar rc_rate = static_cast<Scalar>(weights.rc * each);
  const Scalar rec_rate = static_cast<Scalar>(2 * weights.rec * each);
  for (int r = 0; r < rows; ++r) {
    const Scalar* const s = batch.row(first + r);
    const Scalar* const s1 = s + L::inputs;
    const Scalar* const short_term = scratch.short_term.row(r);
    const Scalar* const deviation = scratch.deviation.row(r);
    const Scalar* const reconstruction = scratch.reconstruction.row(r);
    const Scalar* const bootstrap = scratch.bootstrap_of(first + r);
    Scalar strb = 0, tdb = 0, rc = 0, rec = 0;
    for (int i = 0; i < rooms; ++i) {
      const Scalar strb_error = short_term[i] - s1[i];
      const Scalar tdb_error = deviation[i] - bootstrap[i];
      const Scalar rec_error = reconstruction[i] - s[i];
      const Scalar change = s1[i] - s[i];
      const Scalar against = std::max(Scalar(0), -change * deviation[i]);
      const Scalar rc_push = rc_rate * change;
      strb += strb_error * strb_error;
      tdb += tdb_error * tdb_error;
      rec += rec_error * rec_error;
      rc += against;
      scratch.d_short_term.row(r)[i] = strb_rate * strb_error;
      scratch.d_deviation.row(r)[i] = tdb_rate * tdb_error - (against != 0 ? rc_push : Scalar(0));
      scratch.d_reconstruction.row(r)[i] = rec_rate * rec_error;
    }
    sum.strb += static_cast<double>(strb);
    sum.tdb += static_cast<double>(tdb);
    sum.rc += static_cast<double>(rc);
    sum.rec += static_cast<double>(rec);
  }
}

/// The gradient constraint of one tile: L_GC = sum_j max(0, -L_j F_j), and the tangents v that its weight gradient
/// starts from, v_j = -L_j w_gc / N where it is violated, else 0.
/// Shape: F = slope_s on [S E] plus slope_a on [E A]; the m samples whose v is not 0 go to scratch.violating, and v
/// restricted to each encoder to rows rows..rows+m-1 of its inputs. Returns m.  Source: docs/method.md 4.4, step 3.
template <Topology T, class Scalar>
int constraint_loss(int rows, int batch_size, const LossSettings<T>& settings, NetworkScratch<T, Scalar>& scratch,
                    LossTerms& sum) {
  using L = Layout<T>;
  std::array<Scalar, L::inputs> label, slope, seed;
  std::array<Scalar, L::inputs> wrong, tangent;
  const double rate = settings.weights.gc / batch_size;
  int violating = 0;
  for (std::size_t j = 0; j < L::inputs; ++j) {
    label[j] = static_cast<Scalar>(-settings.labels[j]);
    seed[j] = static_cast<Scalar>(-settings.labels[j] * rate);
  }
  for (int r = 0; r < rows; ++r) {
    const Scalar* const by_s = scratch.slope_s.row(r);
    const Scalar* const by_a = scratch.slope_a.row(r);
    for (std::size_t j = 0; j < L::rooms; ++j) slope[j] = by_s[j];
    for (std::size_t j = 0; j < L::exogenous; ++j) slope[L::rooms + j] = by_s[L::rooms + j] + by_a[j];
    slope[L::signals] = by_a[L::exogenous];
    // Loops of their own, in a form without branches: only the sum has an order.
    for (std::size_t j = 0; j < L::inputs; ++j) wrong[j] = std::max(Scalar(0), label[j] * slope[j]);
    for (std::size_t j = 0; j < L::inputs; ++j) {
      const Scalar start = seed[j];
      tangent[j] = wrong[j] != 0 ? start : Scalar(0);
    }
    Scalar against = 0;
    for (std::size_t j = 0; j < L::inputs; ++j) against += wrong[j];
    if (!(against > 0)) continue;
    sum.gc += static_cast<double>(against);
    Scalar* const u_s = scratch.act.input_s.row(rows + violating);
    Scalar* const u_a = scratch.act.input_a.row(rows + violating);
    for (std::size_t j = 0; j < L::signals; ++j) u_s[j] = tangent[j];
    for (std::size_t j = 0; j <= L::exogenous; ++j) u_a[j] = tangent[L::rooms + j];
    scratch.violating[static_cast<std::size_t>(violating++)] = r;
  }
  return violating;
}

/// Sums to means, and the weighted total.
inline LossTerms mean_losses(const LossTerms& sum, int batch_size, int rooms, const LossWeights& w) {
  const double each = 1.0 / (static_cast<double>(batch_size) * rooms);
  LossTerms mean{sum.strb * each, sum.tdb * each, sum.gc / batch_size, sum.rc * each, sum.rec * each, 0};
  mean.total = w.strb * mean.strb + w.tdb * mean.tdb + w.gc * mean.gc + w.rc * mean.rc + w.rec * mean.rec;
  return mean;
}

}  // namespace airside
