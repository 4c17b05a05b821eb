// The strict kernels: one order of summation, no fused multiply-add, the same bits on every architecture.
// Only additions over different columns are independent, so a compiler may vectorise them without reordering a sum.

#include <cmath>
#include <cstdint>
#include <cstring>

#include "airside/network/kernels/kernels.hpp"

namespace airside {
namespace {

#if defined(__SSE2__) || defined(__ARM_NEON)
/// 16 bytes of columns: the widest vector that every 64-bit baseline has.
template <class Scalar>
struct Lanes;
template <>
struct Lanes<float> {
  typedef float Vector __attribute__((vector_size(16)));
};
template <>
struct Lanes<double> {
  typedef double Vector __attribute__((vector_size(16)));
};
constexpr int vectors = 4;  ///< summed side by side
#else
/// A CPU without vectors: GCC would keep them, and so every sum, in memory. Two rows of eight sums fit its registers.
template <class Scalar>
struct Lanes {
  typedef Scalar Vector;
};
constexpr int vectors = 8;
#endif

template <class Scalar>
constexpr int lanes = static_cast<int>(sizeof(typename Lanes<Scalar>::Vector) / sizeof(Scalar));
template <class Scalar>
constexpr int block = vectors* lanes<Scalar>;
static_assert(kernel_columns % block<float> == 0 && kernel_columns % block<double> == 0);

template <class Scalar>
typename Lanes<Scalar>::Vector load(const Scalar* from) {
  typename Lanes<Scalar>::Vector v;
  std::memcpy(&v, from, sizeof(v));
  return v;
}

/// R x vectors running sums. How many rows go together changes no sum.
template <class Scalar, int R>
struct Sums {
  typename Lanes<Scalar>::Vector row[std::uint32_t{R}][std::uint32_t{vectors}];

  /// row[j] += factor[j * stride] * columns, for all rows.
  void add(const Scalar* factor, int stride, const Scalar* columns) {
    for (int v = 0; v < vectors; ++v) {
      const auto column = load(columns + v * lanes<Scalar>);
      for (int j = 0; j < R; ++j) row[j][v] += factor[j * stride] * column;
    }
  }
  void store(int j, Scalar* to) const { std::memcpy(to, row[j], sizeof(row[j])); }
};

/// Rows r .. r+R-1, one block of columns from c.
template <class Scalar, int R>
void product_rows(const ProductArgs<Scalar>& p, int r, int c) {
  const Scalar slope = static_cast<Scalar>(leaky_slope);
  Scalar* const out = p.out + r * p.out_stride + c;
  Sums<Scalar, R> sums{};
  for (int j = 0; j < R; ++j)
    for (int v = 0; v < vectors; ++v) {
      if (p.bias != nullptr)
        sums.row[j][v] = load(p.bias + c + v * lanes<Scalar>);
      else if (p.accumulate)
        sums.row[j][v] = load(out + j * p.out_stride + v * lanes<Scalar>);
    }
  const Scalar* x = p.x + r * p.x_stride;
  const Scalar* w = p.w + c;
  for (int k = 0; k < p.depth; ++k, ++x, w += p.w_stride) sums.add(x, p.x_stride, w);
  for (int j = 0; j < R; ++j) {
    Scalar* const y = out + j * p.out_stride;
    Scalar gate[std::uint32_t{block<Scalar>}];
    if (p.gate != nullptr) std::memcpy(gate, p.gate + (r + j) * p.gate_stride + c, sizeof(gate));
    sums.store(j, y);
    if (p.leaky) {
      for (int i = 0; i < block<Scalar>; ++i) y[i] = y[i] > 0 ? y[i] : slope * y[i];
    } else if (p.gate != nullptr) {
      for (int i = 0; i < block<Scalar>; ++i) y[i] = gate[i] > 0 ? y[i] : slope * y[i];
    }
  }
}

template <class Scalar>
void product(const ProductArgs<Scalar>& p) {
  for (int c = 0; c < p.cols; c += block<Scalar>) {
    int r = 0;
    for (; r + 2 <= p.rows; r += 2) product_rows<Scalar, 2>(p, r, c);
    if (r < p.rows) product_rows<Scalar, 1>(p, r, c);
  }
}

template <class Scalar, int R>
void outer_rows(const OuterArgs<Scalar>& p, int r, int c) {
  Sums<Scalar, R> sums{};
  const Scalar* d = p.d + r;
  const Scalar* x = p.x + c;
  for (int k = 0; k < p.samples; ++k, d += p.d_stride, x += p.x_stride) sums.add(d, 1, x);
  for (int j = 0; j < R; ++j) {
    Scalar* const g = p.g + (r + j) * p.g_stride + c;
    for (int v = 0; v < vectors; ++v) sums.row[j][v] += load(g + v * lanes<Scalar>);
    sums.store(j, g);
  }
}

template <class Scalar>
void outer(const OuterArgs<Scalar>& p) {
  for (int c = 0; c < p.cols; c += block<Scalar>) {
    int r = 0;
    for (; r + 2 <= p.rows; r += 2) outer_rows<Scalar, 2>(p, r, c);
    if (r < p.rows) outer_rows<Scalar, 1>(p, r, c);
  }
}

template <class Scalar>
void transpose(const TransposeArgs<Scalar>& p) {
  for (int r = 0; r < p.rows; ++r)
    for (int c = 0; c < p.cols; ++c) p.out[c * p.out_stride + r] = p.w[r * p.cols + c];
}

template <class Scalar>
void adam(const AdamArgs<Scalar>& p) {
  for (int i = 0; i < p.count; ++i) {
    const Scalar g = p.g[i];
    const Scalar m = p.beta1 * p.m[i] + p.one_minus_beta1 * g;
    const Scalar v = p.beta2 * p.v[i] + p.one_minus_beta2 * (g * g);
    p.m[i] = m;
    p.v[i] = v;
    p.w[i] -= p.rate * m / (std::sqrt(v * p.correction) + p.epsilon);
  }
}

}  // namespace

Kernels<float> portable_strict_kernels();

Kernels<float> portable_strict_kernels() {
  return {product<float>, outer<float>, transpose<float>, adam<float>, KernelKind::strict};
}

template <>
Kernels<double> strict_kernels<double>() {
  return {product<double>, outer<double>, transpose<double>, adam<double>, KernelKind::strict};
}

template <>
Kernels<double> select_kernels<double>() {
  return strict_kernels<double>();
}

}  // namespace airside
