// Which kernels this CPU can run.

#include "airside/network/kernels/kernels.hpp"

namespace airside {

Kernels<float> portable_strict_kernels();
#if defined(__x86_64__) || defined(__i386__)
Kernels<float> avx2_kernels();
Kernels<float> avx512_kernels();
Kernels<float> avx2_strict_kernels();
Kernels<float> avx512_strict_kernels();
#endif

const char* text_of(KernelKind kind) {
  switch (kind) {
    case KernelKind::strict: return "strict";
    case KernelKind::avx2: return "avx2";
    case KernelKind::avx512: return "avx512";
  }
  return "unknown";
}

bool cpu_has(KernelKind kind) {
  if (kind == KernelKind::strict) return true;
#if !defined(AIRSIDE_STRICT) && (defined(__x86_64__) || defined(__i386__))
  __builtin_cpu_init();
  const bool avx2 = __builtin_cpu_supports("avx2") != 0 && __builtin_cpu_supports("fma") != 0;
  if (kind == KernelKind::avx2) return avx2;
  return avx2 && __builtin_cpu_supports("avx512f") != 0;
#else
  return false;
#endif
}

Kernels<float> strict_kernels_by(KernelKind width) {
#if defined(__x86_64__) || defined(__i386__)
  if (cpu_has(width) && width == KernelKind::avx512) return avx512_strict_kernels();
  if (cpu_has(width) && width == KernelKind::avx2) return avx2_strict_kernels();
#endif
  return portable_strict_kernels();
}

Kernels<float> float_kernels(KernelKind kind) {
  if (!cpu_has(kind)) return strict_kernels<float>();
  switch (kind) {
    case KernelKind::strict: break;
#if defined(__x86_64__) || defined(__i386__)
    case KernelKind::avx2: return avx2_kernels();
    case KernelKind::avx512: return avx512_kernels();
#else
    case KernelKind::avx2:
    case KernelKind::avx512: break;
#endif
  }
  return strict_kernels<float>();
}

template <>
Kernels<float> strict_kernels<float>() {
  if (cpu_has(KernelKind::avx512)) return strict_kernels_by(KernelKind::avx512);
  return strict_kernels_by(KernelKind::avx2);
}

template <>
Kernels<float> select_kernels<float>() {
  if (cpu_has(KernelKind::avx512)) return float_kernels(KernelKind::avx512);
  return float_kernels(KernelKind::avx2);
}

}  // namespace airside
