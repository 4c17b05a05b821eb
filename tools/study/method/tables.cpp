#include "tools/study/method/tables.hpp"
#include "tools/study/table.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace airside::tools {

namespace {

struct Column {
  const char* key;
  const char* title;
  int decimals = 3;
};

struct Line {
  std::string label, row, room;
  std::string prefix;  ///< of the keys
  std::vector<PublishedFigure> published;
};

struct Plan {
  MethodTable table;
  const char* title;
  std::vector<Column> columns;
  std::vector<Line> lines;
};

std::vector<PublishedFigure> published_by(const MethodRow& row) {
  std::vector<PublishedFigure> list;
  for (const PublishedFigure& f : row.published) {
    if (f.key != nullptr) list.push_back(f);
  }
  return list;
}

/// Each row of the table, and before or after them the published setting.
std::vector<Line> lines_of(MethodTable table, const std::string& with_paper = "") {
  std::vector<Line> lines;
  if (!with_paper.empty()) lines.push_back({with_paper, "paper", "", "", published_by(method_row("paper"))});
  for (const MethodRow& row : method_rows()) {
    if (row.table == table) lines.push_back({row.name, row.name, "", "", published_by(row)});
  }
  return lines;
}

Plan control_plan() {
  // The publication has other figures of its method in each study: these are of its comparison (DAE, DARV) and of its
  // two weeks (CDH).
  return {MethodTable::control,
          "Control of room 301 after five schedule days",
          {{"dae_degc", "DAE °C"},
           {"first3_dae_degc", "first 3 days °C"},
           {"me_degc", "ME °C"},
           {"darv_degc", "DARV °C"},
           {"cdh_degch", "CDH °C h", 0},
           {"hdh_degch", "HDH °C h", 1},
           {"saved_area_degch", "saved area °C h/day", 1}},
          {{"the method", "paper", "", "", {{"dae_degc", 0.03222}, {"darv_degc", 0.37255}, {"cdh_degch", 335.9}}},
           {"PID", "pid", "", "", {{"dae_degc", 0.35}, {"cdh_degch", 342.5}}},
           {"expert schedule", "expert", "", "", {}}}};
}

const std::vector<Column> short_columns = {{"me_degc", "ME °C"}, {"dae_degc", "DAE °C"}, {"darv_degc", "DARV °C"}};

Plan physics_plan() {
  return {MethodTable::physics,
          "Forecasts after five schedule days, on days of varied setpoints",
          {{"mae_k", "error of one cycle K", 4}, {"violation_share", "wrong signs"}, {"gain_sign_share", "dS/dA > 0"}},
          {{"with physics losses", "physics", "", "with_", {}}, {"without", "physics", "", "without_", {}}}};
}

Plan pretraining_plan() {
  std::vector<Column> columns = {{"day1_dae_degc", "day 1 °C"},        {"day2_dae_degc", "day 2 °C"},
                                 {"day3_dae_degc", "day 3 °C"},        {"day6_dae_degc", "day 6 °C"},
                                 {"day7_dae_degc", "day 7 °C"},        {"day14_dae_degc", "day 14 °C"},
                                 {"evening_move_k", "move 17-21 h K"}, {"midday_move_k", "move 10-14 h K"},
                                 {"entropy_bit", "setpoints bit", 2},  {"near_target_share", "near target"}};
  return {MethodTable::pretraining,
          "Pretraining: DAE of the days under the agent, moves, variety",
          columns,
          {{"dynamic, twins 701, 702", "source-dynamic", "", "", {}},
           {"static, twins 701, 702", "source-static", "", "", {}},
           {"operated room 301", "source-operated", "", "", {}}}};
}

Plan deployment_plan() {
  Plan plan{MethodTable::deployment,
            "Deployment after five schedule days",
            {{"dae_degc", "DAE °C"},
             {"first3_dae_degc", "first 3 days °C"},
             {"me_degc", "ME °C"},
             {"daily_sd_degc", "sd of days °C"},
             {"darv_degc", "DARV °C"},
             {"saved_area_degch", "saved area °C h/day", 1},
             {"saving_days_share", "days that save"}},
            {}};
  for (const char* room : {"701-real", "702-real"}) {
    for (const char* row : {"dynamic-5", "static-5", "scratch-5"})
      plan.lines.push_back({fmt::format("{}, {}", room, row), row, room, "", {}});
  }
  return plan;
}

Plan data_plan() {
  Plan plan{MethodTable::data,
            "Schedule days before control, rooms 701 and 702",
            {{"dae_degc", "DAE °C"}, {"first3_dae_degc", "first 3 days °C"}, {"me_degc", "ME °C"}},
            {}};
  for (const char* start : {"dynamic", "scratch"}) {
    for (const int days : {1, 3, 5, 10, 20}) {
      const std::string row = fmt::format("{}-{}", start, days);
      plan.lines.push_back({row, row, "", "", {}});
    }
  }
  return plan;
}

Plan neighbours_plan() {
  Plan plan{MethodTable::neighbours,
            "From room 301 to its neighbours (published: below 0.15 °C within a week)",
            {{"dae_degc", "DAE °C"},
             {"day1_dae_degc", "day 1 °C"},
             {"day7_dae_degc", "day 7 °C"},
             {"last_dae_degc", "last day °C"},
             {"darv_degc", "DARV °C"}},
            {}};
  for (const char* room : {"401-real", "402-real"}) {
    for (const char* row : {"room-to-room", "room-alone"})
      plan.lines.push_back({fmt::format("{}, {}", room, row), row, room, "", {}});
  }
  return plan;
}

Plan offline_plan() {
  const auto line = [](const char* label, const char* room, const char* prefix, double summer, double winter,
                       double mean) {
    return Line{label, "offline", room, prefix, {{"summer_k", summer}, {"winter_k", winter}, {"mean_k", mean}}};
  };
  return {MethodTable::offline,
          "Error of one control cycle, weights frozen (kind and unit of the published error are not stated)",
          {{"summer_k", "summer K"}, {"winter_k", "winter K"}, {"mean_k", "mean K"}},
          {line("701, dynamic", "701-real", "dynamic_", 0.078, 0.202, 0.140),
           line("701, static", "701-real", "static_", 0.215, 0.396, 0.306),
           line("701, scratch", "701-real", "scratch_", 0.451, 0.359, 0.405),
           line("702, dynamic", "702-real", "dynamic_", 0.056, 0.298, 0.177),
           line("702, static", "702-real", "static_", 0.204, 0.346, 0.275),
           line("702, scratch", "702-real", "scratch_", 0.259, 0.379, 0.319)}};
}

Plan cycle_plan() {
  Plan plan{MethodTable::cycle,
            "Length of the control cycle, room 301 after five schedule days",
            {{"dae_degc", "DAE °C"},
             {"row_dae_degc", "DAE of all 6-min rows °C"},
             {"me_degc", "ME °C"},
             {"darv_degc", "DARV °C"},
             {"forecast_mae_k", "error of one cycle K", 4},
             {"room_sd_k", "sd of the room mean K"}},
            {}};
  plan.lines = lines_of(MethodTable::cycle);
  const Line published{"paper-18", "paper", "", "", {{"dae_degc", 0.07}, {"darv_degc", 0.28}}};
  plan.lines.insert(plan.lines.begin() + 2, published);
  return plan;
}

std::vector<Plan> plans() {
  return {control_plan(),
          {MethodTable::score, "Weights of the score and discount (a_s, b_s, g)", short_columns,
           lines_of(MethodTable::score, "a1.00-b0.90-g0.50")},
          {MethodTable::ablation, "Ablations", short_columns, lines_of(MethodTable::ablation, "all parts")},
          physics_plan(),
          pretraining_plan(),
          deployment_plan(),
          data_plan(),
          neighbours_plan(),
          offline_plan(),
          cycle_plan()};
}

nlohmann::json line_json(const MethodResults& results, const Plan& plan, const Line& line) {
  nlohmann::json j{
      {"line", line.label}, {"figures", nlohmann::json::object()}, {"published", nlohmann::json::object()}};
  for (const Column& column : plan.columns) {
    const Spread s = results.spread(line.row, line.prefix + column.key, line.room);
    if (s.count > 0) j["figures"][column.key] = {{"mean", s.mean}, {"sd", s.sd}, {"count", s.count}};
    for (const PublishedFigure& f : line.published) {
      if (std::string_view(f.key) == column.key) j["published"][f.key] = f.value;
    }
  }
  return j;
}

/// One run has no spread.
std::string spread_text(const nlohmann::json& spread, int decimals) {
  const auto number = [&](const char* key) { return fmt::format("{:.{}f}", spread[key].get<double>(), decimals); };
  return spread["count"] > 1 ? number("mean") + " ± " + number("sd") : number("mean");
}

}  // namespace

nlohmann::json method_tables_of(const MethodResults& results) {
  nlohmann::json tables = nlohmann::json::array();
  for (const Plan& plan : plans()) {
    nlohmann::json j{{"table", text_of(plan.table)}, {"title", plan.title}, {"lines", nlohmann::json::array()}};
    for (const Column& column : plan.columns)
      j["columns"].push_back({{"key", column.key}, {"title", column.title}, {"decimals", column.decimals}});
    for (const Line& line : plan.lines) {
      nlohmann::json of = line_json(results, plan, line);
      if (!of["figures"].empty()) j["lines"].push_back(std::move(of));
    }
    if (!j["lines"].empty()) tables.push_back(std::move(j));
  }
  return tables;
}

std::string method_table_markdown(const nlohmann::json& table) {
  std::vector<std::vector<std::string>> lines(1, {"run"});
  std::vector<nlohmann::json> columns;
  for (const nlohmann::json& column : table["columns"]) {
    const std::string key = column["key"], title = column["title"];
    const auto any = [&](const char* part) {
      return std::ranges::any_of(table["lines"], [&](const nlohmann::json& l) { return l[part].contains(key); });
    };
    if (!any("figures")) continue;
    columns.push_back(column);
    columns.back()["has_published"] = any("published");
    lines[0].push_back(title);
    if (any("published")) lines[0].emplace_back("published");
  }
  for (const nlohmann::json& line : table["lines"]) {
    std::vector<std::string> cells = {line["line"]};
    for (const nlohmann::json& column : columns) {
      const std::string key = column["key"];
      const int decimals = column["decimals"];
      const bool has = line["figures"].contains(key);
      cells.push_back(has ? spread_text(line["figures"][key], decimals) : "");
      if (!column["has_published"].get<bool>()) continue;
      cells.push_back(line["published"].contains(key) ? fmt::format("{:g}", line["published"][key].get<double>()) : "");
    }
    lines.push_back(std::move(cells));
  }
  return fmt::format("### {}\n\n{}", table["title"].get<std::string>(), markdown_of(lines));
}

}  // namespace airside::tools
