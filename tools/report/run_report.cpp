#include "tools/report/run_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "hal/text/input_error.hpp"
#include "tools/report/charts/report_text.hpp"
#include "tools/report/run_charts.hpp"

namespace airside::tools {
namespace {

using ResultKind = MethodResult::Kind;

const MethodResult& ours_of(const std::vector<MethodResult>& methods) {
  const MethodResult* ours = nullptr;
  for (const MethodResult& m : methods) {
    if (m.runs.empty()) {
      throw hal::InputError("report: method \"" + m.name + '"', "no run", "one run a seed", "leave the method out");
    }
    if (m.kind != ResultKind::ours) continue;
    if (ours) throw hal::InputError("report", "two methods of kind ours", "exactly one", "mark one as a peer");
    ours = &m;
  }
  if (!ours) throw hal::InputError("report", "no method of kind ours", "exactly one", "mark the method of the report");
  return *ours;
}

const MethodResult* schedule_of(const std::vector<MethodResult>& methods) {
  for (const MethodResult& m : methods) {
    if (m.kind == ResultKind::schedule) return &m;
  }
  return nullptr;
}

SeriesRole role_of(ResultKind kind) {
  return kind == ResultKind::ours       ? SeriesRole::main
         : kind == ResultKind::schedule ? SeriesRole::reference
                                        : SeriesRole::plain;
}

double mean_of(const MethodResult& method, double Metrics::*figure) { return spread_of(method.runs, figure).mean; }

std::string rooms_text(std::size_t rooms) {
  constexpr const char* words[] = {"no", "one", "two", "three", "four", "five", "six", "seven", "eight"};
  return rooms < std::size(words) ? words[rooms] : std::to_string(rooms);
}

/// What an operator wants to know, in the order of asking: comfort, worst day, schedule, energy.
std::string headline(const RunRecord& r, const MethodResult& ours, const MethodResult* schedule) {
  const long days = std::ssize(ours.runs[0].days);
  const std::size_t rooms = r.room_temp_degc.size();
  const char* energy = r.all_electric ? "electricity" : "energy";
  const double used = mean_of(ours, &Metrics::hvac_kwh_per_day);
  const double before = schedule ? mean_of(*schedule, &Metrics::hvac_kwh_per_day) : 0;
  if (r.band) {
    std::string said = band_headline(*r.band, days_text(std::max(1L, std::ssize(r.row_time) / rows_per_day)));
    if (!(used > 0 && before > 0)) return said;
    return said + fmt::format(" The schedule used {} kWh of {} a day on the same days, this control {} kWh.",
                              number_text(before, 1), energy, number_text(used, 1));
  }
  // A distance, never praise: the same words must do for a control that fails.
  std::string text = fmt::format(
      "Over {} the mean of the {} was {} K from the {} °C target on average in working hours, and {} K on the worst "
      "day.",
      days_text(days),
      rooms == 1   ? "room"
      : rooms == 0 ? "rooms"
                   : rooms_text(rooms) + " rooms",
      number_text(mean_of(ours, &Metrics::dae_degc), 2), number_text(r.metrics.target_degc, 2),
      number_text(mean_of(ours, &Metrics::me_degc), 2));
  if (!schedule) return text;
  text += fmt::format(" The expert schedule was {} K from it on the same days",
                      number_text(mean_of(*schedule, &Metrics::dae_degc), 2));
  if (!(used > 0 && before > 0)) return text + ".";
  // No "less" or "more": rooms differ by more than any two methods do in one room (README.md, "Limits").
  return text + fmt::format(" and used {} kWh of {} a day, this control {} kWh.", number_text(before, 1), energy,
                            number_text(used, 1));
}

std::vector<KeyFigure> key_figures(const RunRecord& r, const MethodResult& ours, const MethodResult* schedule) {
  const auto figure = [&](const char* label, double Metrics::*member, const char* unit, int decimals) {
    const Spread s = spread_of(ours.runs, member);
    std::string note;
    if (s.count > 1) note = fmt::format("± {} over {} runs", number_text(s.sd, decimals), s.count);
    if (schedule) {
      note += fmt::format("{}schedule {}", note.empty() ? "" : "; ", number_text(mean_of(*schedule, member), decimals));
    }
    return KeyFigure{number_text(s.mean, decimals), unit, label, note};
  };
  std::vector<KeyFigure> figures = {figure("Average error", &Metrics::dae_degc, "K", 3),
                                    figure("Error on the worst day", &Metrics::me_degc, "K", 3),
                                    figure("Error on the first day", &Metrics::day1_dae_degc, "K", 3),
                                    figure("Setpoint unrest (DARV)", &Metrics::darv_degc, "K", 3)};
  if (r.band) {
    figures.erase(figures.begin(), figures.begin() + 3);
    figures.insert(figures.begin(),
                   {{number_text(r.band->above_degch_per_day(), 2), "K h", "Zones too warm a day", "all zones"},
                    {number_text(r.band->saturated_h_per_day(), 1), "h", "Boxes fully open a day", "all zones"}});
    if (r.band->shows_heating) {
      figures.insert(figures.begin() + 1,
                     {number_text(r.band->below_degch_per_day(), 2), "K h", "Zones too cold a day", "all zones"});
    }
  }
  if (mean_of(ours, &Metrics::hvac_kwh_per_day) > 0) {
    figures.push_back(
        figure(r.all_electric ? "Electricity a day" : "Energy a day", &Metrics::hvac_kwh_per_day, "kWh", 1));
  }
  return figures;
}

TableRow empty_row(const MethodResult& m) {
  TableRow row;
  row.name = m.name;
  if (m.kind == ResultKind::ours) row.role = SeriesRole::main;
  if (m.kind == ResultKind::floor) row.role = SeriesRole::reference;
  row.competes = m.kind != ResultKind::floor;  // floors know the future
  return row;
}

/// Ours first, then by average error; floors are no controllers and stay out.
std::vector<const MethodResult*> ranked(const std::vector<MethodResult>& methods) {
  std::vector<const MethodResult*> order;
  for (const MethodResult& m : methods) {
    if (m.kind != ResultKind::floor) order.push_back(&m);
  }
  std::stable_sort(order.begin(), order.end(), [](const MethodResult* a, const MethodResult* b) {
    if ((a->kind == ResultKind::ours) != (b->kind == ResultKind::ours)) return a->kind == ResultKind::ours;
    return mean_of(*a, &Metrics::dae_degc) < mean_of(*b, &Metrics::dae_degc);
  });
  return order;
}

/// The ranked methods, then the floors in the order given.
std::vector<const MethodResult*> table_order(const std::vector<MethodResult>& methods) {
  std::vector<const MethodResult*> order = ranked(methods);
  for (const MethodResult& m : methods) {
    if (m.kind == ResultKind::floor) order.push_back(&m);
  }
  return order;
}

BarChart daily_bars(const RunRecord& r, const MethodResult& ours) {
  BarChart chart;
  chart.title = "Error of each day";
  chart.note = std::string("Daily average error (DAE) of the mean room temperature in working hours") +
               (ours.runs.size() > 1 ? ", mean over the runs" : "") + ". Choose a method to see it alone.";
  chart.unit = "DAE, K";
  chart.decimals = 3;
  for (const DayMetrics& day : ours.runs[0].days) chart.categories.push_back(day_text(day.midnight));
  for (const MethodResult* m : ranked(r.methods)) {
    BarGroup group{m->name, {}, {}, role_of(m->kind)};
    for (std::size_t d = 0; d < chart.categories.size(); ++d) {
      std::vector<double> values;
      for (const Metrics& run : m->runs) {
        if (d < run.days.size()) values.push_back(run.days[d].dae_degc);
      }
      const Spread s = spread_of(values);
      group.y.push_back(s.count > 0 ? s.mean : std::nan(""));
      group.spread.push_back(s.sd);
    }
    chart.groups.push_back(std::move(group));
  }
  return chart;
}

ReportTable rooms_table(const RunRecord& r, const MethodResult& ours) {
  ReportTable table;
  table.title = "Error of each room";
  table.note =
      "Average error of every room by itself, working hours. One AHU serves all rooms, so the mean can be right "
      "while rooms differ; a large figure here asks for a look at that room's VAV balance.";
  const std::size_t rooms = ours.runs[0].room_dae_degc.size();
  for (std::size_t i = 0; i < rooms; ++i) {
    table.columns.push_back({i < r.room_names.size() ? r.room_names[i] : fmt::format("room {}", i + 1), "K", 2, true});
  }
  for (const MethodResult* method : table_order(r.methods)) {
    const MethodResult& m = *method;
    TableRow row = empty_row(m);
    for (std::size_t i = 0; i < rooms; ++i) {
      std::vector<double> values;
      for (const Metrics& run : m.runs) {
        if (i < run.room_dae_degc.size()) values.push_back(run.room_dae_degc[i]);
      }
      const Spread s = spread_of(values);
      TableCell cell;
      if (s.count > 0) cell.value = s.mean;
      if (s.count > 1) cell.spread = s.sd;
      row.cells.push_back(cell);
    }
    table.rows.push_back(std::move(row));
  }
  constexpr std::size_t side_by_side = 8;
  return rooms > side_by_side ? turned(table, "room") : table;
}

}  // namespace

std::vector<ChartBand> working_hours(CivilTime from, CivilTime to, const MetricsSettings& settings) {
  std::vector<ChartBand> bands;
  for (std::int64_t day = from.day(); day <= to.day(); ++day) {
    const CivilTime midnight{day * 86400};
    if (settings.weekdays_only && midnight.weekday() >= 5) continue;
    const double start = static_cast<double>(midnight.seconds + settings.work_start_s);
    const double end = static_cast<double>(midnight.seconds + settings.work_end_s);
    const double low = std::max(start, static_cast<double>(from.seconds));
    const double high = std::min(end, static_cast<double>(to.seconds));
    if (high > low) bands.push_back({low, high});
  }
  return bands;
}

ReportTable methods_table(const std::vector<MethodResult>& methods, const char* energy) {
  struct Figure {
    const char* name;
    const char* unit;
    double Metrics::*member;
    int decimals;
    bool mark;
  };
  static constexpr Figure figures[] = {
      {"DAE", "K", &Metrics::dae_degc, 3, true},
      {"ME", "K", &Metrics::me_degc, 3, true},
      {"worst room", "K", &Metrics::worst_room_dae_degc, 3, true},
      {"day 1", "K", &Metrics::day1_dae_degc, 3, true},
      {"DARV", "K", &Metrics::darv_degc, 3, true},
      {"degree-hours", "K h a day", &Metrics::degree_hours_degch, 2, true},
      {"above target", "K h a day", &Metrics::degree_hours_above_degch, 2, true},
      {"electricity", "kWh a day", &Metrics::hvac_kwh_per_day, 1, true},
      {"CDH", "K h", &Metrics::cdh_degch, 1, false},
      {"HDH", "K h", &Metrics::hdh_degch, 1, false},
  };
  ReportTable table;
  table.title = "All methods";
  const bool several = std::ranges::any_of(methods, [](const MethodResult& m) { return m.runs.size() > 1; });
  table.note =
      std::string(several ? "Mean ± standard deviation over the runs; the" : "The") +
      " same plant, weather, days and seeds for all; the best of each column is bold. DAE is the daily average "
      "error of the rooms' mean, ME that of the worst day, worst room that of the day's worst room, DARV the mean "
      "change of the setpoint's step from cycle to cycle; CDH "
      "and HDH are gaps between setpoint and room, not energy.";
  for (const Figure& f : figures) {
    table.columns.push_back({f.member == &Metrics::hvac_kwh_per_day ? energy : f.name, f.unit, f.decimals, f.mark});
  }
  for (const MethodResult* m : table_order(methods)) {
    TableRow row = empty_row(*m);
    for (const Figure& f : figures) {
      const Spread s = spread_of(m->runs, f.member);
      TableCell cell;
      const bool measured = s.count > 0 && (f.member != &Metrics::hvac_kwh_per_day || s.mean != 0);
      if (measured) cell.value = s.mean;
      if (measured && s.count > 1) cell.spread = s.sd;
      row.cells.push_back(cell);
    }
    table.rows.push_back(std::move(row));
  }
  return table;
}

ReportInput make_run_report(const RunRecord& r) {
  const MethodResult& ours = ours_of(r.methods);
  const MethodResult* schedule = schedule_of(r.methods);
  ReportInput out;
  out.title = r.site.empty() ? "Control run" : r.site;
  out.subtitle = r.plant;
  // A plant's own description may name the weather already.
  if (!r.weather.empty() && r.plant.find(r.weather) == std::string::npos) out.subtitle += ", weather " + r.weather;
  if (!r.row_time.empty()) {
    out.subtitle += fmt::format(", {} to {}", date_text(r.row_time.front()), date_text(r.row_time.back()));
  }
  if (!r.versions.empty()) out.subtitle += ", " + r.versions;
  out.headline = headline(r, ours, schedule);
  out.figures = key_figures(r, ours, schedule);
  add_line_charts(r, out);
  if (r.band) out.blocks.emplace_back(zones_table(*r.band));
  if (!r.band) out.blocks.emplace_back(daily_bars(r, ours));
  out.blocks.emplace_back(methods_table(r.methods, r.all_electric ? "electricity" : "energy"));
  if (!r.band && !ours.runs[0].room_dae_degc.empty()) out.blocks.emplace_back(rooms_table(r, ours));
  out.command = r.command;
  const auto fact = [&](const char* name, const std::string& value) {
    if (!value.empty()) out.facts.push_back({name, value});
  };
  fact("site", r.site);
  fact("plant", r.plant);
  fact("weather", r.weather);
  fact("seeds", r.seeds);
  fact("versions", r.versions);
  fact("weights", r.weights_digest);
  out.facts.insert(out.facts.end(), r.more_facts.begin(), r.more_facts.end());
  return out;
}

}  // namespace airside::tools
