#pragma once
// What the subcommands of `airside gap` share.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "sim/effects/effect.hpp"

namespace airside::tools {

/// Adds `airside gap retrain`: what a patched twin is worth to the controller.
void add_gap_retrain(CLI::App& gap);

/// Adds `airside gap next`: more days, or a test on site, after a first verdict.
void add_gap_next(CLI::App& gap);

/// Adds `airside gap run-cases`: a verdict for every case of a folder.
void add_gap_run_cases(CLI::App& gap);

/// Adds `airside gap test-cases`: the proposed tests, done on the hidden rooms of blind cases.
void add_gap_test_cases(CLI::App& gap);

/// Adds `airside gap bills`: what monthly bills alone tell.
void add_gap_bills(CLI::App& gap);

/// Adds `airside gap watch`: a verdict every night.
void add_gap_watch(CLI::App& gap);

/// Adds `airside gap run`, and the same without a subcommand. Call it last: options of the whole workflow before
/// another subcommand are refused, since they would be lost without a word.
void add_gap_run(CLI::App& gap);

/// --buildings: as gap::GapRequest::buildings.
void add_gap_buildings(CLI::App& command, std::optional<int>& buildings);

/// --effects, --jobs, --json.
struct GapOptions {
  std::string effects_dir;
  int jobs = 1;
  bool json = false;

  GapOptions();
  void add_effects(CLI::App& command);
  void add_jobs(CLI::App& command);
  void add_json(CLI::App& command);
  /// Errors: hal::InputError of a file that is wrong.
  std::vector<sim::Effect> effects() const;
  std::filesystem::path effects_folder() const;
};

/// A place to write to, before an hour of simulations ends there.
/// Errors: hal::InputError.
void require_writable(const std::string& option, const std::filesystem::path& path, bool folder);

}  // namespace airside::tools
