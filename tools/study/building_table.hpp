#pragma once
// The table of one adopted building in one season: every method's figures, and ours beside the best of the others.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "airside/settings.hpp"
#include "tools/run/metrics.hpp"
#include "tools/study/building_run.hpp"

namespace airside::tools {

struct BuildingLine {
  std::string name;
  BuildingMethod method;
  std::vector<BuildingFigures> runs;  ///< one a period, the same periods in every line
};

struct BuildingTable {
  std::string site;   ///< path of its site file
  std::string start;  ///< first scored day
  std::vector<std::string> meters;
  Objective objective = Objective::mean;
  int zones = 1;
  std::string constant_of_other_days;  ///< name of a line; empty: nothing was tuned
  double gain_per_h = 0;               ///< of the integral; 0: nothing was tuned
  std::vector<BuildingLine> lines;     ///< ours is the last
};

/// What -o writes and --from reads, with both verdicts.
nlohmann::json json_of(const BuildingTable& table);
/// Errors: nlohmann::json::exception for anything else.
BuildingTable building_table_of(const nlohmann::json& j);

/// Whom ours is compared with.
enum class Rivals : std::uint8_t {
  simple,  ///< what needs neither learning nor knowledge of the scored days
  all,     ///< and MPC, and every constant
};

/// Ours less the best of the others, run by run.
struct BuildingVerdict {
  std::string rival;
  Spread value;           ///< band: energy, %; mean: DAE, °C
  Spread outside_degch;   ///< zone degree-hours a day
  bool allowed = true;    ///< ours keeps the rule of best_for() that the others keep
  double most_degch = 0;  ///< what that rule allows
};
/// Nothing where ours or the others are missing.
std::optional<BuildingVerdict> verdict_on(const BuildingTable& table, Rivals rivals);

/// The table as Markdown, a line a method, and the verdicts.
std::string markdown_of(const BuildingTable& table);
/// One line a table: ours, the best simple one, the best of all.
std::string summary_of(const std::vector<BuildingTable>& tables);

}  // namespace airside::tools
