// Code that lib must never hold; test_symbols.cpp shows that the check sees each kind of it.

#include <pthread.h>

#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <vector>

namespace airside::arrows {

int counter = 0;
thread_local int thread_counter = 1;

struct Base {
  virtual ~Base() = default;
};
struct Derived : Base {
  int value = 0;
};

double* from_malloc(std::size_t n) { return static_cast<double*>(std::malloc(n)); }
void to_free(void* memory) { std::free(memory); }
std::vector<double> from_new(std::size_t n) { return std::vector<double>(n); }
int thrower(Base* base) {
  if (auto* derived = dynamic_cast<Derived*>(base)) return derived->value + counter++ + thread_counter++;
  throw 1;
}
int speaker(std::FILE* file) { return std::fprintf(file, "%d", counter); }
std::FILE* opener(const char* name) { return std::fopen(name, "r"); }
int locker(pthread_mutex_t* mutex) { return pthread_mutex_lock(mutex); }
int clock_reader(timespec* now) { return clock_gettime(CLOCK_MONOTONIC, now); }
Base* maker() { return new Derived; }

}  // namespace airside::arrows
