#include "tools/gap/verdict/rules.hpp"

#include <algorithm>
#include <cmath>

namespace airside::tools::gap {

double gain_limit(const Rules& rules, const NullBlocks& nulls, std::size_t candidate) {
  return rules.gain_limit + rules.null_share * nulls.gain[candidate];
}

double least_excess(const Rules& rules, double gain, const Rival& rival) {
  return std::max(rules.margin_gain, rules.margin_share * gain * (1 - rival.cosine * rival.cosine));
}

Eigen::Index locked_from(const Rules& rules, Eigen::Index bins) {
  const Eigen::Index days = bins / bins_per_day;
  return (days - static_cast<Eigen::Index>(std::lround(rules.locked_share * static_cast<double>(days)))) * bins_per_day;
}

}  // namespace airside::tools::gap
