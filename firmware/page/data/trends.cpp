#include "firmware/page/data/trends.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "airside/supervision/mode_table.hpp"
#include "hal/text/civil_text.hpp"

namespace airside::page {
namespace {

using nlohmann::json;

constexpr double row_h = row_s / 3600.0;
constexpr std::size_t max_spells = 300;

/// Two decimals are what a sensor has to say, and no more digits are sent.
json rounded(double value, double per_unit = 100) {
  if (!std::isfinite(value)) return nullptr;
  return std::round(value * per_unit) / per_unit;
}

struct Mean {
  double sum = 0;
  int n = 0;
  void add(double value) {
    if (!std::isfinite(value)) return;
    sum += value;
    ++n;
  }
  json value(double per_unit = 100) const { return n == 0 ? json() : rounded(sum / n, per_unit); }
};

/// Sums over rows, for a day or for all rows under one control.
struct Sums {
  double hours = 0, energy_kwh = 0, metered_h = 0, working_h = 0, degree_hours = 0;
  double warm_h = 0, too_warm_kh = 0, cold_h = 0, too_cold_kh = 0;  ///< hours that count, and zones' degree-hours
  std::array<double, 4> mode_h{};

  void add(const TrendRow& row, double target_degc) {
    hours += row_h;
    if (row.mode >= 0) mode_h[static_cast<std::uint8_t>(row.mode)] += row_h;
    if (std::isfinite(row.power_kw)) {
      energy_kwh += static_cast<double>(row.power_kw) * row_h;
      metered_h += row_h;
    }
    add_zones(row.too_warm_k, warm_h, too_warm_kh);
    add_zones(row.too_cold_k, cold_h, too_cold_kh);
    if (!row.working_hours || !std::isfinite(row.held_degc)) return;
    working_h += row_h;
    degree_hours += std::abs(static_cast<double>(row.held_degc) - target_degc) * row_h;
  }
  static void add_zones(float beyond_k, double& hours_counted, double& degree_hours_kh) {
    if (!std::isfinite(beyond_k)) return;
    hours_counted += row_h;
    degree_hours_kh += static_cast<double>(beyond_k) * row_h;
  }
  json as_json(bool of_band) const {
    const bool has_target = !of_band && working_h > 0;
    return {{"hours", rounded(hours, 10)},
            {"energy_kwh", metered_h > 0 ? rounded(energy_kwh, 10) : json()},
            {"mean_power_kw", metered_h > 0 ? rounded(energy_kwh / metered_h) : json()},
            {"working_h", rounded(working_h, 10)},
            {"degree_hours_kh", has_target ? rounded(degree_hours) : json()},
            {"mean_distance_k", has_target ? rounded(degree_hours / working_h, 1000) : json()},
            {"zones_too_warm_kh", of_band && warm_h > 0 ? rounded(too_warm_kh) : json()},
            {"zones_too_cold_kh", of_band && cold_h > 0 ? rounded(too_cold_kh) : json()},
            {"learn_h", rounded(mode_h[0], 10)},
            {"run_h", rounded(mode_h[1], 10)},
            {"expert_h", rounded(mode_h[2], 10)},
            {"release_h", rounded(mode_h[3], 10)}};
  }
};

std::string text_of_time(CivilTime t) { return hal::civil_text(t); }

json days_of(const TrendStore& store, std::uint64_t from, bool of_band) {
  json days = json::array();
  for (std::uint64_t i = from; i < store.count();) {
    const std::int64_t day = store.row(i).time.day();
    Sums sums;
    for (; i < store.count() && store.row(i).time.day() == day; ++i) sums.add(store.row(i), store.target_degc());
    json entry = sums.as_json(of_band);
    entry["date"] = text_of_time({day * seconds_per_day}).substr(0, hal::date_text_size);
    days.push_back(std::move(entry));
  }
  return days;
}

/// airside's own control, the schedule, released.
json by_control(const TrendStore& store, std::uint64_t from, bool of_band) {
  Sums airside, schedule, released;
  for (std::uint64_t i = from; i < store.count(); ++i) {
    const TrendRow& row = store.row(i);
    if (row.mode < 0) continue;
    Sums& sums = row.mode <= 1 ? airside : row.mode == 2 ? schedule : released;
    sums.add(row, store.target_degc());
  }
  return {{"airside", airside.as_json(of_band)},
          {"schedule", schedule.as_json(of_band)},
          {"released", released.as_json(of_band)}};
}

/// Stretches of one mode and reason; of more than are shown the newest.
json spells_of(const TrendStore& store, std::uint64_t from) {
  std::vector<json> spells;
  for (std::uint64_t i = from; i < store.count();) {
    const TrendRow& first = store.row(i);
    std::uint64_t last = i;
    for (++i; i < store.count(); ++i) {
      const TrendRow& row = store.row(i);
      if (row.mode != first.mode || row.reason != first.reason) break;
      if (row.time.seconds - store.row(last).time.seconds > row_s) break;
      last = i;
    }
    if (first.mode < 0) continue;
    spells.push_back({{"from", text_of_time(first.time)},
                      {"to", text_of_time({store.row(last).time.seconds + row_s})},
                      {"mode", text_of(static_cast<ControlMode>(first.mode))},
                      {"reason", text_of(static_cast<Reason>(first.reason))}});
  }
  if (spells.size() > max_spells) spells.erase(spells.begin(), spells.end() - max_spells);
  return spells;
}

/// The zones' own setpoints by the newest row; null where the site does not show them.
json zones_of(const TrendStore& store) {
  const ZoneSetpoints& zones = store.zone_setpoints();
  if (zones.cooling_degc.empty()) return nullptr;
  const auto list = [](const std::vector<float>& degc) {
    json values = json::array();
    for (const float v : degc) values.push_back(rounded(static_cast<double>(v)));
    return degc.empty() ? json() : values;
  };
  return {{"time", text_of_time(zones.time)},
          {"cooling_degc", list(zones.cooling_degc)},
          {"heating_degc", list(zones.heating_degc)}};
}

using Column = float TrendRow::*;
struct NamedColumn {
  const char* name;
  Column column;
  double per_unit;  ///< of rounding
};
constexpr auto columns = std::to_array<NamedColumn>({
    {"held_degc", &TrendRow::held_degc, 100},
    {"low_degc", &TrendRow::low_degc, 100},
    {"high_degc", &TrendRow::high_degc, 100},
    {"setpoint_degc", &TrendRow::setpoint_degc, 100},
    {"supply_degc", &TrendRow::supply_degc, 100},
    {"outdoor_degc", &TrendRow::outdoor_degc, 100},
    {"schedule_degc", &TrendRow::schedule_degc, 100},
    {"g36_degc", &TrendRow::g36_degc, 100},
    {"confidence", &TrendRow::confidence, 1000},
    {"power_kw", &TrendRow::power_kw, 1000},
});

/// Points at equal distances in time; one without a row is null everywhere.
void add_curves(const TrendStore& store, std::uint64_t from, std::int64_t step_s, std::size_t points, json& out) {
  const auto n = static_cast<std::size_t>(store.vavs());
  const std::int64_t begin_s = store.row(from).time.seconds / step_s * step_s;
  std::vector<std::array<Mean, columns.size()>> means(points);
  std::vector<Mean> rooms(points * n);
  std::vector<std::int8_t> modes(points, -1);
  for (std::uint64_t i = from; i < store.count(); ++i) {
    const TrendRow& row = store.row(i);
    const auto at = static_cast<std::size_t>((row.time.seconds - begin_s) / step_s);
    if (at >= points) break;
    for (std::size_t c = 0; c < columns.size(); ++c) means[at][c].add(static_cast<double>(row.*columns[c].column));
    for (std::size_t r = 0; r < n; ++r) rooms[at * n + r].add(static_cast<double>(store.rooms_degc(i)[r]));
    modes[at] = std::max(modes[at], row.mode);
  }
  json time = json::array(), mode = json::array();
  for (std::size_t p = 0; p < points; ++p) {
    time.push_back(begin_s + static_cast<std::int64_t>(p) * step_s);
    mode.push_back(modes[p] < 0 ? json() : json(modes[p]));
  }
  out["time_s"] = std::move(time);
  out["mode"] = std::move(mode);
  for (std::size_t c = 0; c < columns.size(); ++c) {
    json values = json::array();
    for (std::size_t p = 0; p < points; ++p) values.push_back(means[p][c].value(columns[c].per_unit));
    out[columns[c].name] = std::move(values);
  }
  json all_rooms = json::array();
  for (std::size_t r = 0; r < n; ++r) {
    json values = json::array();
    for (std::size_t p = 0; p < points; ++p) values.push_back(rooms[p * n + r].value());
    all_rooms.push_back(std::move(values));
  }
  out["rooms_degc"] = std::move(all_rooms);
}

void append_number(std::string& out, double value, int decimals) {
  out += ',';
  if (std::isfinite(value)) out += fmt::format("{:.{}f}", value, decimals);
}

}  // namespace

std::optional<std::uint64_t> rows_of_span(std::string_view span) {
  if (span == "day") return rows_per_day;
  if (span == "week") return 7 * rows_per_day;
  if (span == "month") return TrendStore::capacity;
  return {};
}

json trends(const TrendStore& store, std::string_view span, bool of_band) {
  json out{{"span", span},
           {"reading", store.is_reading()},
           {"trouble", store.trouble()},
           {"has_meters", store.has_meters()},
           {"target_degc", of_band ? json() : rounded(store.target_degc())}};
  const std::uint64_t rows = rows_of_span(span).value_or(rows_per_day);
  if (store.count() == 0) {
    out["points"] = 0;
    return out;
  }
  const CivilTime last = store.row(store.count() - 1).time;
  const auto span_s = static_cast<std::int64_t>(rows) * row_s;
  const std::uint64_t from = store.from({last.seconds - span_s + row_s});
  const auto rows_a_point = static_cast<std::int64_t>((rows + max_points - 2) / (max_points - 1));
  const std::int64_t step_s = rows_a_point * row_s;
  const std::int64_t begin_s = store.row(from).time.seconds / step_s * step_s;
  const auto points = static_cast<std::size_t>((last.seconds - begin_s) / step_s + 1);
  out["from"] = text_of_time(store.row(from).time);
  out["to"] = text_of_time(last);
  out["step_s"] = step_s;
  out["points"] = points;
  out["rows"] = store.count() - from;
  add_curves(store, from, step_s, points, out);
  out["zones"] = of_band ? zones_of(store) : json();
  out["spells"] = spells_of(store, from);
  out["days"] = days_of(store, from, of_band);
  out["by_control"] = by_control(store, from, of_band);
  return out;
}

std::string trends_csv_header(const TrendStore& store) {
  std::string out = "time,mode,reason";
  for (const NamedColumn& c : columns) out += std::string(",") + c.name;
  for (int r = 1; r <= store.vavs(); ++r) out += fmt::format(",room_temp_{}_degc", r);
  return out + "\n";
}

void append_csv_row(const TrendStore& store, std::uint64_t number, std::string& out) {
  const TrendRow& row = store.row(number);
  out += text_of_time(row.time) + ',';
  if (row.mode >= 0) out += text_of(static_cast<ControlMode>(row.mode));
  out += std::string(",") + text_of(static_cast<Reason>(row.reason));
  for (const NamedColumn& c : columns) {
    append_number(out, static_cast<double>(row.*c.column), c.per_unit > 100 ? 3 : 2);
  }
  for (int r = 0; r < store.vavs(); ++r) append_number(out, static_cast<double>(store.rooms_degc(number)[r]), 2);
  out += '\n';
}

}  // namespace airside::page
