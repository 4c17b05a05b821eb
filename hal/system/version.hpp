#pragma once
// What every program is: the version of the project's CMakeLists.txt, and the commit that it was built from.

#include <string>

namespace airside::hal {

/// "0.1.0", for records and reports.
const char* version();

/// The commit, "-dirty" behind it where files differed; "unknown" outside a checkout. Programs that ask link
/// airside_commit.
const char* commit();

/// "airsided 0.1.0, commit 5e7cc18", the answer to --version; without a commit where it is unknown.
inline std::string version_line(const char* program) {
  const std::string known = commit() == std::string("unknown") ? std::string() : std::string(", commit ") + commit();
  return std::string(program) + " " + version() + known;
}

}  // namespace airside::hal
