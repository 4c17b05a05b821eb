#pragma once
// From what a site file says to what lib needs: settings, limits, rules for checking. Daemon and host tools use
// these same functions, so both control alike.

#include "airside/settings.hpp"
#include "airside/validation.hpp"
#include "hal/point_map.hpp"
#include "hal/site_file.hpp"

namespace airside::hal {

/// Compiled-in topologies and overridable settings, for read_site_file.
SiteRules site_rules();

/// The preset of the site file with its targets, ranges and overrides.
/// Errors: InputError if the settings contradict one another.
ControllerSettings controller_settings(const SiteFile& site);

/// Validator limits of every signal from the point map.
/// Errors: InputError where a signal is missing.
template <Topology T>
LimitsTable<T> limits_table(const PointMap& map) {
  LimitsTable<T> table = default_limits<T>();
  const auto limits = signal_limits<T>(map);
  for (std::size_t i = 0; i < table.size(); ++i) {
    table[i].min = limits[i].min;
    table[i].max = limits[i].max;
    table[i].max_rate_per_min = limits[i].max_rate_per_min;
    table[i].stale_s = limits[i].stale_s;
  }
  return table;
}

}  // namespace airside::hal
