#include "support/allocation_guard.hpp"

#include <gtest/gtest.h>

#include <cerrno>

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define AIRSIDE_SANITIZED_HEAP 1
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer) || __has_feature(memory_sanitizer)
#define AIRSIDE_SANITIZED_HEAP 1
#endif
#endif

namespace airside::footprint {
namespace {

// Plain thread-locals of the program itself: reading them allocates nothing, so malloc may.
thread_local bool armed = false;
thread_local HeapEvents seen;

void note_allocation(const char* entry, std::size_t bytes) {
  if (!armed) return;
  if (seen.total() == 0) seen.first = entry, seen.first_bytes = bytes;
  ++seen.allocations;
  seen.bytes += bytes;
}

void note_release(const char* entry) {
  if (!armed) return;
  if (seen.total() == 0) seen.first = entry;
  ++seen.releases;
}

}  // namespace
}  // namespace airside::footprint

#ifdef AIRSIDE_SANITIZED_HEAP

extern "C" int __sanitizer_install_malloc_and_free_hooks(void (*malloc_hook)(const volatile void*, std::size_t),
                                                         void (*free_hook)(const volatile void*));

namespace {
void on_malloc(const volatile void*, std::size_t bytes) { airside::footprint::note_allocation("an allocation", bytes); }
void on_free(const volatile void* memory) {
  if (memory != nullptr) airside::footprint::note_release("free");
}
const int hooks = __sanitizer_install_malloc_and_free_hooks(on_malloc, on_free);
}  // namespace

#else

// The C library's own allocator under its other names.
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);

void* malloc(std::size_t bytes) noexcept {
  airside::footprint::note_allocation("malloc", bytes);
  return __libc_malloc(bytes);
}
void* calloc(std::size_t count, std::size_t bytes) noexcept {
  airside::footprint::note_allocation("calloc", count * bytes);
  return __libc_calloc(count, bytes);
}
void* realloc(void* memory, std::size_t bytes) noexcept {
  airside::footprint::note_allocation("realloc", bytes);
  return __libc_realloc(memory, bytes);
}
void* reallocarray(void* memory, std::size_t count, std::size_t bytes) noexcept {
  std::size_t product = 0;
  if (__builtin_mul_overflow(count, bytes, &product)) {
    errno = ENOMEM;
    return nullptr;
  }
  airside::footprint::note_allocation("reallocarray", product);
  return __libc_realloc(memory, product);
}
void* memalign(std::size_t alignment, std::size_t bytes) noexcept {
  airside::footprint::note_allocation("memalign", bytes);
  return __libc_memalign(alignment, bytes);
}
void* aligned_alloc(std::size_t alignment, std::size_t bytes) noexcept {
  airside::footprint::note_allocation("aligned_alloc", bytes);
  return __libc_memalign(alignment, bytes);
}
int posix_memalign(void** memory, std::size_t alignment, std::size_t bytes) noexcept {
  airside::footprint::note_allocation("posix_memalign", bytes);
  if (alignment < sizeof(void*) || (alignment & (alignment - 1)) != 0) return EINVAL;
  void* block = __libc_memalign(alignment, bytes);
  if (block == nullptr) return ENOMEM;
  *memory = block;
  return 0;
}
void free(void* memory) noexcept {
  if (memory != nullptr) airside::footprint::note_release("free");
  __libc_free(memory);
}
}

#endif

namespace airside::footprint {

AllocationGuard::AllocationGuard(std::string what) : what_(std::move(what)) {
#ifdef AIRSIDE_SANITIZED_HEAP
  if (hooks == 0) ADD_FAILURE() << "the sanitizer took no allocation hooks";
#endif
  seen = {};
  armed = true;
}

HeapEvents AllocationGuard::disarm() {
  armed = false;
  armed_ = false;
  return seen;
}

AllocationGuard::~AllocationGuard() {
  if (!armed_) return;
  const HeapEvents events = disarm();
  if (events.total() == 0) return;
  ADD_FAILURE() << what_ << " touched the heap: " << events.allocations << " allocations of " << events.bytes
                << " bytes, " << events.releases << " releases, first " << events.first << "(" << events.first_bytes
                << ")";
}

}  // namespace airside::footprint
