#pragma once
// Lines of text from a fixed buffer: printf of a C library for microcontrollers allocates.

#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace airside::cortex_m {

/// Builds one line; `end()` hands it to `write(text)` and begins the next. What does not fit is cut off.
class LineWriter {
 public:
  using Write = void (*)(std::string_view line);
  explicit LineWriter(Write write) : write_(write) {}

  LineWriter& text(std::string_view s) {
    for (const char c : s) put(c);
    return *this;
  }
  LineWriter& number(std::int64_t n) {
    std::array<char, 20> digits{};
    std::size_t count = 0;
    std::uint64_t rest = n < 0 ? 0 - static_cast<std::uint64_t>(n) : static_cast<std::uint64_t>(n);
    do {
      digits[count++] = static_cast<char>('0' + rest % 10);
      rest /= 10;
    } while (rest != 0);
    if (n < 0) put('-');
    while (count > 0) put(digits[--count]);
    return *this;
  }
  LineWriter& hex(std::uint64_t bits, int digits) {
    for (int i = digits - 1; i >= 0; --i) put("0123456789abcdef"[(bits >> (4 * i)) & 15u]);
    return *this;
  }
  /// The 64 bits of a double; any NaN is `nan`, since CPUs differ in the sign and payload of those they make.
  LineWriter& bits(double value) {
    return std::isnan(value) ? text("nan") : hex(std::bit_cast<std::uint64_t>(value), 16);
  }
  void end() {
    put('\n');
    write_({line_.data(), length_});
    length_ = 0;
  }

 private:
  void put(char c) {
    if (length_ < line_.size()) line_[length_++] = c;
  }

  Write write_;
  std::array<char, 240> line_{};
  std::size_t length_ = 0;
};

}  // namespace airside::cortex_m
