#pragma once
// One line to standard error. The service manager's journal adds the time; where nobody does, the line begins with it.

#include <fmt/format.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <ctime>

#include "hal/text/civil_text.hpp"

namespace airside::edge {

/// Writes `2026-11-28T15:04:05Z ` before a line that the journal does not stamp.  Cost: no heap.
inline char* write_line_time(char* to) {
  if (std::getenv("JOURNAL_STREAM") != nullptr) return to;
  hal::write_civil_text(to, {std::time(nullptr)});
  to += hal::civil_text_size;
  *to++ = 'Z';
  *to++ = ' ';
  return to;
}

/// Cost: no heap for lines of up to 490 characters; longer ones are cut.
template <class... Args>
void say(fmt::format_string<Args...> format, Args&&... args) {
  std::array<char, 512> line;
  char* const begin = write_line_time(line.data());
  const auto room = static_cast<std::size_t>(line.data() + line.size() - 1 - begin);
  const auto r = fmt::format_to_n(begin, room, format, std::forward<Args>(args)...);
  *r.out = '\n';
  std::fwrite(line.data(), 1, static_cast<std::size_t>(r.out - line.data()) + 1, stderr);
}

}  // namespace airside::edge
