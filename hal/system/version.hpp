#pragma once
// The version that every program names: the one in the project's CMakeLists.txt.

#include <string>

namespace airside::hal {

/// "0.1.0", for records and reports.
const char* version();

/// "airsided 0.1.0", the answer to --version.
std::string version_line(const char* program);

}  // namespace airside::hal
