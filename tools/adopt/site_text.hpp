#pragma once
// The files of an adopted site, as text.

#include <string>

#include "tools/adopt/adoption.hpp"

namespace airside::tools {

/// site.toml.
std::string adopted_site_text(const Adoption& adoption);
/// points.csv: the points that the model can show, for a simulated AHU.
std::string adopted_points_text(const Adoption& adoption);
/// map.toml: a first mapping for `airside gap --map`, with the columns of the controller's own log.
std::string adopted_map_text(const Adoption& adoption);
/// adopt.md: what was found, chosen, changed and not found.
std::string adoption_page(const Adoption& adoption);
/// The commands from the site to a report of a week of control, one a line. `folder` goes before file names.
std::string next_steps(const Adoption& adoption, const std::string& folder);

}  // namespace airside::tools
