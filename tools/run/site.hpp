#pragma once
// What a command works on: a checked site with its point map and controller settings.

#include <string>

#include "airside/settings.hpp"
#include "hal/log/log_csv.hpp"
#include "hal/points/point_map.hpp"
#include "hal/site/site_file.hpp"

namespace airside::tools {

struct Site {
  hal::SiteFile file;
  hal::PointMap points;
  ControllerSettings settings;
  hal::TopologyCounts counts;
};

/// Reads a site file and its point map.  Errors: hal::InputError.
Site load_site(const std::string& path);

/// The built-in site for runs that need no file: default points, the given preset.
/// Errors: hal::InputError if this build has no such topology.
Site built_in_site(const std::string& topology = "5vav-5fcu-2power",
                   hal::ControllerPreset preset = hal::ControllerPreset::product);

/// The built-in site without the sensors for which there is a stand-in.
Site with_stand_ins(Site built_in, const hal::StandIns& stand_ins);

/// The site with another preset, everything the file says kept.
Site with_preset(const Site& site, hal::ControllerPreset preset);

}  // namespace airside::tools
