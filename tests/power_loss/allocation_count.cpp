#include "power_loss/allocation_count.hpp"

#include <atomic>
#include <cstddef>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define AIRSIDE_OWN_MALLOC 0
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define AIRSIDE_OWN_MALLOC 0
#endif
#endif
#ifndef AIRSIDE_OWN_MALLOC
#define AIRSIDE_OWN_MALLOC 1
#endif

namespace {
std::atomic<std::uint64_t> calls{0};
}

#if AIRSIDE_OWN_MALLOC
extern "C" {
void* __libc_malloc(size_t size);
void* __libc_calloc(size_t count, size_t size);
void* __libc_realloc(void* old, size_t size);
void* malloc(size_t size) {
  ++calls;
  return __libc_malloc(size);
}
void* calloc(size_t count, size_t size) {
  ++calls;
  return __libc_calloc(count, size);
}
void* realloc(void* old, size_t size) {
  ++calls;
  return __libc_realloc(old, size);
}
}
#endif

namespace airside::hal {

std::uint64_t allocations() { return calls.load(); }
bool counts_allocations() { return AIRSIDE_OWN_MALLOC != 0; }

}  // namespace airside::hal
