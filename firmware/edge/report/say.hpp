#pragma once
// One line to standard error, where the service manager adds the time.

#include <fmt/format.h>

#include <array>
#include <cstdio>

namespace airside::edge {

/// Cost: no heap for lines of up to 511 characters; longer ones are cut.
template <class... Args>
void say(fmt::format_string<Args...> format, Args&&... args) {
  std::array<char, 512> line;
  const auto r = fmt::format_to_n(line.data(), line.size() - 1, format, std::forward<Args>(args)...);
  *r.out = '\n';
  std::fwrite(line.data(), 1, static_cast<std::size_t>(r.out - line.data()) + 1, stderr);
}

}  // namespace airside::edge
