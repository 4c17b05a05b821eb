#pragma once
// Numbers of registers as vendors' tables have them.

#include <array>
#include <optional>
#include <string>

namespace airside::tools {

/// How vendors' tables number what one function reads: `first` is its address 0.
struct VendorNumbers {
  int first, last, fc;

  /// "in a vendor's table 40001 is usually register 0 of function 3"
  std::string in_words() const;
};

constexpr std::array<VendorNumbers, 3> vendor_numbers = {{{10001, 19999, 2}, {30001, 39999, 4}, {40001, 49999, 3}}};

/// The numbers among which an address lies, if any.
std::optional<VendorNumbers> vendor_numbers_of(int addr);

}  // namespace airside::tools
