#pragma once
// Fewer points for the same picture.

#include "tools/report/charts/report_input.hpp"

namespace airside::tools {

/// At most about `points` x values. Each interval of rows becomes two, which hold every series' least and greatest
/// value in their order of appearance, so that no peak is lost. A chart that is short enough is returned as it is.
LineChart downsample(const LineChart& chart, std::size_t points);

}  // namespace airside::tools
