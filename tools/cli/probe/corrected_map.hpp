#pragma once
// A point map with some cells changed; comments, order of rows and all other cells stay.

#include <string>
#include <utility>
#include <vector>

#include "hal/points/point_map.hpp"

namespace airside::tools {

/// Cells of one row: its line in the file, and column with new text.
struct CorrectedRow {
  int line = 0;
  std::vector<std::pair<std::string, std::string>> cells;
};

/// The text of a map with those cells changed; a column that it lacks is added. `text` must be a map that
/// hal::PointMap::parse() takes.
std::string corrected_map(const std::string& text, const std::string& file, const std::vector<CorrectedRow>& rows);

/// Checks the text whole and writes it. Errors: hal::InputError; for a file that is there, unless `may_overwrite`.
void write_map(const std::string& path, const std::string& text, bool may_overwrite);

}  // namespace airside::tools
