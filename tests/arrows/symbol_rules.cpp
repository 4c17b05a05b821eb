#include "arrows/symbol_rules.hpp"

#include <regex>
#include <set>
#include <sstream>

namespace airside::arrows {

bool may_need(const std::string& symbol) {
  static const std::regex allowed(
      "memcpy|memmove|memset|memcmp|strlen|strcmp|strncmp|"
      "(exp|expm1|exp2|log|log1p|log2|log10|pow|sqrt|cbrt|sin|cos|tan|atan|atan2|asin|acos|sinh|cosh|tanh|fabs|floor|"
      "ceil|round|lround|llround|rint|lrint|nearbyint|trunc|fmod|fmin|fmax|fma|hypot|ldexp|frexp|copysign)[fl]?|"
      "_GLOBAL_OFFSET_TABLE_|__stack_chk_fail|__assert_fail|abort|_ZSt9terminatev|"
      "__cpu_model|__cpu_features2|__cpu_indicator_init|__aeabi_.*|__[a-z]+[dstx]i[23]|__[a-z]+[dst]f[23]");
  return std::regex_match(symbol, allowed);
}

std::vector<std::string> symbol_breaches(const std::string& objdump_text) {
  // "address flags section size name", flags being seven characters; flag O is an object (thread-locals lack it), flag
  // d the section's own entry; section *UND* means undefined.
  static const std::regex row(R"(^[0-9a-f]+ (.{7}) (\S+)\s+[0-9a-f]+\s+(?:\.hidden )?(\S+)\s*$)");
  static const std::regex mutable_section(R"(\.data|\.data\.(?!rel\.ro).*|\.bss.*|\.tbss.*|\.tdata.*|\*COM\*)");
  std::set<std::string> needed, defined, breaches;
  std::istringstream in(objdump_text);
  std::string line;
  while (std::getline(in, line)) {
    std::smatch match;
    if (!std::regex_match(line, match, row)) continue;
    const std::string flags = match[1], section = match[2], name = match[3];
    if (section == "*UND*") {
      needed.insert(name);
      continue;
    }
    defined.insert(name);
    const bool object = flags.find('O') != std::string::npos || (section.starts_with(".t") && flags[5] != 'd');
    if (object && std::regex_match(section, mutable_section)) breaches.insert("defines mutable " + name);
    if (name.starts_with("_ZTV")) breaches.insert("defines virtual table " + name);
    if (name.starts_with("_ZTI")) breaches.insert("defines type information " + name);
  }
  for (const std::string& name : needed) {
    if (!defined.contains(name) && !may_need(name)) breaches.insert("needs " + name);
  }
  return {breaches.begin(), breaches.end()};
}

}  // namespace airside::arrows
