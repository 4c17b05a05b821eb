#pragma once
// From what a site file says to what lib needs: settings, limits, rules for checking. Daemon and host tools use
// these same functions, so both control alike.

#include "airside/settings.hpp"
#include "hal/modbus/link.hpp"
#include "hal/points/point_map.hpp"
#include "hal/site/site_file.hpp"

namespace airside::hal {

/// Compiled-in topologies and overridable settings, for read_site_file.
SiteRules site_rules();

/// The preset of the site file with its targets, ranges and overrides.
/// Errors: InputError if the settings contradict one another.
ControllerSettings controller_settings(const SiteFile& site);
/// The same, and which setpoints the register of `points` can hold.
ControllerSettings controller_settings(const SiteFile& site, const PointMap& points);

/// Errors: InputError where settings and point map contradict one another: a budget of writes and a setpoint that is
/// written again and again; a register whose steps are wider than the setpoint may change, or that has no two values
/// within its limits; setpoints that are outside the limits of their own row; a simulated AHU's clock without its
/// points.
void refuse_contradiction(const SiteFile& site, const PointMap& points);
/// What is allowed and had better be known, as a sentence; empty where there is nothing of the kind.
std::string warning_of(const PointMap& points);

/// How to reach the AHU of section [modbus]; after a failed exchange the link waits `backoff_first_s`, at most
/// `backoff_max_s` (never less than the first wait).
LinkSettings link_settings(const ModbusSection& modbus, double backoff_first_s,
                           double backoff_max_s = LinkSettings{}.backoff_max_s);

}  // namespace airside::hal
