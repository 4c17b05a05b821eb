#pragma once
// How probable explanations were called beside how often they were the truth, as a picture.

#include <string>
#include <vector>

#include "tools/gap/score/score.hpp"

namespace airside::tools::gap {

/// One mark a bin that has cases, at its mean probability and the share in which it was the truth, with the share's 95
/// % Wilson interval and the number of cases; the diagonal is what honest probabilities give. Blue: the interval holds
/// the diagonal; orange: it does not. A file of its own. Shape: 420 x 460 user units.
std::string reliability_svg(const std::vector<ReliabilityBin>& bins, const std::string& title);

}  // namespace airside::tools::gap
