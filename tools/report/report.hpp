#pragma once
// Turns a ReportInput into one HTML file that opens anywhere without a network, and each chart into an SVG file.

#include <filesystem>
#include <string>
#include <vector>

#include "tools/report/charts/report_input.hpp"

namespace airside::tools {

struct ReportOptions {
  std::size_t points_per_chart = 4000;  ///< longer series keep the extremes of each interval
  bool svg_files = true;                ///< one NN-title.svg a chart, beside the page
};

/// The page as text: style, script and data inside, nothing loaded from elsewhere.
/// Errors: hal::InputError when a series, band or row does not fit its chart or table.
std::string report_html(const ReportInput& input, const ReportOptions& options = {});

/// Writes the page to `path` (its folder is made) and the SVG files beside it. Returns every file written, the page
/// first. All appear together, or none.
/// Errors: hal::InputError as report_html, and when a file cannot be written.
std::vector<std::filesystem::path> write_report(const std::filesystem::path& path, const ReportInput& input,
                                                const ReportOptions& options = {});

}  // namespace airside::tools
