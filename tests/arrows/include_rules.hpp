#pragma once
// Which wing may include which (tests/arrows/arrows.txt), and the headers that lib may see at all.

#include <array>
#include <map>
#include <set>
#include <string>
#include <vector>

namespace airside::arrows {

/// One breach, as "file:line: what".
using Breaches = std::vector<std::string>;

/// The wings that each wing includes or may include. A wing is a folder of sources, such as "hal/modbus".
using Graph = std::map<std::string, std::set<std::string>>;

/// Top folders, each using only those before it.
inline constexpr std::array<const char*, 5> tops = {"lib", "hal", "sim", "firmware", "tools"};

/// Everything that lib may take from outside: what allocates nothing, does no I/O, knows no clock and no thread; of
/// <new> placement alone, since symbol_rules.hpp refuses the heap.
inline const std::set<std::string> lib_headers = {
    "Eigen/Cholesky", "Eigen/Core", "algorithm",        "arm_neon.h",  "array",       "bit",     "cassert",  "climits",
    "cmath",          "compare",    "concepts",         "cstddef",     "cstdint",     "cstring", "iterator", "limits",
    "immintrin.h",    "numbers",    "initializer_list", "numeric",     "optional",    "span",    "tuple",    "utility",
    "string_view",    "version",    "tl/expected.hpp",  "type_traits", "x86intrin.h", "new",
};

/// Reads the list of arrows. A wing may include only wings that are listed before it, so no list has a cycle; a line
/// that says otherwise, or says a thing twice, is a breach.
Graph read_arrows(const std::string& text, Breaches& breaches);

/// The wing of a file, "hal/modbus" for "hal/modbus/link.hpp"; of a header as it is included, where lib's begin with
/// "airside/". Empty for headers that are not the project's.
std::string wing_of(const std::string& path);

/// Wings that the text of one source includes, its own left out.
std::set<std::string> wings_included(const std::string& wing, const std::string& text);

/// What the text of one source of `wing` includes against the list. `file` only names it.
Breaches include_breaches(const Graph& arrows, const std::string& wing, const std::string& file,
                          const std::string& text);

/// CMake targets named in the text of a build file of top folder `folder` that no wing of it may include.
Breaches target_breaches(const Graph& arrows, const std::string& folder, const std::string& file,
                         const std::string& text);

/// The list for a graph of includes: the tightest one. Errors: a cycle is a breach, and its wings are left out.
std::string arrows_text(const Graph& used, Breaches& breaches);

/// Compiler options that remove NaN checks, in any text.
Breaches fast_math_breaches(const std::string& file, const std::string& text);

}  // namespace airside::arrows
