#pragma once
// Fails a test that touches the heap where it must not. Linking airside_allocation_guard replaces malloc and its family
// (operator new of the C++ library calls them too); under a sanitizer, which owns malloc, its hooks are used instead.

#include <cstddef>
#include <cstdint>
#include <string>

namespace airside::footprint {

/// What one thread asked of the heap while a guard was armed on it.
struct HeapEvents {
  std::uint64_t allocations = 0;
  std::uint64_t releases = 0;  ///< of memory; free(nullptr) is none
  std::uint64_t bytes = 0;
  const char* first = "";  ///< entry point of the first event
  std::size_t first_bytes = 0;

  std::uint64_t total() const { return allocations + releases; }
};

/// Armed from construction to destruction on this thread; then any heap event is a failure of the running test.
/// Guards do not nest.
class AllocationGuard {
 public:
  explicit AllocationGuard(std::string what);
  ~AllocationGuard();
  AllocationGuard(const AllocationGuard&) = delete;
  AllocationGuard& operator=(const AllocationGuard&) = delete;

  /// Ends the watch and hands over what was seen, instead of failing.
  HeapEvents disarm();

 private:
  std::string what_;
  bool armed_ = true;
};

}  // namespace airside::footprint
