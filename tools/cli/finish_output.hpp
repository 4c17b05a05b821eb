#pragma once
// The last thing a program does: see that what it said has arrived.

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <iostream>

namespace airside::tools {

/// Flushes standard output. Returns `code`, or 1 with a complaint on standard error where something of it was lost, so
/// that a script does not take an empty file for an answer.
inline int finish_output(int code) {
  errno = 0;
  const bool words_lost = std::cout.flush().fail();  // --help goes this way
  const bool lost = std::fflush(stdout) != 0 || std::ferror(stdout) != 0 || words_lost;
  if (!lost) return code;
  std::fprintf(stderr,
               "airside: standard output: found it full or closed%s%s; expected room for the whole answer; give it "
               "another place and run again\n",
               errno != 0 ? ": " : "", errno != 0 ? std::strerror(errno) : "");
  return code == 0 ? 1 : code;
}

}  // namespace airside::tools
