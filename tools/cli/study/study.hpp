#pragma once
// The subcommands of `airside study`, and what all of them ask for.

#include <CLI/CLI.hpp>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/run/plant_choice.hpp"

namespace airside::tools {

/// A method of studies: `product` from the same weights without their residual network.
constexpr const char* head_alone = "ours-head-alone";

/// Many runs on several rooms and seeds.
struct StudyOptions {
  std::string kind = "auto";
  int seeds = 1, expert_days = 5, days = 7, jobs = 2;
  bool json = false;

  /// `days_text`: what the days are for.
  void add_to(CLI::App& c, const char* days_text);
  PlantChoice choice(const std::string& room, std::uint64_t seed, const std::string& start) const;
};

/// Writes what a study found into the file `out`, where one is named, and prints it where `as_json`. Returns whether it
/// was printed: nothing else goes to standard output then.  Errors: hal::InputError for a file that cannot be written.
bool give_json(const nlohmann::json& found, const std::string& out, bool as_json);

void add_study_signals(CLI::App& study);
void add_study_boxes(CLI::App& study);
void add_study_adopted(CLI::App& study);
void add_study_nights(CLI::App& study);
void add_study_tune(CLI::App& study);
void add_study_residuals(CLI::App& study);
void add_study_method(CLI::App& study);
void add_study_all(CLI::App& study);
void add_study_scenarios(CLI::App& study);

}  // namespace airside::tools
