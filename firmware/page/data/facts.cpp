#include "firmware/page/data/facts.hpp"

#include <algorithm>
#include <array>
#include <span>

#include "airside/controller/blob.hpp"
#include "airside/held_rooms.hpp"
#include "firmware/page/data/site_clock.hpp"
#include "firmware/page/data/state_folder.hpp"
#include "hal/site/site_settings.hpp"
#include "hal/system/version.hpp"
#include "hal/text/civil_text.hpp"

namespace airside::page {

using nlohmann::json;

json site_facts(const hal::SiteFile& site) {
  const std::optional<int> offset_min = utc_offset_min(site);
  return {{"site", site.name},
          {"topology", site.topology},
          {"version", hal::version()},
          {"objective", site.objective == Objective::band ? "band" : "mean"},
          {"band_k", site.objective == Objective::band ? json(hal::controller_settings(site).demand.band_k) : json()},
          {"hold", text_of(site.held.rule)},
          {"target_degc", site.room_temp_degc},
          {"work_start_s", site.work_start_s},
          {"work_end_s", site.work_end_s},
          {"weekday_only", site.weekday_only},
          {"setpoint_min_degc", site.setpoint_min_degc},
          {"setpoint_max_degc", site.setpoint_max_degc},
          {"schedule_work_degc", site.expert_work_degc},
          {"schedule_off_degc", site.expert_off_degc},
          {"cycle_min", site.cycle_min},
          {"utc_offset_min", offset_min ? json(*offset_min) : json()},
          {"heartbeat_s", site.modbus ? json(site.modbus->heartbeat_s) : json()}};
}

json given_out_facts(const std::string& state_dir) {
  constexpr std::uint64_t max_weights_bytes = 4u << 20;
  std::uint64_t size = 0;
  const hal::StorageFile file = open_in(state_dir, "weights.blob", max_weights_bytes, size);
  if (!file.is_open()) return nullptr;
  BlobHeader header{};
  const auto got = file.read_at(std::as_writable_bytes(std::span(&header, 1)), 0, "read weights");
  if (!got || *got != sizeof header || header.magic != BlobHeader{}.magic) return nullptr;
  const std::uint64_t end = sizeof header + std::uint64_t{header.payload_bytes};
  if (header.payload_bytes < blob_provenance_bytes || end > size) return nullptr;
  std::array<char, blob_provenance_bytes> text{};
  const auto read = file.read_at(std::as_writable_bytes(std::span(text)), end - blob_provenance_bytes, "read weights");
  if (!read || *read != text.size()) return nullptr;
  const std::string provenance(text.begin(), std::ranges::find(text, '\0'));
  return {{"bytes", size},
          {"created", hal::civil_text({header.created_s})},
          {"residual", header.residual_parameters > 0},
          {"provenance", provenance}};
}

}  // namespace airside::page
