#pragma once
// What object code of lib may ask of the outside, and what it may define: no heap, exceptions, RTTI, I/O, threads,
// clocks or mutable globals. Read from `objdump -t`, so it holds for what the compiler really made of every header.

#include <string>
#include <vector>

namespace airside::arrows {

/// Whether lib may leave `symbol` undefined: C string functions, mathematics, the compiler's own arithmetic.
bool may_need(const std::string& symbol);

/// Symbols against the rules in the text of `objdump -t` of objects that are linked together, as "needs malloc" or
/// "defines mutable counter".
std::vector<std::string> symbol_breaches(const std::string& objdump_text);

}  // namespace airside::arrows
