#pragma once
// What does not change while the page runs, and what the weights that are given out say of themselves.

#include <nlohmann/json.hpp>
#include <string>

#include "hal/site/site_file.hpp"

namespace airside::page {

/// Name, topology, objective and band, target, working hours, limits of the setpoint, schedule, control cycle,
/// the clock against UTC.
nlohmann::json site_facts(const hal::SiteFile& site);

/// {bytes, created, provenance, residual} of weights.blob in the state folder; null where there is none that is whole.
nlohmann::json given_out_facts(const std::string& state_dir);

}  // namespace airside::page
