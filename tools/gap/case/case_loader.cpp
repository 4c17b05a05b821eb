#include "tools/gap/case/case_loader.hpp"

#include <fmt/format.h>

#include <limits>

#include "hal/text/civil_text.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/rc/rc_room_file.hpp"
#include "sim/weather/epw.hpp"
#include "tools/gap/map/mapped_log.hpp"
#include "tools/gap/model/energyplus_engine.hpp"
#include "tools/gap/model/log_window.hpp"
#include "tools/run/site.hpp"

namespace airside::tools::gap {

namespace {

namespace fs = std::filesystem;

/// Midnight at or after t.
CivilTime next_midnight(CivilTime t) { return {(t.seconds + 86399) / 86400 * 86400}; }

/// "rc" has the shape of the logs; every other room has its own.
sim::RcRoom room_of(const CaseDescription& c, const hal::TopologyCounts& counts) {
  return c.model == "rc" ? sim::make_room(counts.vavs, counts.fcus, counts.powers) : sim::load_room(c.model);
}

CaseLogs divided_log(const CaseDescription& c, CleanLog all) {
  CaseLogs logs{all, std::move(all)};
  const auto from = logs.measured.rows.empty() ? CivilTime{} : next_midnight(logs.measured.rows.front().time);
  const CivilTime divide{from.seconds + c.reference_days * seconds_per_day};
  std::erase_if(logs.reference.rows, [divide](const hal::LogRow& row) { return !(row.time < divide); });
  std::erase_if(logs.measured.rows, [divide](const hal::LogRow& row) { return row.time < divide; });
  logs.reference.remarks.clear();  // one log, one table
  return logs;
}

}  // namespace

hal::TopologyCounts counts_of(const CaseDescription& c) {
  if (!c.map.empty()) return counts_of(read_mapping(c.map));
  return c.site.empty() ? built_in_site(c.topology).counts : load_site(c.site).counts;
}

CleanLog read_log_of(const CaseDescription& c, const std::string& path, CleanUpContext context) {
  context.place = path;
  // Meters of a model that somebody else wrote may be of a whole building.
  if (!c.site.empty() || !c.map.empty()) context.largest_zone_kw = std::numeric_limits<double>::infinity();
  if (!c.site.empty()) context.cycle = control_cycle(load_site(c.site).settings);
  CleanLog log = c.map.empty() ? read_dirty_log(path, context) : read_mapped_log(path, read_mapping(c.map), context);
  log.place = path;
  return log;
}

Window window_of_log(const CaseDescription& c, std::span<const hal::LogRow> rows, const sim::Channels& channels,
                     std::shared_ptr<const sim::Weather> station, const std::string& place,
                     const hal::TopologyCounts& counts) {
  const std::size_t commands = c.map.empty() ? 0 : read_mapping(c.map).further_commands().size();
  return window_of(rows, channels, std::move(station), place, counts, commands);
}

CaseLogs read_case_logs(const CaseDescription& c, const CleanUpContext& context) {
  CaseLogs logs;
  try {
    logs.measured = read_log_of(c, c.measured_log, context);
    if (c.reference_log.empty()) {
      logs.measured.require_usable();
      if (!c.has_reference()) return logs;
      return divided_log(c, std::move(logs.measured));
    }
    logs.reference = read_log_of(c, c.reference_log, context);
    same_room(logs.reference, logs.measured, context);
    logs.reference.require_usable();
    logs.measured.require_usable();
  } catch (const hal::InputError& reason) {
    throw RefusedLog(reason, std::move(logs));
  }
  return logs;
}

void require_apart(const CaseLogs& logs) {
  const auto& a = logs.reference.rows;
  const auto& b = logs.measured.rows;
  if (a.empty() || b.empty() || a.back().time < b.front().time || b.back().time < a.front().time) return;
  throw hal::InputError(logs.measured.place,
                        fmt::format("rows from {} on, within the reference period, which lasts to {}",
                                    hal::civil_text(b.front().time), hal::civil_text(a.back().time)),
                        "a measured period before or after the reference period",
                        "give a log of other days, or one log and --reference-days");
}

LoadedCase load_case(const CaseDescription& c, const std::string& name, const fs::path& cache) {
  LoadedCase loaded;
  loaded.name = name;
  const hal::TopologyCounts counts = loaded.counts = counts_of(c);
  if (c.engine == "rc") {
    loaded.engine = std::make_unique<RcEngine>(room_of(c, counts));
  } else {
    loaded.engine =
        std::make_unique<EnergyPlusEngine>(sim::twin_of(energyplus_options_of(c)), c.model, cache, c.duties);
  }
  const auto weather = sim::read_epw(c.weather, {.whole_year = false, .from = {}, .to = {}});
  const sim::Channels channels = loaded.engine->channels();
  if (channels.rooms != counts.vavs || channels.fcus != counts.fcus || channels.powers != counts.powers) {
    throw hal::InputError(name + ": model " + c.model,
                          fmt::format("{} VAVs, {} FCUs, {} powers", channels.rooms, channels.fcus, channels.powers),
                          "the counts of topology " + c.topology, "name the topology of the log and its model");
  }
  CleanUpContext context;
  context.counts = counts;
  context.station = weather;
  loaded.logs = read_case_logs(c, context);
  const auto window = [&](const CleanLog& log) {
    return window_of_log(c, log.rows, channels, weather, log.place, counts);
  };
  try {
    if (c.has_reference()) loaded.data.reference = window(loaded.logs.reference);
    loaded.data.test = window(loaded.logs.measured);
  } catch (const hal::InputError& reason) {
    throw RefusedLog(reason, loaded.logs);
  }
  return loaded;
}

}  // namespace airside::tools::gap
