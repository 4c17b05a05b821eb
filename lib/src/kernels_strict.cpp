// The strict kernels: one order of summation, no fused multiply-add, the same bits on every architecture.
// Only additions over different columns are independent, so a compiler may vectorise them without reordering a sum.

#include <algorithm>
#include <cmath>

#include "airside/kernels.hpp"
#include "airside/network.hpp"

namespace airside {
namespace {

constexpr int block = kernel_columns;

template <class Scalar>
void product(const ProductArgs<Scalar>& p) {
  const Scalar slope = static_cast<Scalar>(leaky_slope);
  for (int c = 0; c < p.cols; c += block) {
    for (int r = 0; r < p.rows; ++r) {
      Scalar* const out = p.out + r * p.out_stride + c;
      const Scalar* const x = p.x + r * p.x_stride;
      Scalar sum[block];
      for (int i = 0; i < block; ++i) sum[i] = p.bias != nullptr ? p.bias[c + i] : p.accumulate ? out[i] : Scalar(0);
      for (int k = 0; k < p.depth; ++k) {
        const Scalar xk = x[k];
        const Scalar* const w = p.w + k * p.w_stride + c;
        for (int i = 0; i < block; ++i) sum[i] += xk * w[i];
      }
      if (p.leaky) {
        for (int i = 0; i < block; ++i) sum[i] = sum[i] > 0 ? sum[i] : slope * sum[i];
      } else if (p.gate != nullptr) {
        const Scalar* const gate = p.gate + r * p.gate_stride + c;
        for (int i = 0; i < block; ++i) sum[i] = gate[i] > 0 ? sum[i] : slope * sum[i];
      }
      for (int i = 0; i < block; ++i) out[i] = sum[i];
    }
  }
}

template <class Scalar>
void outer(const OuterArgs<Scalar>& p) {
  for (int c = 0; c < p.cols; c += block) {
    for (int r = 0; r < p.rows; ++r) {
      Scalar sum[block] = {};
      for (int k = 0; k < p.samples; ++k) {
        const Scalar d = p.d[k * p.d_stride + r];
        const Scalar* const x = p.x + k * p.x_stride + c;
        for (int i = 0; i < block; ++i) sum[i] += d * x[i];
      }
      Scalar* const g = p.g + r * p.g_stride + c;
      for (int i = 0; i < block; ++i) g[i] += sum[i];
    }
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

template <>
Kernels<float> strict_kernels<float>() {
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
