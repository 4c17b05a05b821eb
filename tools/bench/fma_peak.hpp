#pragma once
// What this core can do at most at this moment: a loop of fused multiply-adds without memory. A shared host runs at
// half speed for seconds at a time, so a time is only worth something beside this number.

namespace airside::tools {

/// Multiply-adds of one call of fma_peak_work: flops = 2 x this.
constexpr double fma_peak_count_avx512 = 20000.0 * 24 * 16;
constexpr double fma_peak_count_avx2 = 20000.0 * 12 * 8;

/// Runs the loop and returns something that depends on all of it. Call only where the CPU has the instructions.
float fma_peak_avx512();
float fma_peak_avx2();

/// Sums `count` floats, a multiple of 64, by AVX2: what the caches give at most. One row of a network reads each weight
/// once, and cannot be faster than that.
float read_all_avx2(const float* values, int count);

}  // namespace airside::tools
