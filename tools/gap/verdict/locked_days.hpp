#pragma once
// Whether what was found helps on days that nobody looked at.

#include "tools/gap/verdict/fitted_case.hpp"
#include "tools/gap/verdict/verdict.hpp"

namespace airside::tools::gap {

/// Errors of two models on the locked days, and where the second one differs from the first.
/// Shape: residuals: bins x channels, all days.
LockedDays locked_days(const FittedCase& c, const Eigen::MatrixXd& before, const Eigen::MatrixXd& after);

/// A 2 ln likelihood below this is neither what was predicted nor nothing: N(e, 4 e) were the findings right.
double contradiction(const Rules& rules, double expected);

/// A small effect lowers the error by little, even where what it predicted has come true; a large one may be what moved
/// parameters would explain there as well, but must not be contradicted.
bool locked_days_agree(const Rules& rules, const LockedDays& locked);

}  // namespace airside::tools::gap
