#pragma once
// A number with its interval, in no more digits than the interval leaves it.

#include <string>

namespace airside::tools::gap {

/// "2.5 ± 0.3", "0.82 ± 0.14", "120 ± 30": the half width in one digit, in two where it begins with 1, and the value in
/// as many decimals. Without a half width above zero the value alone, in two digits.
std::string with_interval(double value, double half_width);

}  // namespace airside::tools::gap
