#include "tools/report/run_charts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

#include "hal/text/civil_text.hpp"
#include "tools/report/charts/report_text.hpp"

namespace airside::tools {
namespace {

std::vector<double> seconds_of(const std::vector<CivilTime>& times) {
  std::vector<double> x;
  x.reserve(times.size());
  for (const CivilTime t : times) x.push_back(static_cast<double>(t.seconds));
  return x;
}

/// Place of a mode on the axis of the chart; NaN for a row without one.
std::vector<double> levels_of(const std::vector<std::string>& modes) {
  static const std::map<std::string, double, std::less<>> places = {
      {"release", 0}, {"expert", 1}, {"run", 2}, {"learn", 3}};
  std::vector<double> levels;
  for (const std::string& mode : modes) {
    const auto place = places.find(mode);
    levels.push_back(place != places.end() ? place->second : std::nan(""));
  }
  return levels;
}

/// Every time in which the controller had a reason for its mode, from one row to the next; nothing without one.
std::optional<ReportTable> events_table(const RunRecord& r) {
  constexpr std::size_t most = 40;
  ReportTable table;
  table.title = "What the controller did, and why";
  table.row_header = "from";
  table.prose = true;
  for (const char* name : {"to", "for", "mode", "reason"}) table.columns.emplace_back().name = name;
  const auto cell = [](std::string text) {
    TableCell c;
    c.text = std::move(text);
    return c;
  };
  const auto time_text = [](CivilTime t) { return day_text(t) + hal::civil_text(t).substr(10, 6).replace(0, 1, " "); };
  std::size_t events = 0;
  for (std::size_t i = 0; i < r.mode.size();) {
    std::size_t end = i + 1;
    while (end < r.mode.size() && r.mode[end] == r.mode[i] && r.reason[end] == r.reason[i]) ++end;
    if (!r.reason[i].empty() && r.reason[i] != "none" && ++events <= most) {
      const CivilTime to = end < r.mode.size() ? r.row_time[end] : CivilTime{r.row_time.back().seconds + row_s};
      const double hours = static_cast<double>(to.seconds - r.row_time[i].seconds) / 3600;
      table.rows.push_back({time_text(r.row_time[i]),
                            {cell(time_text(to)), cell(fmt::format("{:.1f} h", hours)),
                             cell(r.mode[i] == "expert" ? "schedule" : r.mode[i]), cell(r.reason[i])},
                            SeriesRole::plain,
                            false});
    }
    i = end;
  }
  if (events == 0) return {};
  table.note = events > most ? fmt::format("The first {} of {}.", most, events) : "";
  return table;
}

/// Charts over the time of a run, in the order in which they are read.
class RunCharts {
 public:
  RunCharts(const RunRecord& r, ReportInput& out) : r_(r), out_(out) {
    if (!r.row_time.empty()) {
      base_.bands = working_hours(r.row_time.front(), r.row_time.back(), r.metrics);
    } else if (!r.cycle_time.empty()) {
      base_.bands = working_hours(r.cycle_time.front(), r.cycle_time.back(), r.metrics);
    }
    base_.band_name = "working hours";
  }

  void add_rooms() {
    LineChart rooms = chart("Room temperature",
                            r_.band ? "Zone setpoint: mean of the zones' own thermostats. Working hours are shaded."
                                    : "Working hours are shaded; only they are scored.",
                            "°C", r_.row_time);
    for (const NamedValues& room : r_.room_temp_degc) line(rooms, room.name, room.values, SeriesRole::muted, false);
    line(rooms, "mean", r_.room_mean_degc, SeriesRole::main, false);
    if (r_.band) {
      line(rooms, "zone setpoint", r_.band->setpoint_degc, SeriesRole::reference, true);
    } else {
      line(rooms, "target", {r_.metrics.target_degc}, SeriesRole::reference, false);
    }
    add(rooms);
  }

  void add_boxes() {
    LineChart boxes =
        chart("Closed boxes", "A line that is raised: the VAV box of that room is closed.", "", r_.row_time);
    for (std::size_t i = 0; i < r_.boxes_on.size(); ++i) {
      std::vector<double> trace;
      for (const double on : r_.boxes_on[i].values)
        trace.push_back(std::isfinite(on) ? static_cast<double>(i) + (on < 0.5 ? 0.7 : 0) : on);
      boxes.y_names.push_back(r_.boxes_on[i].name);
      line(boxes, r_.boxes_on[i].name, trace, SeriesRole::plain, true);
    }
    boxes.raised = "closed";
    add(boxes);
  }

  void add_setpoint() {
    LineChart setpoint =
        chart("Supply-air setpoint",
              r_.band ? "The setpoint that the AHU took, beside that of the schedule."
                      : "The setpoint that the AHU took, beside what the schedule, the network and the room head would "
                        "each have chosen.",
              "°C", r_.cycle_time);
    line(setpoint, "expert schedule", r_.expert_setpoint_degc, SeriesRole::reference, true);
    line(setpoint, "network", r_.network_setpoint_degc, SeriesRole::muted, true);
    line(setpoint, "room head", r_.head_setpoint_degc, SeriesRole::muted, true);
    line(setpoint, "applied", r_.setpoint_degc, SeriesRole::main, true);
    add(setpoint);
  }

  void add_dampers() {
    if (!r_.band || r_.band->dampers.empty()) return;
    LineChart dampers = chart("Dampers", "At 1 a box has no more to give.", "0 to 1", r_.row_time);
    for (std::size_t i = 0; i < r_.band->dampers.size(); ++i) {
      dampers.series.push_back({r_.band->zones[i].name, r_.band->dampers[i], SeriesRole::muted, false});
    }
    dampers.series.push_back({"most open", r_.band->most_open, SeriesRole::main, false});
    dampers.y_min = 0;
    dampers.y_max = 1;
    add(dampers);
  }

  void add_modes() {
    LineChart modes = chart("Control mode",
                            "Learn: control, and learning. Run: control with frozen weights. Schedule: the setpoint of "
                            "the schedule. Release: nothing is written.",
                            "", r_.row_time);
    if (!r_.mode.empty()) {
      line(modes, "mode", levels_of(r_.mode), SeriesRole::main, true);
      modes.y_names = {"release", "schedule", "run", "learn"};
    }
    add(modes);
    if (auto table = events_table(r_)) out_.blocks.emplace_back(std::move(*table));
  }

  void add_learning() {
    LineChart confidence =
        chart("Confidence",
              "How far the controller trusts its own forecast: at 1 the schedule has no say, at 0 the "
              "schedule decides.",
              "0 to 1", r_.cycle_time);
    line(confidence, "confidence", r_.confidence, SeriesRole::main, true);
    confidence.y_min = 0;
    confidence.y_max = 1;
    add(confidence);

    LineChart losses = chart("Forecast losses",
                             "Errors of the network in its own units, each measured before it learnt "
                             "from the cycle. Lower is better.",
                             "loss, log scale", r_.cycle_time);
    for (const NamedValues& loss : r_.losses) {
      line(losses, loss.name, loss.values, loss.name == "total" ? SeriesRole::main : SeriesRole::plain, false);
    }
    losses.log_axis = true;
    add(losses);
  }

  void add_plant() {
    LineChart power = chart(r_.all_electric ? "Electric power" : "Power", "", "kW", r_.row_time);
    for (const NamedValues& p : r_.power_kw) line(power, p.name, p.values, SeriesRole::plain, false);
    power.y_min = 0;
    add(power);

    LineChart outdoor = chart("Outdoor temperature", "", "°C", r_.row_time);
    line(outdoor, "outdoor air", r_.outdoor_degc, SeriesRole::plain, false);
    outdoor.decimals = 1;
    add(outdoor);
  }

 private:
  LineChart chart(const char* title, const char* note, const char* unit, const std::vector<CivilTime>& time) const {
    LineChart c = base_;
    c.title = title;
    c.note = note;
    c.unit = unit;
    c.x = seconds_of(time);
    return c;
  }
  void add(LineChart& c) {
    if (!c.series.empty() && !c.x.empty()) out_.blocks.emplace_back(std::move(c));
  }
  static void line(LineChart& c, std::string name, const std::vector<double>& y, SeriesRole role, bool stepped) {
    if (!y.empty()) c.series.push_back({std::move(name), y, role, stepped});
  }

  const RunRecord& r_;
  ReportInput& out_;
  LineChart base_;
};

}  // namespace

void add_line_charts(const RunRecord& r, ReportInput& out) {
  RunCharts charts(r, out);
  charts.add_rooms();
  charts.add_boxes();
  charts.add_setpoint();
  charts.add_dampers();
  charts.add_modes();
  charts.add_learning();
  charts.add_plant();
}

}  // namespace airside::tools
