// Kernels for AVX-512F: 32 registers of 16 floats. Compiled with -mavx512f -mavx2 -mfma.

#if defined(__AVX512F__)

#include "kernel_blocks.hpp"

namespace airside {

Kernels<float> avx512_kernels();
Kernels<float> avx512_strict_kernels();

namespace {

struct Avx512 {
  using Vector = __m512;
  static constexpr int lanes = 16;
  static Vector zero() { return _mm512_setzero_ps(); }
  static Vector set(float a) { return _mm512_set1_ps(a); }
  static Vector load(const float* a) { return _mm512_loadu_ps(a); }
  static void store(float* a, Vector b) { _mm512_storeu_ps(a, b); }
  static Vector add(Vector a, Vector b) { return _mm512_add_ps(a, b); }
  static Vector subtract(Vector a, Vector b) { return _mm512_sub_ps(a, b); }
  static Vector multiply(Vector a, Vector b) { return _mm512_mul_ps(a, b); }
  static Vector fma(Vector a, Vector b, Vector c) { return _mm512_fmadd_ps(a, b, c); }
  /// gate > 0 ? y : slope y
  static Vector gated(Vector y, Vector gate) {
    const __mmask16 scaled = _mm512_cmp_ps_mask(gate, _mm512_setzero_ps(), _CMP_NGT_UQ);
    return _mm512_mask_mul_ps(y, scaled, y, _mm512_set1_ps(static_cast<float>(leaky_slope)));
  }
  /// m / (sqrt(v) + epsilon) by the 14-bit estimates and one Newton step each, error about 1e-7; a division and a
  /// root of 16 floats cost more than all else in Adam. The floor keeps 0 * rsqrt(0) from being NaN.
  static Vector adam_ratio(Vector m, Vector v, Vector epsilon) {
    constexpr __mmask16 all = 0xFFFF;  // the forms without a mask make GCC 12 warn of an undefined operand
    const Vector at = _mm512_maskz_max_ps(all, v, _mm512_set1_ps(1e-30F));
    const Vector r = _mm512_maskz_rsqrt14_ps(all, at);
    const Vector root = _mm512_mul_ps(at, r);
    const Vector error = _mm512_fnmadd_ps(root, r, _mm512_set1_ps(1.0F));
    const Vector exact_root = _mm512_fmadd_ps(_mm512_mul_ps(root, _mm512_set1_ps(0.5F)), error, root);
    const Vector d = _mm512_add_ps(exact_root, epsilon);
    const Vector q = _mm512_maskz_rcp14_ps(all, d);
    const Vector twice = _mm512_mul_ps(q, _mm512_fnmadd_ps(d, q, _mm512_set1_ps(2.0F)));
    return _mm512_mul_ps(m, twice);
  }
};

/// Rounds each product, as every CPU can; divides and takes roots exactly.
struct StrictAvx512 : Avx512 {
  static Vector fma(Vector a, Vector b, Vector c) { return _mm512_add_ps(_mm512_mul_ps(a, b), c); }
  static Vector adam_ratio(Vector m, Vector v, Vector epsilon) {
    return _mm512_div_ps(m, _mm512_add_ps(_mm512_maskz_sqrt_ps(__mmask16{0xFFFF}, v), epsilon));
  }
};

void product(const ProductArgs<float>& p) {
  if (p.rows == 1) return product_row<Avx512>(p);
  int c = 0;
  for (; c + 64 <= p.cols; c += 64) product_panel<Avx512, 6, 4>(p, c);
  for (; c + 32 <= p.cols; c += 32) product_panel<Avx512, 12, 2>(p, c);
  for (; c < p.cols; c += 16) product_panel<Avx512, 12, 1>(p, c);
}

void outer(const OuterArgs<float>& p) {
  int c = 0;
  for (; c + 64 <= p.cols; c += 64) outer_panel<Avx512, 6, 4>(p, c);
  for (; c + 32 <= p.cols; c += 32) outer_panel<Avx512, 8, 2>(p, c);
  for (; c < p.cols; c += 16) outer_panel<Avx512, 12, 1>(p, c);
}

void strict_product(const ProductArgs<float>& p) {
  if (p.rows == 1) return product_row<StrictAvx512>(p);
  for (int c = 0; c < p.cols; c += 16) product_panel<StrictAvx512, 12, 1>(p, c);
}

void strict_outer(const OuterArgs<float>& p) {
  for (int c = 0; c < p.cols; c += 16) outer_panel<StrictAvx512, 12, 1>(p, c);
}

}  // namespace

Kernels<float> avx512_kernels() { return {product, outer, transpose_blocks, adam_vectors<Avx512>, KernelKind::avx512}; }

Kernels<float> avx512_strict_kernels() {
  return {strict_product, strict_outer, transpose_blocks, adam_vectors<StrictAvx512>, KernelKind::strict};
}

}  // namespace airside

#endif
