#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <string>

#include "arrows/symbol_rules.hpp"

namespace airside::arrows {
namespace {

/// Output of `objdump -t` on files separated by '|'.
std::string symbols_of(const std::string& files) {
  std::string command = "'" AIRSIDE_OBJDUMP "' -t";
  std::size_t from = 0;
  while (from <= files.size()) {
    const std::size_t to = std::min(files.find('|', from), files.size());
    if (to > from) command += " '" + files.substr(from, to - from) + "'";
    from = to + 1;
  }
  std::FILE* pipe = popen(command.c_str(), "r");
  if (pipe == nullptr) return {};
  std::string text;
  std::array<char, 4096> piece{};
  while (const std::size_t n = std::fread(piece.data(), 1, piece.size(), pipe)) text.append(piece.data(), n);
  return pclose(pipe) == 0 ? text : std::string();
}

std::string joined(const std::vector<std::string>& lines) {
  std::string text;
  for (const std::string& line : lines) text += line + "\n";
  return text;
}

TEST(Symbols, LibNeedsNoHeapExceptionIoThreadOrClock) {
  const std::string text = symbols_of(AIRSIDE_LIB_OBJECTS);
  ASSERT_NE(text.find("airside"), std::string::npos) << "no symbols in " AIRSIDE_LIB_OBJECTS;
  EXPECT_EQ(joined(symbol_breaches(text)), "") << "in " AIRSIDE_LIB_OBJECTS;
}

TEST(Symbols, ACounterexampleIsSeenInEveryWay) {
  const auto breaches = symbol_breaches(symbols_of(AIRSIDE_COUNTEREXAMPLE));
  const auto has = [&](const std::string& text) {
    return std::any_of(breaches.begin(), breaches.end(), [&](const auto& b) { return b.starts_with(text); });
  };
  for (const char* text :
       {"needs malloc", "needs free", "needs _Znwm", "needs _ZdlPv", "needs __cxa_throw",
        "needs __cxa_allocate_exception", "needs __dynamic_cast", "needs fopen", "needs pthread_mutex_lock",
        "needs clock_gettime", "defines mutable _ZN7airside6arrows7counterE",
        "defines mutable _ZN7airside6arrows14thread_counterE", "defines virtual table _ZTV",
        "defines type information _ZTI"}) {
    EXPECT_TRUE(has(text)) << text << " is not among\n" << joined(breaches);
  }
  EXPECT_TRUE(has("needs fprintf") || has("needs __fprintf_chk"));
}

}  // namespace
}  // namespace airside::arrows
