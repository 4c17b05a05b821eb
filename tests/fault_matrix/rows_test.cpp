// The matrix itself: 60 rows, and for each a test of the fault and one without it, by their names in the sources.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <regex>

namespace airside::fault_matrix {
namespace {

struct Halves {
  int handled = 0, without = 0;
};

std::map<int, Halves> named_rows() {
  std::map<int, Halves> rows;
  const std::regex name(R"(TEST\w*\(\s*\w+,\s*((?:Row\d\d)+)(Without)?)"), number(R"(Row(\d\d))");
  for (const auto& entry : std::filesystem::recursive_directory_iterator(AIRSIDE_SOURCE_DIR "/tests")) {
    if (entry.path().extension() != ".cpp") continue;
    std::ifstream file(entry.path());
    const std::string text{std::istreambuf_iterator<char>(file), {}};
    for (std::sregex_iterator at(text.begin(), text.end(), name), end; at != end; ++at) {
      const std::string list = (*at)[1];
      for (std::sregex_iterator row(list.begin(), list.end(), number); row != end; ++row) {
        Halves& halves = rows[std::stoi((*row)[1])];
        ++((*at)[2].matched ? halves.without : halves.handled);
      }
    }
  }
  return rows;
}

TEST(FaultMatrix, EveryRowHasATestOfTheFaultAndOneWithoutIt) {
  const std::map<int, Halves> rows = named_rows();
  for (int row = 1; row <= 60; ++row) {
    const auto at = rows.find(row);
    const Halves halves = at == rows.end() ? Halves{} : at->second;
    EXPECT_GT(halves.handled, 0) << "no test of row " << row;
    EXPECT_GT(halves.without, 0) << "no test without the fault of row " << row;
  }
  EXPECT_EQ(rows.size(), 60u);
}

}  // namespace
}  // namespace airside::fault_matrix
