#include "tools/study/method/figures.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>
#include <utility>
#include <vector>

namespace airside::tools {

namespace {

constexpr const char* days_note = "Mean over rooms and seeds, day by day of control.";

std::vector<double> means_of(const std::vector<Spread>& days) {
  std::vector<double> y;
  for (const Spread& s : days) y.push_back(s.mean);
  return y;
}

/// Lines over the days of control. Series without a day are left out; a line chart has as many days as its shortest.
class DayChart {
 public:
  DayChart(std::string title, std::string note) {
    chart_.title = std::move(title);
    chart_.note = std::move(note);
    chart_.unit = "K";
    chart_.x_label = "day";
    chart_.x_is_time = false;
    chart_.y_min = 0;
    chart_.decimals = 3;
  }
  void add(const std::string& name, std::vector<double> days, SeriesRole role = SeriesRole::plain) {
    if (!days.empty()) chart_.series.push_back({name, std::move(days), role});
  }
  std::optional<ReportBlock> block(std::optional<double> level = {}, const char* level_name = "") {
    if (chart_.series.empty()) return {};
    std::size_t days = SIZE_MAX;
    for (const ChartSeries& s : chart_.series) days = std::min(days, s.y.size());
    for (ChartSeries& s : chart_.series) s.y.resize(days);
    for (std::size_t day = 1; day <= days; ++day) chart_.x.push_back(static_cast<double>(day));
    if (level) chart_.series.push_back({level_name, std::vector<double>(days, *level), SeriesRole::reference});
    return chart_;
  }

 private:
  LineChart chart_;
};

/// A bar of a figure a category, with whiskers where there are several runs.
struct Bars {
  std::vector<std::string> categories;
  std::vector<double> first, second, first_spread, second_spread;

  void add(const std::string& category, const Spread& a, const Spread& b) {
    categories.push_back(category);
    first.push_back(a.mean);
    first_spread.push_back(a.sd);
    second.push_back(b.mean);
    second_spread.push_back(b.sd);
  }
};

std::optional<ReportBlock> bars_of(const std::string& title, const std::string& note, const Bars& bars) {
  if (bars.categories.empty()) return {};
  BarChart chart{title, note, "K", bars.categories, {}, 3};
  chart.groups = {{"DAE", bars.first, bars.first_spread, SeriesRole::main},
                  {"DARV", bars.second, bars.second_spread, SeriesRole::plain}};
  return chart;
}

Spread peer_spread(const PeerRow& row, const std::string& key) {
  return {row.number(key).value_or(0), row.number(key + "_sd").value_or(0), row.runs};
}

constexpr auto neural_peers = std::to_array<std::pair<const char*, const char*>>({{"osln", "OSLN"}, {"ddqn", "DDQN"}});

TableCell count_cell(int count) {
  TableCell cell;
  cell.value = count;
  return cell;
}

TableCell cell_of(const PeerRow& row, const std::string& key, double factor = 1) {
  TableCell cell;
  if (const auto value = row.number(key)) cell.value = factor * *value;
  if (const auto sd = row.number(key + "_sd")) cell.spread = factor * *sd;
  return cell;
}

}  // namespace

TableColumn table_column(const std::string& name, const std::string& unit, int decimals, bool mark_lowest) {
  TableColumn c;
  c.name = name;
  c.unit = unit;
  c.decimals = decimals;
  c.mark_lowest = mark_lowest;
  return c;
}

std::optional<ReportBlock> figure_of_days(const MethodResults& results, const PeerRows& peers) {
  DayChart chart("Distance from target, day by day (printed figure 7)",
                 "Mean over seeds. OSLN and DDQN are of the peers' own harness: the same room, other days.");
  chart.add("the method", means_of(results.daily_dae("paper")), SeriesRole::main);
  chart.add("PID", means_of(results.daily_dae("pid")));
  for (const auto& [method, name] : neural_peers) {
    if (const PeerRow* row = peers.of_control(method)) chart.add(name, row->daily_dae_degc());
  }
  chart.add("expert schedule", means_of(results.daily_dae("expert")), SeriesRole::muted);
  return chart.block();
}

std::optional<ReportBlock> figure_of_two_weeks(const MethodResults& results, const PeerRows& peers) {
  Bars bars;
  for (const auto& [row, name] : {std::pair{"paper", "the method"}, {"pid", "PID"}}) {
    if (results.has(row)) bars.add(name, results.spread(row, "dae_degc"), results.spread(row, "darv_degc"));
  }
  for (const auto& [method, name] : neural_peers) {
    if (const PeerRow* row = peers.of_control(method))
      bars.add(name, peer_spread(*row, "dae_degc"), peer_spread(*row, "darv_degc"));
  }
  return bars_of("Deviation and unrest of the setpoint (printed figure 8)",
                 "DAE: mean distance from the target in working hours. DARV: mean change of the setpoint from cycle to "
                 "cycle. Whiskers: standard deviation over seeds.",
                 bars);
}

std::optional<ReportBlock> figure_of_pretraining(const MethodResults& results) {
  DayChart chart("Learning in the twin (printed figure 9)", days_note);
  for (const char* room : {"701", "702"})
    chart.add(fmt::format("twin {}", room), means_of(results.daily_dae("source-dynamic", room)));
  return chart.block();
}

std::optional<ReportBlock> figure_of_cycles(const MethodResults& results) {
  constexpr auto rows = std::to_array<std::pair<const char*, const char*>>({{"paper-6", "paper, 6 min"},
                                                                            {"paper-12", "paper, 12 min"},
                                                                            {"paper", "paper, 18 min"},
                                                                            {"paper-24", "paper, 24 min"},
                                                                            {"product-6", "product, 6 min"},
                                                                            {"product-12", "product, 12 min"},
                                                                            {"product-18", "product, 18 min"},
                                                                            {"product-24", "product, 24 min"}});
  Bars bars;
  for (const auto& [row, name] : rows) {
    if (results.has(row)) bars.add(name, results.spread(row, "dae_degc"), results.spread(row, "darv_degc"));
  }
  return bars_of("Length of the control cycle (printed figure 10)",
                 "DARV is a change from cycle to cycle: a shorter cycle has more of them in an hour.", bars);
}

std::optional<ReportBlock> figure_of_saved_area(const MethodResults& results) {
  BarChart chart;
  chart.title = "Area saved against the historical setpoint (printed figure 11)";
  chart.note = "Mean over days of the setpoint's distance above 20.5 °C, times hours. It is no energy.";
  chart.unit = "K h/day";
  chart.categories = {"701-real", "702-real"};
  chart.decimals = 1;
  constexpr auto starts = std::to_array<std::pair<const char*, const char*>>(
      {{"dynamic-5", "transferred"}, {"static-5", "static pretraining"}, {"scratch-5", "from scratch"}});
  for (const auto& [row, name] : starts) {
    if (!results.has(row)) continue;
    BarGroup group{name, {}, {}, chart.groups.empty() ? SeriesRole::main : SeriesRole::plain};
    for (const std::string& room : chart.categories) {
      const Spread s = results.spread(row, "saved_area_degch", room);
      group.y.push_back(s.count > 0 ? s.mean : std::numeric_limits<double>::quiet_NaN());
      group.spread.push_back(s.sd);
    }
    chart.groups.push_back(std::move(group));
  }
  if (chart.groups.empty()) return {};
  return chart;
}

std::optional<ReportBlock> figure_of_transfer(const MethodResults& results, const std::string& room) {
  DayChart chart(fmt::format("Room {} after five schedule days (printed figure 12)", room), days_note);
  chart.add("dynamic pretraining", means_of(results.daily_dae("dynamic-5", room)), SeriesRole::main);
  chart.add("static pretraining", means_of(results.daily_dae("static-5", room)));
  chart.add("from scratch", means_of(results.daily_dae("scratch-5", room)));
  return chart.block();
}

std::optional<ReportBlock> figure_of_neighbours(const MethodResults& results, const std::string& room) {
  DayChart chart(fmt::format("Room {}, from 60 days of room 301 (printed figure 13)", room), days_note);
  chart.add("from room 301", means_of(results.daily_dae("room-to-room", room)), SeriesRole::main);
  chart.add("alone", means_of(results.daily_dae("room-alone", room)));
  return chart.block(0.15, "published: below 0.15");
}

std::optional<ReportBlock> peers_table(const PeerRows& peers) {
  if (peers.control.empty()) return {};
  ReportTable table;
  table.title = "Other learners in the peers' own harness (printed table VII, methods of figures 7 and 8)";
  table.note =
      "One room, five schedule days, the same budget of learning for all. Mean ± standard deviation over "
      "seeds. What is printed: docs/peers.md.";
  table.columns = {table_column("runs", "", 0, false),         table_column("DAE", "K", 3, true),
                   table_column("ME", "K", 3, true),           table_column("DARV", "K", 3, true),
                   table_column("first 3 days", "K", 3, true), table_column("CDH", "K h", 0, false),
                   table_column("a decision", "ms", 2, true)};
  for (const PeerRow& row : peers.control) {
    table.rows.push_back(
        {row.method,
         {count_cell(row.runs), cell_of(row, "dae_degc"), cell_of(row, "me_degc"), cell_of(row, "darv_degc"),
          cell_of(row, "first_days_degc"), cell_of(row, "cdh_degch"), cell_of(row, "decision_s", 1e3)},
         row.method == "ed" ? SeriesRole::main : SeriesRole::plain,
         true});
  }
  return table;
}

std::optional<ReportBlock> transfer_table(const PeerRows& peers) {
  if (peers.transfer.empty()) return {};
  ReportTable table;
  table.title = "Errors after transfer, weights frozen (printed tables III and VI)";
  table.note = "Mean ± standard deviation over seeds, K, on logs under the product. What is printed: docs/peers.md.";
  table.columns = {table_column("runs", "", 0, false), table_column("summer", "K", 3, false),
                   table_column("winter", "K", 3, false), table_column("average", "K", 3, false)};
  for (const PeerRow& row : peers.transfer) {
    table.rows.push_back({fmt::format("{}, {}", row.room, row.method),
                          {count_cell(row.runs), cell_of(row, "mae_summer_degc"), cell_of(row, "mae_winter_degc"),
                           cell_of(row, "mae_average_degc")},
                          row.method == "dynamic" ? SeriesRole::main : SeriesRole::plain,
                          false});
  }
  return table;
}

}  // namespace airside::tools
