#pragma once
// Numbers in complaints.

#include <charconv>
#include <string>

namespace airside::hal {

/// The shortest text that reads back as `value`.
inline std::string number_text(double value) {
  char text[32];
  return {text, std::to_chars(text, text + sizeof text, value).ptr};
}

}  // namespace airside::hal
