#include "tools/report/zone_band.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/log/side_places.hpp"
#include "tools/report/charts/report_text.hpp"
#include "tools/run/metrics.hpp"

namespace airside::tools {

namespace {

constexpr double hours_a_row = row_s / 3600.0;

/// People in and air on, as far as the row says.
bool counts_here(const hal::TopologyCounts& counts, const hal::LogRow& row) {
  const auto is_off = [&](hal::SideSignal signal) { return hal::side_of(counts, row, signal) == 0; };
  return !is_off(hal::SideSignal::occupied) && !is_off(hal::SideSignal::ahu_on);
}

double mean_of(const std::vector<double>& values) {
  double sum = 0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

}  // namespace

double ZoneBand::above_degch_per_day() const {
  double sum = 0;
  for (const ZoneFigures& zone : zones) sum += zone.above_degch_per_day;
  return sum;
}

double ZoneBand::below_degch_per_day() const {
  double sum = 0;
  for (const ZoneFigures& zone : zones) sum += zone.below_degch_per_day;
  return sum;
}

double ZoneBand::saturated_h_per_day() const {
  double sum = 0;
  for (const ZoneFigures& zone : zones) sum += zone.saturated_h_per_day;
  return sum;
}

const ZoneFigures& ZoneBand::worst() const {
  return *std::ranges::max_element(zones, {}, &ZoneFigures::above_degch_per_day);
}

std::vector<std::string> room_names(const Site& site) {
  const auto rooms = static_cast<std::size_t>(site.counts.vavs);
  const auto& twin = site.file.twin;
  if (twin && twin->names && twin->names->zones.size() == rooms) return twin->names->zones;
  std::vector<std::string> names;
  for (std::size_t i = 1; i <= rooms; ++i) names.push_back(fmt::format("room {}", i));
  return names;
}

ZoneBand zone_band(const Site& site, const std::vector<hal::LogRow>& rows) {
  ZoneBand band;
  const auto setpoints = hal::side_places(site.counts, hal::SideSignal::zone_setpoint);
  const auto heating = hal::side_places(site.counts, hal::SideSignal::zone_heating_setpoint);
  const auto dampers = hal::side_places(site.counts, hal::SideSignal::damper);
  if (setpoints.empty() || rows.empty()) return band;
  for (std::string& name : room_names(site)) band.zones.push_back({std::move(name)});
  band.shows_heating = !heating.empty();
  band.dampers.resize(dampers.size());
  std::vector<double> damper_sum(band.zones.size()), counted(band.zones.size());
  for (const hal::LogRow& row : rows) {
    const bool here = counts_here(site.counts, row);
    std::vector<double> wanted;
    double most = std::nan("");
    for (std::size_t i = 0; i < band.zones.size(); ++i) {
      ZoneFigures& zone = band.zones[i];
      wanted.push_back(row.side[setpoints[i]]);
      const double above = row.value[i] - wanted.back();
      if (here && std::isfinite(above)) {
        zone.above_degch_per_day += too_warm_k(row.value[i], wanted.back()) * hours_a_row;
        zone.most_above_k = std::max(zone.most_above_k, above);
      }
      if (here && !heating.empty())
        zone.below_degch_per_day += too_cold_k(row.value[i], row.side[heating[i]]) * hours_a_row;
      if (dampers.empty()) continue;
      const double open = row.side[dampers[i]];
      band.dampers[i].push_back(open);
      if (std::isfinite(open)) most = std::fmax(most, open);
      if (!here || !std::isfinite(open)) continue;
      damper_sum[i] += open;
      ++counted[i];
      if (open > open_damper) zone.saturated_h_per_day += hours_a_row;
    }
    band.setpoint_degc.push_back(mean_of(wanted));
    if (!dampers.empty()) band.most_open.push_back(most);
  }
  const double days = static_cast<double>(rows.size()) * hours_a_row / 24;
  for (std::size_t i = 0; i < band.zones.size(); ++i) {
    band.zones[i].above_degch_per_day /= days;
    band.zones[i].below_degch_per_day /= days;
    band.zones[i].saturated_h_per_day /= days;
    band.zones[i].mean_damper = damper_sum[i] / counted[i];  // 0 / 0: nothing was seen
  }
  return band;
}

std::string band_headline(const ZoneBand& band, const std::string& days) {
  const std::size_t n = band.zones.size();
  std::string text =
      fmt::format("Over {} the {} {} more than 0.5 K above {} for {} K h a day while people were in", days,
                  n == 1 ? "zone" : fmt::format("{} zones", n), n == 1 ? "was" : "were",
                  n == 1 ? "its setpoint" : "their setpoints", number_text(band.above_degch_per_day(), 2));
  if (n > 1 && band.worst().above_degch_per_day > 0)
    text += fmt::format(", most in {} ({})", band.worst().name, number_text(band.worst().above_degch_per_day, 2));
  if (band.shows_heating)
    text +=
        fmt::format(", and as much below {} for {} K h", n == 1 ? "its heating setpoint" : "their heating setpoints",
                    number_text(band.below_degch_per_day(), 2));
  return text + fmt::format("; boxes stood fully open for {} h a day.", number_text(band.saturated_h_per_day(), 1));
}

ReportTable zones_table(const ZoneBand& band) {
  ReportTable table;
  table.title = "Each zone";
  table.row_header = "zone";
  table.note =
      "While people are in and the fan runs. Above setpoint: degree-hours above the zone's own setpoint + 0.5 K, and "
      "the most that it was above it. Below heating setpoint: below that - 0.5 K, where the log shows it. Open: hours "
      "with the damper above 0.95, where the box has no more to give.";
  table.columns = {{"above setpoint", "K h a day", 2, false},
                   {"most above", "K", 2, false},
                   {"below heating setpoint", "K h a day", 2, false},
                   {"open", "h a day", 1, false},
                   {"mean damper", "0 to 1", 2, false}};
  for (const ZoneFigures& zone : band.zones) {
    TableRow row;
    row.name = zone.name;
    const double below = band.shows_heating ? zone.below_degch_per_day : std::nan("");
    for (const double v :
         {zone.above_degch_per_day, zone.most_above_k, below, zone.saturated_h_per_day, zone.mean_damper}) {
      TableCell cell;
      if (std::isfinite(v)) cell.value = v;
      row.cells.push_back(cell);
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

ReportTable turned(const ReportTable& table, const std::string& row_header) {
  ReportTable out = table;
  out.row_header = row_header;
  out.columns.clear();
  out.rows.clear();
  for (const TableRow& row : table.rows) {
    out.columns.push_back({row.name, table.columns[0].unit, table.columns[0].decimals, false});
  }
  for (std::size_t i = 0; i < table.columns.size(); ++i) {
    TableRow turned_row;
    turned_row.name = table.columns[i].name;
    for (const TableRow& row : table.rows) turned_row.cells.push_back(row.cells[i]);
    out.rows.push_back(std::move(turned_row));
  }
  return out;
}

}  // namespace airside::tools
