#pragma once
// Charts as SVG text: as files of their own for a document, and for the bars inside the page.

#include <string>

#include "tools/report/charts/report_input.hpp"

namespace airside::tools {

/// Whether the picture carries its own colours or takes those of the page around it.
enum class SvgUse { own_file, in_page };

/// Shape: 960 x 400 user units.
std::string line_chart_svg(const LineChart& chart, SvgUse use = SvgUse::own_file);

/// Shape: 960 x 380 user units. Every bar has a tooltip.
std::string bar_chart_svg(const BarChart& chart, SvgUse use = SvgUse::own_file);

}  // namespace airside::tools
