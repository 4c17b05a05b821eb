#pragma once
// What the gap workflow leaves behind: a folder, whole or not at all, and words on the terminal.

#include <cstdio>
#include <filesystem>
#include <string>

#include "tools/gap/run/gap_run.hpp"
#include "tools/run/run_facts.hpp"

namespace airside::tools {

struct GapFolder {
  std::filesystem::path out;
  std::string apply;          ///< file of the patched twin; empty: none
  bool patched_room = false;  ///< the patched RC room is written too
};

/// The report, gap.json, patch and ledger.  Returns what --json prints.
/// Errors: hal::InputError where it cannot be written.
nlohmann::json write_gap_folder(const gap::GapRun& run, const RunFacts& facts, const GapFolder& to);

/// To standard output: `j` with --json, else in words.
void print_gap(const gap::GapRun& run, const nlohmann::json& j, const RunFacts& facts, bool json);

/// The clean-up table of a log.
void print_clean_up(std::FILE* to, const gap::CleanLog& log);

}  // namespace airside::tools
