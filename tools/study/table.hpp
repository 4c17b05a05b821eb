#pragma once
// The table of a study: which methods it has, its figures over rooms and seeds, and how it is printed.

#include <map>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

namespace airside::tools {

/// One room and one seed: figures of every method (json_of(Metrics)), by name.
using Outcome = std::map<std::string, nlohmann::json>;

/// Peers and floors of a table where the user names none.
std::vector<std::string> study_methods(bool energyplus);

/// On how many days one method was worse than another, day by day of the same room and seed.
struct WorseDays {
  int days = 0;
  int worse = 0;          ///< days on which DAE was more than the margin higher
  double worst_degc = 0;  ///< the largest difference, the peer's DAE subtracted; negative: better on every day
};
/// Nothing where no outcome holds both methods.
std::optional<WorseDays> worse_days(const std::vector<Outcome>& outcomes, const std::string& method,
                                    const std::string& peer, double margin_degc);

/// Mean, sd and count of every figure of `name`; ratios to `floor` are taken room by room, then averaged: a difficult
/// room must not outvote an easy one.
nlohmann::json study_figures(const std::vector<Outcome>& outcomes, const std::string& name, const std::string& floor);

/// The table as Markdown, one line a method of `order`; `methods` holds study_figures() by name.
std::string study_markdown(const nlohmann::json& methods, const std::vector<std::string>& order,
                           const std::string& floor);

/// Lines of cells as a Markdown table, columns padded to one width; the first line is the head.
std::string markdown_of(const std::vector<std::vector<std::string>>& lines);

}  // namespace airside::tools
