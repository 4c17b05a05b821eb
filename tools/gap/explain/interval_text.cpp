#include "tools/gap/explain/interval_text.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace airside::tools::gap {

std::string with_interval(double value, double half_width) {
  if (!(half_width > 0) || !std::isfinite(half_width)) return fmt::format("{:.2g}", value);
  const int exponent = static_cast<int>(std::floor(std::log10(half_width)));
  const bool begins_with_1 = half_width < 1.95 * std::pow(10.0, exponent);
  const int decimals = (begins_with_1 ? 1 : 0) - exponent;
  if (decimals >= 0) return fmt::format("{:.{}f} ± {:.{}f}", value, decimals, half_width, decimals);
  const double unit = std::pow(10.0, -decimals);
  return fmt::format("{:.0f} ± {:.0f}", unit * std::round(value / unit), unit * std::round(half_width / unit));
}

}  // namespace airside::tools::gap
