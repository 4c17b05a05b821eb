#include <gtest/gtest-spi.h>
#include <gtest/gtest.h>
#include <malloc.h>

#include <cstdlib>
#include <functional>
#include <new>
#include <thread>
#include <vector>

#include "support/allocation_guard.hpp"
#include "support/sanitized.hpp"

namespace airside::footprint {
namespace {

// Through a volatile pointer, lest the compiler remove a pair of allocation and release.
void* volatile block = nullptr;

HeapEvents events_of(void (*act)()) {
  AllocationGuard guard("test");
  act();
  return guard.disarm();
}

struct alignas(64) Wide {
  double value[8];
};

struct EntryPoint {
  const char* name;
  void (*act)();
  bool aligned = false;  ///< or an array: the thread sanitizer has no hook for these, or none that knows the size
};

const EntryPoint entry_points[] = {
    {"malloc", [] { block = std::malloc(24), std::free(block); }},
    {"calloc", [] { block = std::calloc(3, 8), std::free(block); }},
    {"realloc", [] { block = std::realloc(nullptr, 24), std::free(block); }},
    {"reallocarray", [] { block = reallocarray(nullptr, 3, 8), std::free(block); }, true},
    {"posix_memalign",
     [] {
       void* memory = nullptr;
       if (posix_memalign(&memory, 64, 128) == 0) block = memory;
       std::free(block);
     },
     true},
    {"aligned_alloc", [] { block = std::aligned_alloc(64, 128), std::free(block); }, true},
    {"memalign", [] { block = memalign(64, 128), std::free(block); }, true},
    {"operator new", [] { block = ::operator new(24), ::operator delete(block); }},
    {"operator new[]", [] { block = ::operator new[](24), ::operator delete[](block); }},
    {"operator new nothrow", [] { block = ::operator new(24, std::nothrow), ::operator delete(block, std::nothrow); }},
    {"operator new aligned",
     [] {
       block = ::operator new(sizeof(Wide), std::align_val_t(64));
       ::operator delete(block, std::align_val_t(64));
     }},
    {"operator new[] aligned",
     [] {
       block = ::operator new[](sizeof(Wide), std::align_val_t(64));
       ::operator delete[](block, std::align_val_t(64));
     }},
};

TEST(AllocationGuard, FiresForEveryEntryPoint) {
  for (const EntryPoint& entry : entry_points) {
    if (thread_sanitized && entry.aligned) continue;
    const HeapEvents events = events_of(entry.act);
    EXPECT_EQ(events.allocations, 1u) << entry.name;
    EXPECT_EQ(events.releases, 1u) << entry.name;
    EXPECT_GE(events.bytes, 24u) << entry.name;
  }
}

TEST(AllocationGuard, FailsTheTestAndSaysWhat) {
  EXPECT_NONFATAL_FAILURE(
      {
        AllocationGuard guard("one cycle");
        block = std::malloc(24);
        std::free(block);
      },
      "one cycle touched the heap: 1 allocations of 24 bytes, 1 releases");
}

TEST(AllocationGuard, SeesAReleaseAlone) {
  block = std::malloc(24);
  const HeapEvents events = events_of([] { std::free(block); });
  EXPECT_EQ(events.allocations, 0u);
  EXPECT_EQ(events.releases, 1u);
}

TEST(AllocationGuard, SeesContainersOfTheStandardLibrary) {
  const HeapEvents events = events_of([] {
    std::vector<int> list(3);
    block = list.data();
  });
  EXPECT_EQ(events.allocations, 1u);
}

TEST(AllocationGuard, PassesWhatStaysOnTheStack) {
  AllocationGuard guard("a sum");
  volatile double sum = 0;
  for (int i = 0; i < 100; ++i) sum = sum + i;
  std::free(nullptr);
}

TEST(AllocationGuard, WatchesItsOwnThreadOnly) {
  bool go = false, done = false;
  std::thread other([&] {
    while (!__atomic_load_n(&go, __ATOMIC_ACQUIRE)) std::this_thread::yield();
    std::vector<int> list(1000);
    block = list.data();
    __atomic_store_n(&done, true, __ATOMIC_RELEASE);
  });
  AllocationGuard guard("this thread");
  __atomic_store_n(&go, true, __ATOMIC_RELEASE);
  while (!__atomic_load_n(&done, __ATOMIC_ACQUIRE)) std::this_thread::yield();
  const HeapEvents events = guard.disarm();
  other.join();
  EXPECT_EQ(events.total(), 0u);
}

TEST(AllocationGuard, IsDisarmedAfterItsScope) {
  { AllocationGuard guard("nothing"); }
  block = std::malloc(24);
  std::free(block);
}

}  // namespace
}  // namespace airside::footprint
