#pragma once
// Which folder may use which (DESIGN.md, "Arrows and rooms"), and the headers that lib may see at all.

#include <map>
#include <set>
#include <string>
#include <vector>

namespace airside::arrows {

/// One breach, as "file:line: what".
using Breaches = std::vector<std::string>;

/// Folders whose headers a folder may include; "airside" is lib.
inline const std::map<std::string, std::set<std::string>> may_include = {
    {"lib", {"airside"}},
    {"hal", {"airside", "hal"}},
    {"sim", {"airside", "hal", "sim"}},
    {"firmware", {"airside", "hal", "firmware"}},
    {"tools", {"airside", "hal", "sim", "tools"}},
};

/// Everything that lib may take from outside: what allocates nothing, does no I/O, knows no clock and no thread.
inline const std::set<std::string> lib_headers = {
    "Eigen/Cholesky", "Eigen/Core", "algorithm",        "arm_neon.h",  "array",       "bit",     "cassert",  "climits",
    "cmath",          "compare",    "concepts",         "cstddef",     "cstdint",     "cstring", "iterator", "limits",
    "immintrin.h",    "numbers",    "initializer_list", "numeric",     "optional",    "span",    "tuple",    "utility",
    "string_view",    "version",    "tl/expected.hpp",  "type_traits", "x86intrin.h",
};

/// What the text of one source of `folder` includes against the rules. `file` only names it.
Breaches include_breaches(const std::string& folder, const std::string& file, const std::string& text);

/// CMake targets named in the text of a build file of `folder` against the rules.
Breaches target_breaches(const std::string& folder, const std::string& file, const std::string& text);

/// Compiler options that remove NaN checks, in any text.
Breaches fast_math_breaches(const std::string& file, const std::string& text);

}  // namespace airside::arrows
