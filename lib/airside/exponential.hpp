#pragma once
// e^x with the same bits on every machine. C libraries differ in the last bit of exp, glibc even from CPU to CPU.

#include <bit>
#include <cmath>
#include <cstdint>
#include <limits>

namespace airside {

/// e^x by additions and multiplications in one order: x = k ln 2 + r, e^x = 2^k e^r, e^r by its series to r^13.
/// Errors: 0 below -708, infinite above 709, NaN for NaN. Within 1.5 units in the last place of the truth elsewhere.
inline double fixed_exponential(double x) {
  if (std::isnan(x)) return x;
  if (x < -708.0) return 0.0;
  if (x > 709.0) return std::numeric_limits<double>::infinity();
  constexpr double per_ln2 = 1.4426950408889634, ln2_high = 6.93147180369123816490e-01,
                   ln2_low = 1.90821492927058770002e-10;
  const double k = std::floor(x * per_ln2 + 0.5);
  const double r = (x - k * ln2_high) - k * ln2_low;
  double series = 1.0;
  for (int n = 13; n >= 1; --n) series = 1.0 + r * series / n;
  const std::uint64_t exponent = static_cast<std::uint64_t>(static_cast<std::int64_t>(k) + 1023) << 52;
  return series * std::bit_cast<double>(exponent);
}

/// e^x: the C library's, or in a strict build the one of equal bits.
inline double exponential(double x) {
#ifdef AIRSIDE_STRICT
  return fixed_exponential(x);
#else
  return std::exp(x);
#endif
}

}  // namespace airside
