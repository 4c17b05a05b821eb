#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <sstream>
#include <string>
#include <vector>

namespace airside::footprint {
namespace {

constexpr long frame_budget_bytes = 16 * 1024;
constexpr long whole_budget_bytes = 64 * 1024;

/// One function of a .su file, which -fstack-usage leaves beside each object.
struct Frame {
  std::string function;
  long bytes = 0;
  std::string kind;  ///< "static", "dynamic" (alloca: unbounded) or "dynamic,bounded"
};

/// Reads "file:line:column:function TAB bytes TAB kind"; GCC leaves the place out of some lines of clones.
std::vector<Frame> frames_in(std::istream& in) {
  std::vector<Frame> frames;
  std::string line;
  while (std::getline(in, line)) {
    const std::size_t kind = line.rfind('\t'), bytes = kind == 0 ? kind : line.rfind('\t', kind - 1);
    if (kind == std::string::npos || bytes == std::string::npos) continue;
    frames.push_back({line.substr(0, bytes), std::stol(line.substr(bytes + 1, kind - bytes)), line.substr(kind + 1)});
  }
  return frames;
}

std::vector<Frame> frames_of_lib() {
  std::vector<Frame> frames;
  std::istringstream folders(AIRSIDE_STACK_USAGE_DIRS);
  std::string folder;
  while (std::getline(folders, folder, '|')) {
    for (const auto& entry : std::filesystem::recursive_directory_iterator(folder)) {
      if (entry.path().extension() != ".su") continue;
      std::ifstream in(entry.path());
      for (Frame& frame : frames_in(in)) frames.push_back(std::move(frame));
    }
  }
  std::sort(frames.begin(), frames.end(), [](const Frame& a, const Frame& b) { return a.bytes > b.bytes; });
  return frames;
}

/// Frames that break the budget, one a line.
std::string over_budget(const std::vector<Frame>& frames) {
  std::string text;
  for (const Frame& frame : frames) {
    if (frame.kind == "dynamic") text += "unbounded: " + frame.function + "\n";
    if (frame.bytes > frame_budget_bytes) text += std::to_string(frame.bytes) + " bytes: " + frame.function + "\n";
  }
  return text;
}

TEST(StackFrames, OfLibAreBoundedAndWithinTheirBudget) {
  const std::vector<Frame> frames = frames_of_lib();
  ASSERT_GT(frames.size(), 10u) << "no .su files below " AIRSIDE_STACK_USAGE_DIRS;
  for (std::size_t i = 0; i < std::min<std::size_t>(8, frames.size()); ++i) {
    std::cout << frames[i].bytes << " bytes " << frames[i].kind << ": " << frames[i].function << "\n";
  }
  EXPECT_EQ(over_budget(frames), "");
}

TEST(StackFrames, FourLargestTogetherFitTheWholeBudget) {
  const std::vector<Frame> frames = frames_of_lib();
  long sum = 0;
  for (std::size_t i = 0; i < std::min<std::size_t>(4, frames.size()); ++i) sum += frames[i].bytes;
  EXPECT_LE(sum, whole_budget_bytes) << "of 65536 bytes for all nested calls";
}

TEST(StackFrames, OverBudgetIsSeen) {
  std::istringstream text(
      "a.cpp:1:1:void f()\t16385\tstatic\n"
      "a.cpp:2:1:void g()\t48\tdynamic\n"
      "a.cpp:3:1:void h()\t16384\tdynamic,bounded\n");
  EXPECT_EQ(over_budget(frames_in(text)), "16385 bytes: a.cpp:1:1:void f()\nunbounded: a.cpp:2:1:void g()\n");
}

}  // namespace
}  // namespace airside::footprint
