#pragma once
// How sure a share k of n is.

#include <algorithm>
#include <cmath>

namespace airside::tools::gap {

struct ShareInterval {
  double low = 0, high = 1;
};

/// The interval of shares that do not contradict k of n at 95 %; all shares for n = 0.
///   (p + z^2/2n -+ z sqrt(p (1 - p)/n + z^2/4n^2)) / (1 + z^2/n),  p = k/n, z = 1.96
/// Source: E. B. Wilson, J. Am. Stat. Assoc. 22 (1927), 209-212; without continuity correction.
inline ShareInterval wilson_95(int k, int n) {
  if (n <= 0) return {};
  constexpr double z = 1.959963984540054;
  const double count = n, p = k / count, square = z * z / count;
  const double middle = p + square / 2, half = z * std::sqrt(p * (1 - p) / count + square / (4 * count));
  return {std::max(0.0, (middle - half) / (1 + square)), std::min(1.0, (middle + half) / (1 + square))};
}

}  // namespace airside::tools::gap
