#include "tools/cli/site/ask/vendor_numbers.hpp"

#include <fmt/format.h>

namespace airside::tools {

std::string VendorNumbers::in_words() const {
  return fmt::format("in a vendor's table {} is usually register 0 of function {}", first, fc);
}

std::optional<VendorNumbers> vendor_numbers_of(int addr) {
  for (const VendorNumbers& numbers : vendor_numbers) {
    if (addr >= numbers.first && addr <= numbers.last) return numbers;
  }
  return {};
}

}  // namespace airside::tools
