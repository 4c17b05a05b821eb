// Kernels for AVX2 with FMA: 16 registers of 8 floats. Compiled with -mavx2 -mfma.

#if defined(__AVX2__) && defined(__FMA__)

#include "kernel_blocks.hpp"

namespace airside {

Kernels<float> avx2_kernels();
Kernels<float> avx2_strict_kernels();

namespace {

struct Avx2 {
  using Vector = __m256;
  static constexpr int lanes = 8;
  static Vector zero() { return _mm256_setzero_ps(); }
  static Vector set(float a) { return _mm256_set1_ps(a); }
  static Vector load(const float* a) { return _mm256_loadu_ps(a); }
  static void store(float* a, Vector b) { _mm256_storeu_ps(a, b); }
  static Vector add(Vector a, Vector b) { return _mm256_add_ps(a, b); }
  static Vector subtract(Vector a, Vector b) { return _mm256_sub_ps(a, b); }
  static Vector multiply(Vector a, Vector b) { return _mm256_mul_ps(a, b); }
  static Vector fma(Vector a, Vector b, Vector c) { return _mm256_fmadd_ps(a, b, c); }
  /// gate > 0 ? y : slope y
  static Vector gated(Vector y, Vector gate) {
    const Vector positive = _mm256_cmp_ps(gate, _mm256_setzero_ps(), _CMP_GT_OQ);
    return _mm256_blendv_ps(_mm256_mul_ps(y, _mm256_set1_ps(static_cast<float>(leaky_slope))), y, positive);
  }
  static Vector adam_ratio(Vector m, Vector v, Vector epsilon) {
    return _mm256_div_ps(m, _mm256_add_ps(_mm256_sqrt_ps(v), epsilon));
  }
};

/// Rounds each product, as every CPU can.
struct StrictAvx2 : Avx2 {
  static Vector fma(Vector a, Vector b, Vector c) { return _mm256_add_ps(_mm256_mul_ps(a, b), c); }
};

void product(const ProductArgs<float>& p) {
  if (p.rows == 1) return product_row<Avx2>(p);
  for (int c = 0; c < p.cols; c += 16) product_panel<Avx2, 6, 2>(p, c);
}

void outer(const OuterArgs<float>& p) {
  for (int c = 0; c < p.cols; c += 16) outer_panel<Avx2, 6, 2>(p, c);
}

void strict_product(const ProductArgs<float>& p) {
  if (p.rows == 1) return product_row<StrictAvx2>(p);
  for (int c = 0; c < p.cols; c += 16) product_panel<StrictAvx2, 4, 2>(p, c);
}

void strict_outer(const OuterArgs<float>& p) {
  for (int c = 0; c < p.cols; c += 16) outer_panel<StrictAvx2, 4, 2>(p, c);
}

}  // namespace

Kernels<float> avx2_kernels() { return {product, outer, transpose_blocks, adam_vectors<Avx2>, KernelKind::avx2}; }

Kernels<float> avx2_strict_kernels() {
  return {strict_product, strict_outer, transpose_blocks, adam_vectors<StrictAvx2>, KernelKind::strict};
}

}  // namespace airside

#endif
