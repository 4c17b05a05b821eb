#include "tools/study/building_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

namespace airside::tools {

namespace {

using Kind = BuildingMethod::Kind;

template <class Figure>
Spread spread(const BuildingLine& line, Figure figure) {
  std::vector<double> values;
  for (const BuildingFigures& f : line.runs) values.push_back(figure(f));
  return spread_of(values);
}

Spread energy(const BuildingLine& line) {
  return spread(line, [](const auto& f) { return f.total_kwh(); });
}
Spread outside(const BuildingLine& line) {
  return spread(line, [](const auto& f) { return f.outside_degch(); });
}

BuildingFigures mean_of(const BuildingLine& line) {
  BuildingFigures mean;
  mean.dae_degc = spread(line, [](const auto& f) { return f.dae_degc; }).mean;
  mean.above_degch = outside(line).mean;
  mean.kwh_per_day = {energy(line).mean};
  return mean;
}

std::vector<const BuildingLine*> rivals_of(const BuildingTable& table, Rivals rivals) {
  std::vector<const BuildingLine*> found;
  for (const BuildingLine& line : table.lines) {
    const bool tuned = line.method.kind != Kind::constant || line.name == table.constant_of_other_days;
    const bool simple = line.method.kind != Kind::mpc && tuned;
    if (line.method.kind != Kind::ours && (simple || rivals == Rivals::all)) found.push_back(&line);
  }
  return found;
}

nlohmann::json json_of(const BuildingVerdict& v) {
  return {{"rival", v.rival},
          {"mean", v.value.mean},
          {"sd", v.value.sd},
          {"outside_degch_mean", v.outside_degch.mean},
          {"outside_degch_sd", v.outside_degch.sd},
          {"allowed", v.allowed},
          {"most_degch", v.most_degch}};
}

/// The folder of the site file, by which people know the building.
std::string building_of(const BuildingTable& table) {
  const auto folder = std::filesystem::path(table.site).parent_path().filename();
  return folder.empty() ? table.site : folder.string();
}

bool is_band(const BuildingTable& table) { return table.objective == Objective::band; }

std::string value_text(const BuildingTable& table, const Spread& value) {
  return is_band(table) ? fmt::format("{:+.1f} ± {:.1f} %", value.mean, value.sd)
                        : fmt::format("{:+.3f} ± {:.3f} °C", value.mean, value.sd);
}

std::string verdict_text(const BuildingTable& table, Rivals rivals) {
  const auto v = verdict_on(table, rivals);
  if (!v) return "-";
  const std::string comfort = fmt::format("{:+.2f} ± {:.2f}", v->outside_degch.mean, v->outside_degch.sd);
  return fmt::format(
      "{}, {} degree-hours ({}){}", value_text(table, v->value), comfort, v->rival,
      v->allowed ? "" : fmt::format(", with more than the {:.2f} that the others may have", v->most_degch));
}

std::string line_text(const BuildingTable& table, const BuildingLine& line) {
  const Spread total = energy(line), dae = spread(line, [](const auto&f) { return f.dae_degc; });
  const Spread above = spread(line, [](const auto& f) { return f.above_degch; });
  const Spread below = spread(line, [](const auto& f) { return f.below_degch; });
  std::string by_meter;
  for (std::size_t m = 0; m < line.runs.front().kwh_per_day.size(); ++m) {
    by_meter += fmt::format("{:.1f} | ", spread(line, [m](const auto& f) { return f.kwh_per_day[m]; }).mean);
  }
  const bool own = line.method.kind == Kind::own;  // its setpoint is no point of the site
  const auto shown = [&](double value) { return own ? std::string("-") : fmt::format("{:.2f}", value); };
  return fmt::format("| {}{} | {:.1f} ± {:.1f} | {}{:.2f} ± {:.2f} | {:.2f} ± {:.2f} | {:.3f} ± {:.3f} | {} | {} |\n",
                     line.name, line.name == table.constant_of_other_days ? " (chosen on other days)" : "", total.mean,
                     total.sd, by_meter, above.mean, above.sd, below.mean, below.sd, dae.mean, dae.sd,
                     shown(spread(line, [](const auto& f) { return f.darv_degc; }).mean),
                     shown(spread(line, [](const auto& f) { return f.setpoint_degc; }).mean));
}

/// `1274.8 ± 90.9 / 0.85`: energy and degree-hours; or DAE and energy.
std::string cell(const BuildingTable& table, const BuildingLine& line) {
  const Spread total = energy(line);
  if (is_band(table)) return fmt::format("{:.1f} ± {:.1f} / {:.2f}", total.mean, total.sd, outside(line).mean);
  const Spread dae = spread(line, [](const auto& f) { return f.dae_degc; });
  return fmt::format("{:.3f} ± {:.3f} / {:.1f}", dae.mean, dae.sd, total.mean);
}

}  // namespace

nlohmann::json json_of(const BuildingTable& table) {
  nlohmann::json methods = nlohmann::json::array();
  for (const BuildingLine& line : table.lines) {
    nlohmann::json runs = nlohmann::json::array();
    for (const BuildingFigures& f : line.runs) runs.push_back(json_of(f));
    methods.push_back(
        {{"method", line.name}, {"kind", name_of(line.method.kind)}, {"value", line.method.value}, {"runs", runs}});
  }
  nlohmann::json j = {
      {"site", table.site},
      {"start", table.start},
      {"meters", table.meters},
      {"objective", is_band(table) ? "band" : "mean"},
      {"zones", table.zones},
      {"constant_of_other_days", table.constant_of_other_days},
      {"integral_gain_per_h", table.gain_per_h > 0 ? nlohmann::json(table.gain_per_h) : nlohmann::json()},
      {"methods", methods}};
  if (const auto v = verdict_on(table, Rivals::simple)) j["against_simple"] = json_of(*v);
  if (const auto v = verdict_on(table, Rivals::all)) j["against_all"] = json_of(*v);
  return j;
}

BuildingTable building_table_of(const nlohmann::json& j) {
  BuildingTable table{.site = j.at("site"),
                      .start = j.at("start"),
                      .meters = j.at("meters"),
                      .objective = j.at("objective") == "band" ? Objective::band : Objective::mean,
                      .zones = j.at("zones"),
                      .constant_of_other_days = j.at("constant_of_other_days"),
                      .gain_per_h = 0,
                      .lines = {}};
  if (!j.at("integral_gain_per_h").is_null()) table.gain_per_h = j.at("integral_gain_per_h");
  for (const nlohmann::json& method : j.at("methods")) {
    BuildingLine line{method.at("method"), {kind_of(method.at("kind")), method.at("value")}, {}};
    for (const nlohmann::json& run : method.at("runs")) line.runs.push_back(figures_of(run));
    table.lines.push_back(line);
  }
  return table;
}

std::optional<BuildingVerdict> verdict_on(const BuildingTable& table, Rivals rivals) {
  const std::vector<const BuildingLine*> lines = rivals_of(table, rivals);
  if (lines.empty() || table.lines.back().method.kind != Kind::ours) return {};
  const BuildingLine& ours = table.lines.back();
  std::vector<BuildingFigures> means;
  for (const BuildingLine* line : lines) means.push_back(mean_of(*line));
  const std::size_t best = best_for(table.objective, table.zones, means);
  std::vector<double> value, more_outside;
  for (std::size_t i = 0; i < ours.runs.size(); ++i) {
    const BuildingFigures &a = ours.runs[i], &b = lines[best]->runs[i];
    value.push_back(is_band(table) ? 100 * (a.total_kwh() / std::max(1e-9, b.total_kwh()) - 1)
                                   : a.dae_degc - b.dae_degc);
    more_outside.push_back(a.outside_degch() - b.outside_degch());
  }
  const double most = most_outside_degch(table.objective, table.zones, means);
  return BuildingVerdict{lines[best]->name, spread_of(value), spread_of(more_outside), outside(ours).mean <= most,
                         most};
}

std::string markdown_of(const BuildingTable& table) {
  std::string by_meter, rule;
  for (const std::string& meter : table.meters) {
    by_meter += meter + " | ";
    rule += "---|";
  }
  std::string text = fmt::format("#### {}, from {}\n\n", building_of(table), table.start);
  text += fmt::format(
      "| method | kWh a day | {}above | below | DAE, °C | DARV, K | setpoint, °C |\n|---|---|{}---|---|---|---|---|\n",
      by_meter, rule);
  for (const BuildingLine& line : table.lines) text += line_text(table, line);
  if (!verdict_on(table, Rivals::simple)) return text + "\n";
  return text + fmt::format("\n- Ours less the best simple method:\n  {}.\n- Ours less the best of all:\n  {}.\n\n",
                            verdict_text(table, Rivals::simple), verdict_text(table, Rivals::all));
}

std::string summary_of(const std::vector<BuildingTable>& tables) {
  std::string text =
      "| building, from | ours | own control | ours less the best simple method | ours less the best of all "
      "|\n|---|---|---|---|---|\n";
  for (const BuildingTable& table : tables) {
    std::string own = "-";
    for (const BuildingLine& line : table.lines) {
      if (line.method.kind == Kind::own) own = cell(table, line);
    }
    text += fmt::format("| {}, {} | {} | {} | {} | {} |\n", building_of(table), table.start,
                        cell(table, table.lines.back()), own, verdict_text(table, Rivals::simple),
                        verdict_text(table, Rivals::all));
  }
  return text;
}

}  // namespace airside::tools
