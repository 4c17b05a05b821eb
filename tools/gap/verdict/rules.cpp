#include "tools/gap/verdict/rules.hpp"

#include <algorithm>
#include <cmath>

namespace airside::tools::gap {

double log_likelihood_limit(const Rules& rules, const NullBlocks& nulls, std::size_t candidate) {
  return rules.log_likelihood_limit + rules.null_share * nulls.log_likelihood_ratio[candidate];
}

double least_excess(const Rules& rules, double log_likelihood_ratio, const Rival& rival) {
  return std::max(rules.margin_log_likelihood,
                  rules.margin_share * log_likelihood_ratio * (1 - rival.cosine * rival.cosine));
}

Eigen::Index locked_from(const Rules& rules, Eigen::Index bins) {
  const Eigen::Index days = bins / bins_per_day;
  return (days - static_cast<Eigen::Index>(std::lround(rules.locked_share * static_cast<double>(days)))) * bins_per_day;
}

}  // namespace airside::tools::gap
