// An image that allocates: it must not link.

#include "firmware/cortex_m/board.hpp"

#ifdef WITH_MALLOC
#include <cstdlib>
int run_image() { return std::malloc(16) != nullptr; }
#else
int* volatile kept;  // else the compiler would leave the allocation out
int run_image() {
  kept = new int(1);
  return 0;
}
#endif
