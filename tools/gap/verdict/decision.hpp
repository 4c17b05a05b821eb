#pragma once
// A verdict drawn from how probable each explanation is.

#include <vector>

#include "tools/gap/verdict/verdict.hpp"

namespace airside::tools::gap {

/// What a posterior asks for in the place of one finding.
enum class Instead {
  nothing_else,  ///< all stays as it is
  nobody,        ///< nothing is as probable as all else together: the finding goes
  another        ///< the first of its effects is sure, and is another one; or there was no finding, and it is more
                 ///< probable than nothing and than something else
};

/// `found`: the finding in whose place the question was asked; nullptr: none was found.
Instead instead_of(const Finding* found, const Posterior& p);

/// Writes into a finding how sure it is: its margin over the next best explanation (ratio of the 2 ln likelihoods), the
/// other effects of the set, and why it is no name, where it is none.
void tell(Finding& f, const Posterior& p, const Alternatives& tried);

struct Decision {
  VerdictKind kind = VerdictKind::none;
  std::string reason;
};

/// Of findings that tell() has spoken to, or of none and the one question that was asked then. `more_needed`: as many
/// effects as there may be are found, and one more would still gain.
/// Named: one finding is sure at least. Unknown: something else is more probable than all effects in the place of the
/// largest, or more is needed. No gap: no effect was found, and nothing is the likeliest.
Decision decision_of(const std::vector<Finding>& findings, const std::vector<Posterior>& posteriors, bool more_needed);

}  // namespace airside::tools::gap
