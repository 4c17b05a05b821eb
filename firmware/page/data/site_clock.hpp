#pragma once
// What the site's clock shows: that of the box in local standard time, or the clock of the AHU.

#include <optional>
#include <string>

#include "firmware/page/data/state_folder.hpp"
#include "hal/site/site_file.hpp"

namespace airside::page {

/// The site's clock against UTC, min, the whole year; nothing where the AHU has the clock.
std::optional<int> utc_offset_min(const hal::SiteFile& site);

/// What the site's clock shows now. A plant's clock is known by the status alone, and taken to have gone on since that
/// was written; without a status it is the box's.
std::string site_time(const StatusReader& status, bool plant_clock);

}  // namespace airside::page
