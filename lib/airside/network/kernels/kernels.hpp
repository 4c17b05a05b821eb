#pragma once
// The four inner loops that all network time is spent in, as a table of function pointers that is chosen once at
// start and handed around; there is no global. `strict` sums in one fixed order without fused multiply-add, so it
// gives the same bits on every architecture, also by wider vectors: each output has a sum of its own. avx2 and avx512
// are faster and round differently.
// This header is included by files compiled for newer CPUs: it must not define any inline function.

#include <cstdint>

namespace airside {

/// Columns of every matrix that a kernel writes come in multiples of this.
constexpr int kernel_columns = 16;

/// LeakyReLU's slope below zero.  Source: docs/method.md 3.2.
constexpr double leaky_slope = 0.2;

/// out = end(start + x w), start = bias row, `out` itself, or 0.
/// Shape: x rows x depth, w depth x cols, out rows x cols (cols % 16 == 0), all row-major with the given strides.
template <class Scalar>
struct ProductArgs {
  const Scalar* x;
  int x_stride;
  const Scalar* w;
  int w_stride;
  Scalar* out;
  int out_stride;
  int rows, depth, cols;
  const Scalar* bias = nullptr;  ///< row of cols, start of every sum
  bool accumulate = false;       ///< start from out instead
  bool leaky = false;            ///< end: y > 0 ? y : slope y
  const Scalar* gate = nullptr;  ///< end: y times phi' of the activation gate(r, c): > 0 ? 1 : slope; may be out
  int gate_stride = 0;
};

/// g += d^T x, a weight gradient.
/// Shape: d samples x rows, x samples x cols, g rows x cols (cols % 16 == 0).
template <class Scalar>
struct OuterArgs {
  const Scalar* d;
  int d_stride;
  const Scalar* x;
  int x_stride;
  Scalar* g;
  int g_stride;
  int samples, rows, cols;
};

/// out = w^T.  Shape: w rows x cols with stride cols, out cols x rows with stride out_stride.
template <class Scalar>
struct TransposeArgs {
  const Scalar* w;
  int rows, cols;
  Scalar* out;
  int out_stride;
};

/// m = b1 m + (1-b1) g;  v = b2 v + (1-b2) g^2;  w -= rate m / (sqrt(v correction) + epsilon).
template <class Scalar>
struct AdamArgs {
  Scalar* w;
  Scalar* m;
  Scalar* v;
  const Scalar* g;
  int count;
  Scalar beta1, one_minus_beta1, beta2, one_minus_beta2;
  Scalar rate;        ///< lr / (1 - b1^k)
  Scalar correction;  ///< 1 / (1 - b2^k)
  Scalar epsilon;
};

enum class KernelKind : std::uint8_t { strict = 0, avx2 = 1, avx512 = 2 };

template <class Scalar>
struct Kernels {
  void (*product)(const ProductArgs<Scalar>&);
  void (*outer)(const OuterArgs<Scalar>&);
  void (*transpose)(const TransposeArgs<Scalar>&);
  void (*adam)(const AdamArgs<Scalar>&);
  KernelKind kind;
};

const char* text_of(KernelKind kind);

/// Whether this CPU and this build can run `kind`.
bool cpu_has(KernelKind kind);

/// Fixed order of summation, no FMA: the same bits everywhere; by the widest vectors of this CPU.
template <class Scalar>
Kernels<Scalar> strict_kernels();

/// The strict kernels by the vectors of `width`, by those that every CPU has where this one lacks them.
Kernels<float> strict_kernels_by(KernelKind width);

/// The float kernels of `kind`, strict where the CPU has it not.
Kernels<float> float_kernels(KernelKind kind);

/// The fastest kernels of this CPU; for double always strict.
template <class Scalar>
Kernels<Scalar> select_kernels();

template <>
Kernels<float> strict_kernels<float>();
template <>
Kernels<double> strict_kernels<double>();
template <>
Kernels<float> select_kernels<float>();
template <>
Kernels<double> select_kernels<double>();

}  // namespace airside
