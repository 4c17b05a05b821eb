#pragma once
// Register-blocked kernels over a vector type V, for files that are compiled for one newer CPU each. Everything is in
// an unnamed namespace and no library template is called: code built for AVX must never be the copy that the linker
// keeps for a baseline CPU.

#include <immintrin.h>

#include "airside/network/kernels/kernels.hpp"

#if defined(__clang__)
#define AIRSIDE_UNROLL _Pragma("clang loop unroll(full)")
#else
#define AIRSIDE_UNROLL _Pragma("GCC unroll 16")
#endif

namespace airside {
namespace {

constexpr int any_stride = 0;

/// How many of `rows` go in blocks of R. Where few would be left, which wait for their own sums, a block shares its
/// rows with them: what is left then are two blocks of nearly the same size.
template <int R>
inline int rows_in_blocks(int rows) {
  const int left = rows % R;
  return rows - left - (left > 0 && 3 * left <= R && rows > R ? R : 0);
}

/// Rows r .. r+R-1, columns c .. c+C*lanes-1 of a product; the sums stay in R*C registers.
template <class V, int R, int C, int Stride>
inline void product_block(const ProductArgs<float>& p, int r, int c) {
  using Vector = typename V::Vector;
  const int stride = Stride == any_stride ? p.x_stride : Stride;
  const float* x = p.x + r * stride;
  const float* w = p.w + c;
  float* const out = p.out + r * p.out_stride + c;
  Vector sum[std::uint32_t{R}][std::uint32_t{C}];
  AIRSIDE_UNROLL
  for (int i = 0; i < R; ++i) {
    AIRSIDE_UNROLL
    for (int j = 0; j < C; ++j)
      sum[i][j] = p.bias != nullptr ? V::load(p.bias + c + j * V::lanes)
                  : p.accumulate    ? V::load(out + i * p.out_stride + j * V::lanes)
                                    : V::zero();
  }
  for (int k = 0; k < p.depth; ++k) {
    Vector column[std::uint32_t{C}];
    AIRSIDE_UNROLL
    for (int j = 0; j < C; ++j) column[j] = V::load(w + j * V::lanes);
    AIRSIDE_UNROLL
    for (int i = 0; i < R; ++i) {
      const Vector xi = V::set(x[i * stride]);
      AIRSIDE_UNROLL
      for (int j = 0; j < C; ++j) sum[i][j] = V::fma(xi, column[j], sum[i][j]);
    }
    ++x;
    w += p.w_stride;
  }
  if (p.leaky) {
    AIRSIDE_UNROLL
    for (int i = 0; i < R; ++i) {
      AIRSIDE_UNROLL
      for (int j = 0; j < C; ++j) sum[i][j] = V::gated(sum[i][j], sum[i][j]);
    }
  } else if (p.gate != nullptr) {
    const float* const gate = p.gate + r * p.gate_stride + c;
    AIRSIDE_UNROLL
    for (int i = 0; i < R; ++i) {
      AIRSIDE_UNROLL
      for (int j = 0; j < C; ++j) sum[i][j] = V::gated(sum[i][j], V::load(gate + i * p.gate_stride + j * V::lanes));
    }
  }
  AIRSIDE_UNROLL
  for (int i = 0; i < R; ++i) {
    AIRSIDE_UNROLL
    for (int j = 0; j < C; ++j) V::store(out + i * p.out_stride + j * V::lanes, sum[i][j]);
  }
}

/// Rows r .. r+left-1, left <= R.
template <class V, int R, int C>
inline void product_rest(const ProductArgs<float>& p, int r, int c, int left) {
  if constexpr (R > 0) {
    if (left == R)
      product_block<V, R, C, any_stride>(p, r, c);
    else
      product_rest<V, R - 1, C>(p, r, c, left);
  }
}

template <class V, int R, int C, int Stride>
inline int product_rows(const ProductArgs<float>& p, int c) {
  const int whole = rows_in_blocks<R>(p.rows);
  for (int r = 0; r < whole; r += R) product_block<V, R, C, Stride>(p, r, c);
  return whole;
}

/// A panel of C vectors of columns. The strides that occur are compile-time, so that one pointer serves R rows.
template <class V, int R, int C>
inline void product_panel(const ProductArgs<float>& p, int c) {
  const int r = p.x_stride == 64   ? product_rows<V, R, C, 64>(p, c)
                : p.x_stride == 32 ? product_rows<V, R, C, 32>(p, c)
                                   : product_rows<V, R, C, any_stride>(p, c);
  const int left = p.rows - r;
  const int first = left > R ? (left + 1) / 2 : left;
  product_rest<V, R - 1, C>(p, r, c, first);
  product_rest<V, R - 1, C>(p, r + first, c, left - first);
}

/// Columns from c on of a single row, C vectors at a time; returns the first column that is left.
template <class V, int C>
inline int row_blocks(const ProductArgs<float>& p, int c) {
  for (; c + C * V::lanes <= p.cols; c += C * V::lanes) product_block<V, 1, C, any_stride>(p, 0, c);
  return c;
}

/// A product of one row. Each sum waits for its own last step, so as many as registers hold run side by side.
template <class V>
inline void product_row(const ProductArgs<float>& p) {
  int c = row_blocks<V, 8>(p, 0);
  c = row_blocks<V, 4>(p, c);
  c = row_blocks<V, 2>(p, c);
  if constexpr (V::lanes == kernel_columns) row_blocks<V, 1>(p, c);
}

/// Rows r .. r+R-1 of a weight gradient.
template <class V, int R, int C>
inline void outer_block(const OuterArgs<float>& p, int r, int c) {
  using Vector = typename V::Vector;
  const float* d = p.d + r;
  const float* x = p.x + c;
  Vector sum[std::uint32_t{R}][std::uint32_t{C}];
  AIRSIDE_UNROLL
  for (int i = 0; i < R; ++i) {
    AIRSIDE_UNROLL
    for (int j = 0; j < C; ++j) sum[i][j] = V::zero();
  }
  for (int k = 0; k < p.samples; ++k) {
    Vector column[std::uint32_t{C}];
    AIRSIDE_UNROLL
    for (int j = 0; j < C; ++j) column[j] = V::load(x + j * V::lanes);
    AIRSIDE_UNROLL
    for (int i = 0; i < R; ++i) {
      const Vector di = V::set(d[i]);
      AIRSIDE_UNROLL
      for (int j = 0; j < C; ++j) sum[i][j] = V::fma(di, column[j], sum[i][j]);
    }
    d += p.d_stride;
    x += p.x_stride;
  }
  float* const g = p.g + r * p.g_stride + c;
  AIRSIDE_UNROLL
  for (int i = 0; i < R; ++i) {
    AIRSIDE_UNROLL
    for (int j = 0; j < C; ++j) {
      float* const at = g + i * p.g_stride + j * V::lanes;
      V::store(at, V::add(V::load(at), sum[i][j]));
    }
  }
}

template <class V, int R, int C>
inline void outer_rest(const OuterArgs<float>& p, int r, int c, int left) {
  if constexpr (R > 0) {
    if (left == R)
      outer_block<V, R, C>(p, r, c);
    else
      outer_rest<V, R - 1, C>(p, r, c, left);
  }
}

template <class V, int R, int C>
inline void outer_panel(const OuterArgs<float>& p, int c) {
  const int whole = rows_in_blocks<R>(p.rows);
  for (int r = 0; r < whole; r += R) outer_block<V, R, C>(p, r, c);
  const int left = p.rows - whole;
  const int first = left > R ? (left + 1) / 2 : left;
  outer_rest<V, R - 1, C>(p, whole, c, first);
  outer_rest<V, R - 1, C>(p, whole + first, c, left - first);
}

/// 8 x 8 blocks in registers, the rest number by number.
void transpose_blocks(const TransposeArgs<float>& p) {
  const int rows = p.rows / 8 * 8;
  const int cols = p.cols / 8 * 8;
  for (int r = 0; r < rows; r += 8) {
    for (int c = 0; c < cols; c += 8) {
      const float* const w = p.w + r * p.cols + c;
      __m256 a[8], b[8];
      // Halves of rows i and i+4 side by side: what is left is a transpose within 128-bit lanes.
      AIRSIDE_UNROLL
      for (int i = 0; i < 4; ++i) {
        const float* const low = w + i * p.cols;
        const float* const high = w + (i + 4) * p.cols;
        a[i] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(low)), _mm_loadu_ps(high), 1);
        a[i + 4] = _mm256_insertf128_ps(_mm256_castps128_ps256(_mm_loadu_ps(low + 4)), _mm_loadu_ps(high + 4), 1);
      }
      AIRSIDE_UNROLL
      for (int h = 0; h < 8; h += 4) {
        b[h + 0] = _mm256_unpacklo_ps(a[h + 0], a[h + 1]);
        b[h + 1] = _mm256_unpackhi_ps(a[h + 0], a[h + 1]);
        b[h + 2] = _mm256_unpacklo_ps(a[h + 2], a[h + 3]);
        b[h + 3] = _mm256_unpackhi_ps(a[h + 2], a[h + 3]);
        float* const out = p.out + (c + h) * p.out_stride + r;
        _mm256_storeu_ps(out, _mm256_shuffle_ps(b[h], b[h + 2], 0x44));
        _mm256_storeu_ps(out + p.out_stride, _mm256_shuffle_ps(b[h], b[h + 2], 0xEE));
        _mm256_storeu_ps(out + 2 * p.out_stride, _mm256_shuffle_ps(b[h + 1], b[h + 3], 0x44));
        _mm256_storeu_ps(out + 3 * p.out_stride, _mm256_shuffle_ps(b[h + 1], b[h + 3], 0xEE));
      }
    }
    for (int c = cols; c < p.cols; ++c)
      for (int i = r; i < r + 8; ++i) p.out[c * p.out_stride + i] = p.w[i * p.cols + c];
  }
  for (int i = rows; i < p.rows; ++i)
    for (int c = 0; c < p.cols; ++c) p.out[c * p.out_stride + i] = p.w[i * p.cols + c];
}

/// count must be a multiple of V::lanes, as NetworkWeights is.
template <class V>
void adam_vectors(const AdamArgs<float>& p) {
  using Vector = typename V::Vector;
  const Vector beta1 = V::set(p.beta1), one_minus_beta1 = V::set(p.one_minus_beta1);
  const Vector beta2 = V::set(p.beta2), one_minus_beta2 = V::set(p.one_minus_beta2);
  const Vector rate = V::set(p.rate), correction = V::set(p.correction), epsilon = V::set(p.epsilon);
  for (int i = 0; i < p.count; i += V::lanes) {
    const Vector g = V::load(p.g + i);
    const Vector m = V::fma(beta1, V::load(p.m + i), V::multiply(one_minus_beta1, g));
    const Vector v = V::fma(beta2, V::load(p.v + i), V::multiply(one_minus_beta2, V::multiply(g, g)));
    V::store(p.m + i, m);
    V::store(p.v + i, v);
    const Vector change = V::adam_ratio(V::multiply(rate, m), V::multiply(v, correction), epsilon);
    V::store(p.w + i, V::subtract(V::load(p.w + i), change));
  }
}

}  // namespace
}  // namespace airside
