#pragma once
// How a series looks, on the page and in pictures: colour and pattern, both of palette.css.

#include <string>
#include <vector>

#include "tools/report/charts/report_input.hpp"

namespace airside::tools {

/// Names of palette.css without their dashes. No two lines of a chart have one pattern, as long as there are no more
/// than patterns: eleven, beside one that is `main` and the reference. So the first room has one look in every chart.
struct SeriesLook {
  std::string name;
  std::string colour;  ///< "main", "ref" or "c0".."c7" in order of appearance
  std::string dash;    ///< "dref" or "d0".."d11"; d0 is a whole line: `main`, or the only one of its chart
  bool muted = false;
};

std::vector<SeriesLook> looks_of(const LineChart& chart);
std::vector<SeriesLook> looks_of(const BarChart& chart);

/// The kinds of a chart's stretches, each once, in order of appearance.
std::vector<ChartStretch> kinds_of(const std::vector<ChartStretch>& stretches);

/// Style of a picture that is a file of its own: the light colours and the patterns of palette.css, on white paper.
extern const char* const own_style;

}  // namespace airside::tools
