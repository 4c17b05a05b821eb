#pragma once
// Tests on site that were done after a case's measured days: tests.json beside case.json, one log a test.
// Format: docs/formats.md, "Cases of the gap workflow".

#include <filesystem>
#include <string>
#include <vector>

#include "airside/civil_time.hpp"

namespace airside::tools::gap {

struct CaseTest {
  std::string name;  ///< of its plan: "night_purge"
  std::string log;   ///< file in the case's folder
  CivilTime from;    ///< midnight of its first day
};

/// In the order in which they were done; empty where none was.
/// Errors: hal::InputError with file and key.
std::vector<CaseTest> read_case_tests(const std::filesystem::path& folder);

/// Errors: hal::InputError for a file that cannot be written.
void write_case_tests(const std::filesystem::path& folder, const std::vector<CaseTest>& tests);

}  // namespace airside::tools::gap
