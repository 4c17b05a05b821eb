#pragma once
// Bills beside what the model uses, as a picture.

#include <string>

#include "tools/gap/bills/bill_verdict.hpp"

namespace airside::tools::gap {

/// One row of bars a meter: each bill, and in front of it what the model as it is uses in the same days.
/// A file of its own. Shape: 760 x (60 + 200 a meter) user units.
std::string bills_svg(const BillTable& bills, const BillVerdict& verdict);

}  // namespace airside::tools::gap
