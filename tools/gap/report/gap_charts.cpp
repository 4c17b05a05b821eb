#include "tools/gap/report/gap_charts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "tools/report/charts/report_text.hpp"

namespace airside::tools {

namespace {

constexpr double map_width = 480, map_left = 92, row_height = 15, unit_gap = 7, head_height = 44;
constexpr double rank_width = 820, rank_least_left = 190, rank_most_left = 430, rank_line = 24, rank_top = 26;

/// About as many names as fit, the first always.
std::size_t name_every(std::size_t count, double cell, std::size_t letters) {
  const double need = 7.0 * static_cast<double>(letters) + 6;
  std::size_t every = 1;
  while (static_cast<double>(every) * cell < need && every < count) ++every;
  return every;
}

std::string cell_svg(const HeatMap& map, std::size_t row, std::size_t column, double x, double y, double cell) {
  const HeatRow& r = map.rows[row];
  const double v = map.values(static_cast<Eigen::Index>(row), static_cast<Eigen::Index>(column));
  const std::string where = fmt::format("{}, {}{}", r.name, map.columns[column], map.column_unit);
  std::string svg = fmt::format("<rect x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"", x + 0.5, y + 0.5,
                                cell - 1, row_height - 1);
  if (!std::isfinite(v)) {
    return svg + fmt::format(" class=\"none\"><title>{}: not measured</title></rect>", escape_markup(where));
  }
  const double depth = std::min(1.0, std::abs(v) / std::max(1e-9, map.full_colour.at(r.unit)));
  return svg + fmt::format(" class=\"{}\" fill-opacity=\"{:.2f}\"><title>{}: {} {}</title></rect>",
                           v < 0 ? "cold" : "hot", 0.04 + 0.96 * depth, escape_markup(where), number_text(v, 2),
                           escape_markup(r.unit));
}

/// As much of a name as stands left of the bars.
std::string fitting(const std::string& name) {
  constexpr std::size_t most_letters = 60;
  std::string whole = valid_utf8(name);
  if (whole.size() <= most_letters) return whole;
  std::size_t end = whole.rfind(' ', most_letters);
  if (end == std::string::npos) end = most_letters;
  return valid_utf8(whole.substr(0, end)) + " …";
}

}  // namespace

std::string heat_map_svg(const HeatMap& map) {
  const auto columns = static_cast<double>(std::max<std::size_t>(1, map.columns.size()));
  const double cell = (map_width - map_left - 4) / columns;
  std::size_t letters = 1;
  for (const std::string& name : map.columns) letters = std::max(letters, valid_utf8(name).size());
  const std::size_t every = name_every(map.columns.size(), cell, letters);
  std::string cells;
  double y = head_height;
  for (std::size_t row = 0; row < map.rows.size(); ++row) {
    if (row > 0 && map.rows[row].unit != map.rows[row - 1].unit) y += unit_gap;
    cells += fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>", map_left - 6,
                         y + row_height / 2 + 4, escape_markup(map.rows[row].name));
    for (std::size_t c = 0; c < map.columns.size(); ++c) {
      cells += cell_svg(map, row, c, map_left + cell * static_cast<double>(c), y, cell);
    }
    cells += '\n';
    y += row_height;
  }
  std::string svg = fmt::format(
      "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {:.0f}\" role=\"img\" aria-label=\"{}\">\n"
      "<text class=\"head\" x=\"{}\" y=\"14\">{}</text>\n",
      map_width, y + 4, escape_markup(map.title), map_left, escape_markup(map.title));
  for (std::size_t c = 0; c < map.columns.size(); c += every) {
    svg +=
        fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>",
                    map_left + cell * (static_cast<double>(c) + 0.5), head_height - 6, escape_markup(map.columns[c]));
  }
  if (map.marked_from && *map.marked_from < map.columns.size()) {
    const double x = map_left + cell * static_cast<double>(*map.marked_from);
    svg += fmt::format("<line class=\"mark\" x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{}\" y2=\"{}\"/>", x + 1, map_width - 5,
                       head_height - 19, head_height - 19);
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"end\">{}</text>", map_width - 5, head_height - 24,
                       escape_markup(map.mark));
  }
  return svg + "\n" + cells + "</svg>\n";
}

std::string rank_svg(const std::vector<RankBar>& bars, const std::string& limit_name) {
  std::size_t letters = 0;
  for (const RankBar& bar : bars) letters = std::max(letters, valid_utf8(bar.name).size());
  const double rank_left = std::clamp(18 + 6.9 * static_cast<double>(letters), rank_least_left, rank_most_left);
  double most = 0;
  for (const RankBar& bar : bars) most = std::max({most, std::isfinite(bar.value) ? bar.value : 0, bar.limit});
  const double per_gain = (rank_width - rank_left - 80) / std::max(1e-9, most);
  const double bottom = rank_top + rank_line * static_cast<double>(bars.size());
  std::string svg = fmt::format(
      "<svg class=\"rank\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {:.0f}\" role=\"img\" "
      "aria-label=\"{}\">\n",
      rank_width, bottom + 6, escape_markup("gains against " + limit_name));
  double y = rank_top;
  for (const RankBar& bar : bars) {
    const double length = std::isfinite(bar.value) ? std::max(0.0, bar.value) * per_gain : 0;
    const double limit = bar.limit * per_gain;
    svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.1f}\" text-anchor=\"end\" style=\"font-size:13px\">{}</text>",
                       rank_left - 10, y + rank_line / 2 + 4, escape_markup(fitting(bar.name)));
    svg += fmt::format("<rect class=\"{}\" x=\"{}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{}\"/>",
                       bar.found ? "found" : "other", rank_left, y + 4, std::max(1.0, length), rank_line - 8);
    svg += fmt::format("<line class=\"limit\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1:.1f}\" y2=\"{2:.1f}\"/>",
                       rank_left + limit, y + 1, y + rank_line - 1);
    // A number right of its bar, and of the limit where that would cross it.
    const double end = limit > length && limit < length + 50 ? limit : length;
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" style=\"font-size:13px\">{}</text>\n", rank_left + end + 7,
                       y + rank_line / 2 + 4, number_text(bar.value, bar.value < 10 ? 1 : 0));
    y += rank_line;
  }
  svg += fmt::format("<line class=\"limit\" x1=\"{0}\" x2=\"{0}\" y1=\"{1}\" y2=\"{2}\"/>", rank_left, rank_top - 18,
                     rank_top - 4);
  svg += fmt::format("<text x=\"{}\" y=\"{}\" style=\"font-size:13px\">{}</text>", rank_left + 8, rank_top - 7,
                     escape_markup(limit_name));
  return svg + "\n</svg>\n";
}

}  // namespace airside::tools
