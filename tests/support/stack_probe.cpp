#include "support/stack_probe.hpp"

#include <pthread.h>
#include <sys/mman.h>

#include <cstring>
#include <stdexcept>

namespace airside::footprint {
namespace {

constexpr std::size_t stack_bytes = 8u << 20;
constexpr unsigned char paint = 0xA5;

struct Job {
  void (*run)(void*);
  void* context;
};

void* start(void* job_pointer) {
  const Job& job = *static_cast<const Job*>(job_pointer);
  job.run(job.context);
  return nullptr;
}

/// Everything below the top of the stack that lost its paint, the thread's own record and start included.
std::size_t touched(Job job) {
  void* stack = mmap(nullptr, stack_bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (stack == MAP_FAILED) throw std::runtime_error("no memory for a painted stack");
  std::memset(stack, paint, stack_bytes);
  pthread_attr_t attributes;
  pthread_attr_init(&attributes);
  pthread_t thread{};
  const bool ran = pthread_attr_setstack(&attributes, stack, stack_bytes) == 0 &&
                   pthread_create(&thread, &attributes, start, &job) == 0 && pthread_join(thread, nullptr) == 0;
  pthread_attr_destroy(&attributes);
  const auto* bytes = static_cast<const unsigned char*>(stack);
  std::size_t clean = 0;
  while (clean < stack_bytes && bytes[clean] == paint) ++clean;
  munmap(stack, stack_bytes);
  if (!ran) throw std::runtime_error("no thread on a painted stack");
  if (clean < (1u << 20)) throw std::runtime_error("more than 7 MB of stack used");
  return stack_bytes - clean;
}

}  // namespace

std::size_t stack_used(void (*run)(void*), void* context) {
  const std::size_t empty = touched({[](void*) {}, nullptr});
  const std::size_t full = touched({run, context});
  return full > empty ? full - empty : 0;
}

}  // namespace airside::footprint
