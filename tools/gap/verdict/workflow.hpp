#pragma once
// From a residual to a verdict: which effect is missing, where, how much, how sure, and does it help on days that
// nobody looked at.

#include <functional>

#include "tools/gap/verdict/effect_search.hpp"
#include "tools/gap/verdict/outlook.hpp"
#include "tools/gap/verdict/verdict.hpp"

namespace airside::tools::gap {

/// What a verdict was drawn from, for further questions to the same fits.
struct Analysed {
  const FittedCase& fitted;
  const EffectSearch& search;
  const Refit& model;  ///< with what was found
  const Verdict& verdict;
};

/// Cost: some 12 simulations and three for each parameter; as many as half of that for each effect found.
/// `look`: called whenever it is known better what the search will come to: before the measured window is fitted, when
/// the search begins, and after each effect.
/// `judged`: called once, with the verdict.
/// Errors: as Engine::simulate.
Verdict analyse(const Engine& engine, const CaseData& data, const WindowResponses& responses, const Rules& rules = {},
                int jobs = 1, const std::function<void(const Outlook&)>& look = {},
                const std::function<void(const Analysed&)>& judged = {});

}  // namespace airside::tools::gap
