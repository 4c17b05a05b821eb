#pragma once
// Whether what was found helps on days that nobody looked at.

#include "tools/gap/verdict/fitted_case.hpp"
#include "tools/gap/verdict/verdict.hpp"

namespace airside::tools::gap {

/// Errors of two models on the locked days, and where the second one differs from the first.
/// Shape: residuals: bins x channels, all days.
LockedDays locked_days(const FittedCase& c, const Eigen::MatrixXd& before, const Eigen::MatrixXd& after);

}  // namespace airside::tools::gap
