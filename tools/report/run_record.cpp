#include "tools/report/run_record.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "hal/text/input_error.hpp"
#include "tools/report/run_stretches.hpp"

namespace airside::tools {

namespace {

using Column = double hal::ControllerColumns::*;

/// Where the kinds of signal begin in LogRow::value, as in Layout<T>.
struct Places {
  explicit Places(const hal::TopologyCounts& c)
      : rooms(static_cast<std::size_t>(c.vavs)),
        power(static_cast<std::size_t>(2 * c.vavs + 2 * c.fcus)),
        powers(static_cast<std::size_t>(c.powers)),
        outdoor(power + powers + 1),
        boxes(static_cast<std::size_t>(c.vavs + c.fcus)) {}
  std::size_t rooms, power, powers, outdoor, boxes;
};

double room_mean(const hal::LogRow& row, std::size_t rooms) {
  return std::accumulate(row.value.begin(), row.value.begin() + static_cast<std::ptrdiff_t>(rooms), 0.0) /
         static_cast<double>(rooms);
}

std::vector<double> column(const std::vector<hal::LogRow>& rows, std::size_t place) {
  std::vector<double> values;
  values.reserve(rows.size());
  for (const hal::LogRow& row : rows) values.push_back(row.value[place]);
  return values;
}

/// A value a cycle; empty if the run has none at all.
std::vector<double> column(const std::vector<const hal::LogRow*>& cycles, Column member) {
  std::vector<double> values;
  values.reserve(cycles.size());
  for (const hal::LogRow* row : cycles) values.push_back(row->controller.*member);
  if (std::none_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); })) values.clear();
  return values;
}

/// As [site], else the twin's section of the site file names them, else by number.
std::vector<std::string> meter_names(const Site& site) {
  const auto powers = static_cast<std::size_t>(site.counts.powers);
  const auto& twin = site.file.twin;
  std::vector<std::string> names = site.file.meters;
  if (names.empty() && twin && twin->control == hal::TwinControl::own && twin->names) names = twin->names->powers;
  names.resize(powers);
  for (std::size_t i = 0; i < powers; ++i) {
    if (names[i].empty()) names[i] = powers == 1 ? "power" : "meter " + std::to_string(i + 1);
  }
  return names;
}

/// Whether a meter that EnergyPlus names by use and fuel, such as Heating:NaturalGas, is of electricity.
bool is_electric(const std::string& meter) {
  return meter.find(':') == std::string::npos || meter.find("Electricity") != std::string::npos;
}

bool whole_cycle(const hal::LogRow& row, std::size_t rooms) {
  return std::isfinite(row.setpoint_degc) && std::isfinite(room_mean(row, rooms));
}

}  // namespace

RunRecord make_run_record(const Site& site, const ControlRun& run) {
  RunRecord r;
  const Places at(site.counts);
  r.site = site.file.name;
  r.metrics = metrics_settings(site);
  if (site.settings.objective == Objective::mean) {
    r.more_facts.push_back({"held at the target", text_of(site.settings.held.rule)});
  }
  r.room_names = room_names(site);
  const std::vector<std::string> meters = meter_names(site);

  const ControlCycle cycle = control_cycle(site.settings);
  std::vector<const hal::LogRow*> cycles;
  for (const hal::LogRow& row : run.rows) {
    r.row_time.push_back(row.time);
    r.room_mean_degc.push_back(room_mean(row, at.rooms));
    if (cycle.starts(row.time)) cycles.push_back(&row);
  }
  for (std::size_t i = 0; i < at.rooms; ++i) r.room_temp_degc.push_back({r.room_names[i], column(run.rows, i)});
  r.outdoor_degc = column(run.rows, at.outdoor);
  for (std::size_t i = 0; i < at.powers; ++i) {
    if (site.counts.stand_in(static_cast<int>(at.power + i))) continue;
    r.power_kw.push_back({meters[i], column(run.rows, at.power + i)});
    r.all_electric = r.all_electric && is_electric(meters[i]);
  }
  bool any_closed = false;
  for (std::size_t i = 0; i < at.rooms; ++i) {
    if (site.counts.stand_in(static_cast<int>(at.boxes + i))) continue;
    r.boxes_on.push_back({r.room_names[i], column(run.rows, at.boxes + i)});
    any_closed = any_closed || std::ranges::any_of(r.boxes_on.back().values, [](double on) { return on < 0.5; });
  }
  if (!any_closed) r.boxes_on.clear();
  for (const hal::LogRow& row : run.rows) {
    r.mode.push_back(row.controller.mode);
    r.reason.push_back(row.controller.reason);
    r.fault.push_back(row.controller.fault);
  }
  r.signal = signals_at_fault(site.counts, run.rows);
  if (std::ranges::all_of(r.mode, [](const std::string& m) { return m.empty(); })) r.mode.clear();
  if (site.settings.objective == Objective::band) {
    ZoneBand band = zone_band(site, run.rows);
    if (!band.zones.empty()) r.band = std::move(band);
  }

  for (const hal::LogRow* row : cycles) {
    r.cycle_time.push_back(row->time);
    r.setpoint_degc.push_back(row->setpoint_degc);
  }
  using C = hal::ControllerColumns;
  r.expert_setpoint_degc = column(cycles, &C::a_expert_degc);
  r.network_setpoint_degc = column(cycles, &C::a_network_degc);
  r.head_setpoint_degc = column(cycles, &C::a_head_degc);
  if (!r.band) r.confidence = column(cycles, &C::confidence);  // the objective "band" has none
  constexpr std::pair<const char*, Column> losses[] = {{"short term", &C::loss_strb},
                                                       {"deviation", &C::loss_tdb},
                                                       {"gradient constraint", &C::loss_gc},
                                                       {"residual constraint", &C::loss_rc},
                                                       {"reconstruction", &C::loss_rec}};
  for (const auto& [name, member] : losses) {
    std::vector<double> values = column(cycles, member);
    if (!values.empty()) r.losses.push_back({name, std::move(values)});
  }
  return r;
}

ControlRun run_of_log(const Site& site, const hal::Log& log, const std::string& place) {
  ControlRun run;
  const Places at(site.counts);
  run.rows = log.rows;
  bool metered = true;  // a number that stands in for a meter is no energy
  for (std::size_t i = at.power; i < at.power + at.powers && i < log.stood_in.size(); ++i) {
    metered = metered && !log.stood_in[i];
  }
  for (const hal::LogRow& row : log.rows) {
    const auto value = row.value.begin();
    const auto power = value + static_cast<std::ptrdiff_t>(at.power);
    const double kw = std::accumulate(power, power + static_cast<std::ptrdiff_t>(at.powers), 0.0);
    if (std::isfinite(kw) && metered) run.energy.push_back({row.time, kw});
    if (!control_cycle(site.settings).starts(row.time) || !whole_cycle(row, at.rooms)) continue;
    run.cycles.push_back({row.time,
                          room_mean(row, at.rooms),
                          {value, value + static_cast<std::ptrdiff_t>(at.rooms)},
                          row.setpoint_degc});
  }
  if (run.cycles.empty()) {
    throw hal::InputError(place, "no whole row at the start of a control cycle",
                          fmt::format("rows every {} min from 00:00 on with all room temperatures and the setpoint",
                                      site.settings.cycle_min),
                          "export the log with rows every 6 min counted from midnight");
  }
  return run;
}

}  // namespace airside::tools
