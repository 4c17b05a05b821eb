#pragma once
// JSON into memory of fixed size.

#include <fmt/format.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <span>
#include <string_view>
#include <utility>

namespace airside::edge {

/// Appends to a fixed buffer; what does not fit is cut and noticed.
class FixedText {
 public:
  explicit FixedText(std::span<char> out) : out_(out) {}
  template <class... Args>
  void add(fmt::format_string<Args...> format, Args&&... args) {
    const auto r = fmt::format_to_n(out_.data() + used_, out_.size() - used_, format, std::forward<Args>(args)...);
    fits_ = fits_ && r.size <= out_.size() - used_;
    used_ = fits_ ? used_ + r.size : out_.size();
  }
  /// A JSON number, null where there is none.
  void number(const char* name, double value) {
    if (std::isfinite(value)) {
      add(",\"{}\":{:.6g}", name, value);
    } else {
      add(",\"{}\":null", name);
    }
  }
  /// A JSON string; control characters, quotes and backslashes become spaces.
  void string(const char* name, std::string_view value) {
    add(",\"{}\":\"", name);
    for (const char c : value) add("{}", static_cast<unsigned char>(c) < 0x20 || c == '"' || c == '\\' ? ' ' : c);
    add("\"");
  }
  void count(const char* name, std::uint64_t value) { add(",\"{}\":{}", name, value); }
  bool fits() const { return fits_; }
  std::size_t size() const { return used_; }

 private:
  std::span<char> out_;
  std::size_t used_ = 0;
  bool fits_ = true;
};

}  // namespace airside::edge
