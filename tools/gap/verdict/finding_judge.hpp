#pragma once
// Each effect of a model looked at from all sides: how much it gains, what does nearly as well, does its sign hold.

#include <vector>

#include "tools/gap/verdict/effect_search.hpp"
#include "tools/gap/verdict/verdict.hpp"

namespace airside::tools::gap {

/// One a chosen effect, in their order.  Cost: a refit without each, and Rules::rivals refits for each.
std::vector<Finding> findings_of(const FittedCase& c, const EffectSearch& search, const Refit& now);

/// What may stand in the stead of each chosen effect beside the others; where there is none, of nothing.
/// Cost: Rules::alternatives refits and a Refitter::far() for each.
std::vector<Alternatives> alternatives_of(const FittedCase& c, const EffectSearch& search, const Refit& now);

}  // namespace airside::tools::gap
