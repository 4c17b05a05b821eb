#pragma once
// Whether a setpoint is worth controlling on an adopted loop, from what the engine's runs of it took and held.

#include <cstdint>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "tools/adopt/adoption.hpp"

namespace airside::tools {

enum class Verdict : std::uint8_t {
  control,      ///< worth controlling
  schedule,     ///< a setpoint by schedule does as well
  own_control,  ///< the unit is better under its own control by load
  undecided,    ///< the fan ran in none of the days' working hours, or nothing meters what a switched unit takes
};
/// "control", "schedule", "own-control", "undecided".
const char* text_of(Verdict verdict);

struct Advice {
  Verdict verdict = Verdict::undecided;
  std::string objective;  ///< "mean" or "band" where it is worth controlling
  std::string headline;   ///< one clause
  std::string why;        ///< sentences with the figures
};

/// The rules, in this order:
///   own_control  a unit that was switched from load takes at least 10 % less under load, over all seasons, than held
///                at each season's best constant, and leaves its band by no more than the allowance
///   schedule     the supply does not follow; or the objective is "mean" and the boxes' own thermostats modulate, or
///                g (max - min) < 0.2 K in every season, g: K of the rooms a K of setpoint; or it is "band" and one
///                end of the range is the best constant in every season
///   control      otherwise
/// 10 % is about as much as `band` saved beside the best constant anywhere (docs/results.md); 0.2 K is the tolerance of
/// a room sensor.
Advice advice_on(const Adoption& adoption);

/// The page's section: headline, reason and a table of the figures.
std::string advice_section(const Adoption& adoption);
/// For the terminal: the headline, then the reason.
std::string advice_lines(const Adoption& adoption);
/// {"verdict", "objective", "headline", "why"}.
nlohmann::json json_of(const Advice& advice);
/// A season's response, figures and constants; null where nothing is known.
nlohmann::json json_of(const Comparison& season);

/// Headline and reason of an adopt.md; empty where the file is not there or has none.
std::string advice_of_page(const std::filesystem::path& page);

}  // namespace airside::tools
