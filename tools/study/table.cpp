#include "tools/study/table.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <limits>

#include "tools/run/metrics.hpp"
#include "tools/study/control_methods.hpp"

namespace airside::tools {
namespace {

/// A figure with a mean and a spread: a column of the table.
struct FigureColumn {
  const char* figure;
  const char* title;
  int decimals;
};
constexpr std::array<FigureColumn, 9> figure_columns = {{
    {"dae_degc", "DAE °C", 3},
    {"me_degc", "ME °C", 3},
    {"day1_dae_degc", "day 1 °C", 3},
    {"darv_degc", "DARV °C", 3},
    {"cdh_degch", "CDH °C h", 0},
    {"hdh_degch", "HDH °C h", 1},
    {"degree_hours_per_day_degch", "degree-hours/day", 2},
    {"degree_hours_above_per_day_degch", "above target/day", 2},
    {"hvac_kwh_per_day", "kWh/day", 0},
}};
constexpr std::array<const char*, 2> figure_ratios = {"dae", "darv"};

std::string ratio_key(const std::string& ratio, const std::string& floor) { return ratio + "_over_" + floor; }

}  // namespace

std::vector<std::string> study_methods(bool energyplus) {
  std::vector<std::string> methods = {"expert",         "constant-20.5", "constant-22.5",  "pid-tuned",
                                      "integral-tuned", "integral-5",    "integral-7",     "arx-2",
                                      "arx-rls",        "mpc",           "g36-written-16", "g36-written-18",
                                      "g36-site-i2",    "g36-site-i1",   "g36-site-i0"};
  for (const std::string& floor : floor_names(energyplus)) methods.push_back(floor);
  return methods;
}

std::optional<WorseDays> worse_days(const std::vector<Outcome>& outcomes, const std::string& method,
                                    const std::string& peer, double margin_degc) {
  WorseDays found;
  found.worst_degc = -std::numeric_limits<double>::infinity();
  for (const Outcome& o : outcomes) {
    if (!o.contains(method) || !o.contains(peer)) continue;
    const auto ours = o.at(method).at("daily_dae_degc").get<std::vector<double>>();
    const auto theirs = o.at(peer).at("daily_dae_degc").get<std::vector<double>>();
    for (std::size_t d = 0; d < std::min(ours.size(), theirs.size()); ++d) {
      const double difference = ours[d] - theirs[d];
      ++found.days;
      if (difference > margin_degc) ++found.worse;
      found.worst_degc = std::max(found.worst_degc, difference);
    }
  }
  if (found.days == 0) return std::nullopt;
  return found;
}

nlohmann::json study_figures(const std::vector<Outcome>& outcomes, const std::string& name, const std::string& floor) {
  nlohmann::json m;
  for (const FigureColumn& column : figure_columns) {
    std::vector<double> values;
    for (const Outcome& o : outcomes) {
      if (!o.contains(name)) continue;
      if (const auto& value = o.at(name).at(column.figure); value.is_number()) values.push_back(value);
    }
    const Spread s = spread_of(values);
    m[column.figure] = {{"mean", s.mean}, {"sd", s.sd}, {"count", s.count}};
  }
  for (const std::string ratio : figure_ratios) {
    const std::string figure = ratio + "_degc";
    double sum = 0;
    int count = 0;
    for (const Outcome& o : outcomes) {
      if (!o.contains(name) || !o.contains(floor)) continue;
      sum += o.at(name).at(figure).get<double>() / o.at(floor).at(figure).get<double>();
      ++count;
    }
    if (count > 0) m[ratio_key(ratio, floor)] = sum / count;
  }
  return m;
}

std::string study_markdown(const nlohmann::json& methods, const std::vector<std::string>& order,
                           const std::string& floor) {
  std::vector<std::vector<std::string>> lines(1, {"method"});
  for (const FigureColumn& column : figure_columns) lines[0].emplace_back(column.title);
  lines[0].emplace_back("DAE / floor");
  lines[0].emplace_back("DARV / floor");
  for (const std::string& name : order) {
    const nlohmann::json& m = methods.at(name);
    std::vector<std::string> line = {name};
    for (const FigureColumn& column : figure_columns) {
      const nlohmann::json& spread = m.at(column.figure);
      const std::string mean = fmt::format("{:.{}f}", spread.at("mean").get<double>(), column.decimals);
      const bool has_spread = spread.at("count").get<int>() > 1;
      line.push_back(has_spread ? fmt::format("{} ± {:.{}f}", mean, spread.at("sd").get<double>(), column.decimals)
                                : mean);
    }
    for (const char* ratio : figure_ratios) {
      const std::string key = ratio_key(ratio, floor);
      line.push_back(m.contains(key) ? fmt::format("{:.2f}", m.at(key).get<double>()) : "-");
    }
    lines.push_back(std::move(line));
  }
  return markdown_of(lines);
}

std::string markdown_of(const std::vector<std::vector<std::string>>& lines) {
  std::vector<std::size_t> widths(lines.front().size());
  const auto characters = [](const std::string& cell) {
    // Not bytes: UTF-8's further bytes are 10xxxxxx.
    return static_cast<std::size_t>(std::ranges::count_if(cell, [](char b) { return (b & 0xC0) != 0x80; }));
  };
  for (const auto& line : lines) {
    for (std::size_t c = 0; c < line.size(); ++c) widths[c] = std::max(widths[c], characters(line[c]));
  }
  std::string text;
  for (std::size_t l = 0; l < lines.size(); ++l) {
    for (std::size_t c = 0; c < widths.size(); ++c)
      text += "| " + lines[l][c] + std::string(widths[c] - characters(lines[l][c]) + 1, ' ');
    text += "|\n";
    if (l > 0) continue;
    for (const std::size_t width : widths) text += "|" + std::string(width + 2, '-');
    text += "|\n";
  }
  return text;
}

}  // namespace airside::tools
