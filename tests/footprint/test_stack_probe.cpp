#include <gtest/gtest.h>

#include "support/stack_probe.hpp"

namespace airside::footprint {
namespace {

/// Recursion of one kilobyte a level; the compiler must believe that each level's kilobyte is used.
[[gnu::noinline]] int go_down(int levels) {
  char room[1024];
  room[0] = static_cast<char>(levels);
  asm volatile("" : : "r"(&room[0]) : "memory");
  const int below = levels > 1 ? go_down(levels - 1) : 0;
  asm volatile("" : : "r"(&room[0]) : "memory");
  return below + room[0];
}

TEST(StackProbe, SeesHowDeepACallGoes) {
  const std::size_t ten = stack_used([] { go_down(10); });
  const std::size_t hundred = stack_used([] { go_down(100); });
  EXPECT_GE(ten, 10u * 1024);
  EXPECT_LE(ten, 16u * 1024);
  EXPECT_NEAR(static_cast<double>(hundred - ten), 90 * 1100, 90 * 100);
}

TEST(StackProbe, SeesNothingInAnEmptyCall) {
  EXPECT_LE(stack_used([] {}), 1024u);
}

}  // namespace
}  // namespace airside::footprint
