#pragma once
// Charts that only the report of the gap workflow has: heat maps of errors, and gains against their limit. They stand
// in the page and take its colours.

#include <Eigen/Core>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace airside::tools {

struct HeatRow {
  std::string name;
  std::string unit;  ///< rows of one unit share a scale
};

/// Shape: values: rows x columns; NaN: nothing known.
struct HeatMap {
  std::string title;
  std::vector<HeatRow> rows;
  std::vector<std::string> columns;
  std::string column_unit;  ///< after a column's name in a tooltip, such as " h"
  Eigen::MatrixXd values;
  std::map<std::string, double> full_colour;  ///< by unit: values of this size and larger
  std::optional<std::size_t> marked_from;     ///< columns from here on are marked
  std::string mark;                           ///< what that means
};

/// Orange above zero, blue below, the stronger the larger. Every cell has a tooltip.
/// Errors: std::out_of_range for a unit without a scale.
std::string heat_map_svg(const HeatMap& map);

struct RankBar {
  std::string name;
  double value = 0;
  double limit = 0;    ///< marked across the bar
  bool found = false;  ///< one of those that the report is about
};

/// Bars from the left, one below the other; `limit_name` says what the marks are.
std::string rank_svg(const std::vector<RankBar>& bars, const std::string& limit_name);

}  // namespace airside::tools
