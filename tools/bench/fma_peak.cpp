#include "tools/bench/fma_peak.hpp"

#if defined(__x86_64__)
#include <immintrin.h>

namespace airside::tools {

// Each accumulator is its own chain; assembly, because a compiler would fold the loop.

__attribute__((target("avx512f"))) float fma_peak_avx512() {
  float first = 0;
  int left = 20000;
  __asm__ volatile(
      "vxorps %%zmm30, %%zmm30, %%zmm30\n vxorps %%zmm31, %%zmm31, %%zmm31\n"
      "1:\n"
#define Z(n) "vfmadd231ps %%zmm30, %%zmm31, %%zmm" #n "\n"
      Z(0) Z(1) Z(2) Z(3) Z(4) Z(5) Z(6) Z(7) Z(8) Z(9) Z(10) Z(11) Z(12) Z(13) Z(14) Z(15) Z(16) Z(17) Z(18) Z(19)
          Z(20) Z(21) Z(22) Z(23)
#undef Z
              "decl %[left]\n jnz 1b\n vmovss %%xmm0, %[first]\n vzeroupper\n"
      : [left] "+r"(left), [first] "=m"(first)
      :
      : "cc", "xmm0", "xmm1", "xmm2", "xmm3", "xmm4", "xmm5", "xmm6", "xmm7", "xmm8", "xmm9", "xmm10", "xmm11", "xmm12",
        "xmm13", "xmm14", "xmm15", "xmm16", "xmm17", "xmm18", "xmm19", "xmm20", "xmm21", "xmm22", "xmm23", "xmm30",
        "xmm31");
  return first;
}

__attribute__((target("avx2,fma"))) float fma_peak_avx2() {
  float first = 0;
  int left = 20000;
  __asm__ volatile(
      "vxorps %%ymm14, %%ymm14, %%ymm14\n vxorps %%ymm15, %%ymm15, %%ymm15\n"
      "1:\n"
#define Y(n) "vfmadd231ps %%ymm14, %%ymm15, %%ymm" #n "\n"
      Y(0) Y(1) Y(2) Y(3) Y(4) Y(5) Y(6) Y(7) Y(8) Y(9) Y(10) Y(11)
#undef Y
          "decl %[left]\n jnz 1b\n vmovss %%xmm0, %[first]\n vzeroupper\n"
      : [left] "+r"(left), [first] "=m"(first)
      :
      : "cc", "xmm0", "xmm1", "xmm2", "xmm3", "xmm4", "xmm5", "xmm6", "xmm7", "xmm8", "xmm9", "xmm10", "xmm11", "xmm14",
        "xmm15");
  return first;
}

__attribute__((target("avx2"))) float read_all_avx2(const float* values, int count) {
  __m256 sum[8];
  for (__m256& s : sum) s = _mm256_setzero_ps();
  for (int i = 0; i < count; i += 64) {
#pragma GCC unroll 8
    for (int j = 0; j < 8; ++j) sum[j] = _mm256_add_ps(sum[j], _mm256_loadu_ps(values + i + 8 * j));
  }
  for (int j = 1; j < 8; ++j) sum[0] = _mm256_add_ps(sum[0], sum[j]);
  return _mm256_cvtss_f32(sum[0]);
}

}  // namespace airside::tools

#else

namespace airside::tools {
float fma_peak_avx512() { return 0; }
float fma_peak_avx2() { return 0; }
float read_all_avx2(const float*, int) { return 0; }
}  // namespace airside::tools

#endif
