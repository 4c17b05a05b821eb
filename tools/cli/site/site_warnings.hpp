#pragma once
// What a site file and a point map may say, and seldom mean.

#include <string>
#include <vector>

#include "hal/points/point_map.hpp"
#include "hal/site/site_file.hpp"

namespace airside::tools {

/// Register numbers of a vendor's table (40001) where protocol addresses count from 0, no heartbeat, a status that is
/// read as a fraction.
std::vector<std::string> warnings_of(const hal::PointMap& points);

/// A schedule beyond the setpoint's own range, a password in plain text.
std::vector<std::string> warnings_of(const hal::SiteFile& site);

}  // namespace airside::tools
