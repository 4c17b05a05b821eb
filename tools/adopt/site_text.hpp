#pragma once
// The files of an adopted site, as text.

#include <string>

#include "tools/adopt/adoption.hpp"

namespace airside::tools {

/// site.toml.
std::string adopted_site_text(const Adoption& adoption);
/// points.csv: the points that the model can show, for a simulated AHU.
std::string adopted_points_text(const Adoption& adoption);
/// adopt.md: what was found, chosen, changed and not found.
std::string adoption_page(const Adoption& adoption);

}  // namespace airside::tools
