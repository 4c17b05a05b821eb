#pragma once
// Counts calls of malloc and its family in this test program.

#include <cstdint>

namespace airside::hal {

/// Calls so far.
std::uint64_t allocations();
/// False where a sanitizer replaces the heap itself.
bool counts_allocations();

}  // namespace airside::hal
