#include "tools/report/run_charts.hpp"

#include <cmath>
#include <functional>
#include <map>

#include "tools/report/run_stretches.hpp"

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
    stretches_ = stretches_of(r);
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
    add_with_stretches(rooms);
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
    add_with_stretches(setpoint);
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
                            "As the operator's page names them. Schedule: the setpoint of the schedule. Released: "
                            "nothing is written. The same is shaded behind rooms, setpoint and power.",
                            "", r_.row_time);
    if (!r_.mode.empty()) {
      line(modes, "mode", levels_of(r_.mode), SeriesRole::main, true);
      for (const char* mode : {"release", "expert", "run", "learn"}) modes.y_names.push_back(mode_words(mode));
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
    add_with_stretches(power);

    LineChart outdoor = chart("Outdoor temperature", "", "°C", r_.row_time);
    line(outdoor, "outdoor air", r_.outdoor_degc, SeriesRole::plain, false);
    outdoor.decimals = 1;
    add_with_stretches(outdoor);
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
  /// With the controller's modes and alarms behind the curves, so that an hour of release is seen where its spike is.
  void add_with_stretches(LineChart& c) {
    c.stretches = stretches_;
    c.stretches_name = "mode";
    c.otherwise = mode_words("learn");
    add(c);
  }
  static void line(LineChart& c, std::string name, const std::vector<double>& y, SeriesRole role, bool stepped) {
    if (!y.empty()) c.series.push_back({std::move(name), y, role, stepped});
  }

  const RunRecord& r_;
  ReportInput& out_;
  LineChart base_;
  std::vector<ChartStretch> stretches_;
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
