#include "firmware/page/data/site_clock.hpp"

#include <cmath>
#include <ctime>

#include "hal/modbus/plant_clock.hpp"
#include "hal/text/civil_text.hpp"

namespace airside::page {

std::optional<int> utc_offset_min(const hal::SiteFile& site) {
  if (site.clock == hal::ClockSource::plant) return {};
  const std::int64_t site_s = hal::SystemClock().now().seconds;
  return static_cast<int>(std::lround(static_cast<double>(site_s - std::time(nullptr)) / 60));
}

std::string site_time(const StatusReader& status, bool plant_clock) {
  const auto written = plant_clock ? hal::parse_civil_text(text_in(status.object(), "time")) : std::nullopt;
  if (!written) return hal::civil_text(hal::SystemClock().now());
  return hal::civil_text({written->seconds + std::llround(std::fmax(0.0, status.age_s()))});
}

}  // namespace airside::page
