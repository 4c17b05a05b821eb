#include "tools/report/charts/svg_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "hal/text/civil_text.hpp"
#include "tools/report/charts/report_text.hpp"

namespace airside::tools {
namespace {

constexpr double width = 960, left_px = 62, right_px = 14;
constexpr double plot_width = width - left_px - right_px;

constexpr const char* own_colours = R"(<style>
text{font-family:system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans",sans-serif;font-size:12px;fill:#3d4754}
.title{font-size:16px;font-weight:600;fill:#161c24}.paper{fill:#fff}
.grid{stroke:#e3e7ec;stroke-width:1}.axis{stroke:#8a94a0;stroke-width:1}.band{fill:#0b62b4;opacity:.06}
.line{fill:none;stroke-width:1.5;stroke-linejoin:round}.line.main{stroke-width:2.6}.line.muted{stroke-width:1;opacity:.6}
.line.ref{stroke-dasharray:6 4}.bar.ref{opacity:.75}.whisker{stroke:#161c24;stroke-width:1}.cut{fill:#fff}
.main{--c:#0b62b4}.ref{--c:#6b7684}.c0{--c:#d1570f}.c1{--c:#0b8f6a}.c2{--c:#b8478f}.c3{--c:#a97a00}.c4{--c:#3aa0d8}
.c5{--c:#7a5cc7}.c6{--c:#8c5a3c}.c7{--c:#5b8c2a}.line{stroke:var(--c)}.bar,.key{fill:var(--c)}
</style>
<rect class="paper" width="100%" height="100%"/>
)";

struct Colour {
  std::string name;
  bool muted = false;
  std::string classes() const { return muted ? name + " muted" : name; }
};

template <class List>
std::vector<Colour> colours_of(const List& list) {
  std::vector<Colour> colours;
  std::size_t next = 0;
  for (const auto& item : list) {
    const bool own = item.role == SeriesRole::main || item.role == SeriesRole::reference;
    colours.push_back({colour_class(item.role, next), item.role == SeriesRole::muted});
    if (!own) ++next;
  }
  return colours;
}

std::string open_svg(const std::string& title, double height, SvgUse use) {
  std::string svg =
      fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\"",
                  width, height, escape_markup(title));
  if (use == SvgUse::in_page) return svg + ">\n";
  svg += fmt::format(" width=\"{}\" height=\"{}\">\n{}", width, height, own_colours);
  return svg + fmt::format("<text class=\"title\" x=\"{}\" y=\"24\">{}</text>\n", left_px, escape_markup(title));
}

/// A row of keys; wraps, and returns how many lines it took.
template <class List>
int legend(std::string& svg, const List& list, const std::vector<Colour>& colours, double y) {
  double x = left_px;
  int lines = 1;
  for (std::size_t i = 0; i < list.size(); ++i) {
    const double advance = 34 + 7.2 * static_cast<double>(valid_utf8(list[i].name).size());
    if (x > left_px && x + advance > width - right_px) {
      x = left_px;
      ++lines;
    }
    const double base = y + 17 * (lines - 1);
    svg += fmt::format("<rect class=\"key {}\" x=\"{:.0f}\" y=\"{:.0f}\" width=\"12\" height=\"{}\"/>",
                       colours[i].classes(), x, base - 8, colours[i].muted ? 3 : 8);
    svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\">{}</text>\n", x + 17, base, escape_markup(list[i].name));
    x += advance;
  }
  return lines;
}

struct Axis {
  double low = 0, high = 1;
  bool log = false;
  double place(double v) const {
    const double t =
        log ? (std::log10(v) - std::log10(low)) / (std::log10(high) - std::log10(low)) : (v - low) / (high - low);
    return std::clamp(t, -0.5, 1.5);
  }
  bool shows(double v) const { return std::isfinite(v) && (!log || v > 0); }
};

Axis y_axis_of(const LineChart& chart) {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  Axis axis{0, 1, chart.log_axis};
  for (const ChartSeries& s : chart.series) {
    for (const double v : s.y) {
      if (!axis.shows(v)) continue;
      low = std::min(low, v);
      high = std::max(high, v);
    }
  }
  if (!chart.y_names.empty()) {
    return {-0.3, static_cast<double>(chart.y_names.size()) - (chart.raised.empty() ? 0.7 : 0.1), false};
  }
  if (chart.y_min) low = std::min(low, *chart.y_min);
  if (chart.y_max) high = std::max(high, *chart.y_max);
  if (!(low <= high)) return Axis{chart.log_axis ? 0.1 : 0.0, 1, chart.log_axis};
  if (axis.log) {
    axis.low = std::pow(10, std::floor(std::log10(low)));
    axis.high = std::pow(10, std::ceil(std::log10(high) + 1e-9));
    return axis;
  }
  const double pad = high > low ? 0.06 * (high - low) : 0.5;
  axis.low = chart.y_min && low >= *chart.y_min ? *chart.y_min : low - pad;
  axis.high = high + pad;
  return axis;
}

/// `names`: of y = 0, 1, ..; none: numbers.
void y_grid(std::string& svg, const Axis& axis, const std::string& unit, double top, double bottom,
            const std::vector<std::string>& names = {}) {
  std::vector<double> ticks;
  if (!names.empty()) {
    for (std::size_t i = 0; i < names.size(); ++i) ticks.push_back(static_cast<double>(i));
  } else if (axis.log) {
    double v = axis.low;
    while (v <= axis.high * 1.0001) {
      ticks.push_back(v);
      v *= 10;
    }
  } else {
    ticks = round_ticks(axis.low, axis.high, 6);
  }
  const double step = ticks.size() > 1 ? ticks[1] - ticks[0] : 1;
  for (const double v : ticks) {
    const double y = bottom - axis.place(v) * (bottom - top);
    svg += fmt::format("<line class=\"grid\" x1=\"{}\" x2=\"{}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/>", left_px,
                       width - right_px, y, y);
    svg += fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n", left_px - 7, y + 4,
                       !names.empty() ? escape_markup(names[static_cast<std::size_t>(v)])
                       : axis.log     ? fmt::format("{:g}", v)
                                      : tick_text(v, step));
  }
  svg += fmt::format("<text transform=\"translate(15 {:.0f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                     (top + bottom) / 2, escape_markup(unit));
}

void time_ticks(std::string& svg, const Axis& x_axis, double top, double bottom) {
  const double span_s = x_axis.high - x_axis.low;
  double step_s = 86400;
  for (const double s :
       {600.0, 1800.0, 3600.0, 7200.0, 10800.0, 21600.0, 43200.0, 86400.0, 172800.0, 604800.0, 2592000.0, 7776000.0}) {
    step_s = s;
    if (span_s / s <= 15) break;
  }
  const auto step = static_cast<std::int64_t>(step_s);
  const auto last = static_cast<std::int64_t>(std::floor(x_axis.high));
  for (std::int64_t t = static_cast<std::int64_t>(std::ceil(x_axis.low / step_s)) * step; t <= last; t += step) {
    const double x = left_px + x_axis.place(static_cast<double>(t)) * plot_width;
    const std::string text = hal::civil_text(CivilTime{t});
    const bool midnight = CivilTime{t}.second_of_day() == 0;
    svg += fmt::format("<line class=\"grid\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\"/>", x, top, bottom);
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n", x, bottom + 17,
                       midnight ? day_text(CivilTime{t}) : text.substr(11, 5));
  }
}

std::string path_of(const LineChart& chart, const ChartSeries& s, const Axis& x_axis, const Axis& y_axis, double top,
                    double bottom) {
  std::string path;
  bool pen_down = false;
  const bool level = s.y.size() == 1;
  const std::size_t n = level ? std::min<std::size_t>(2, chart.x.size()) : chart.x.size();
  for (std::size_t i = 0; i < n; ++i) {
    const double v = level ? s.y[0] : s.y[i];
    if (!y_axis.shows(v)) {
      pen_down = false;
      continue;
    }
    const double at = level && i == 1 ? chart.x.back() : chart.x[i];
    const double x = left_px + x_axis.place(at) * plot_width;
    const double y = bottom - y_axis.place(v) * (bottom - top);
    if (pen_down && s.stepped) path += fmt::format("H{:.1f}", x);
    path += fmt::format("{}{:.1f} {:.1f}", pen_down ? "L" : "M", x, y);
    pen_down = true;
  }
  return path;
}

/// The largest value the axis must show: without a group that towers above the rest.
double bar_top(const BarChart& chart) {
  std::vector<double> tops;
  for (const BarGroup& g : chart.groups) {
    double top = 0;
    for (const double v : g.y) top = std::isfinite(v) ? std::max(top, v) : top;
    if (top > 0) tops.push_back(top);
  }
  if (tops.empty()) return 1;
  std::sort(tops.begin(), tops.end());
  for (std::size_t i = 1; i < tops.size(); ++i) {
    if (tops[i] > 3 * tops[i - 1] && 2 * i >= tops.size()) return tops[i - 1] * 1.2;
  }
  return tops.back() * 1.06;
}

}  // namespace

std::string colour_class(SeriesRole role, std::size_t index_of_plain) {
  if (role == SeriesRole::main) return "main";
  if (role == SeriesRole::reference) return "ref";
  return fmt::format("c{}", index_of_plain % 8);
}

std::string line_chart_svg(const LineChart& chart, SvgUse use) {
  const auto colours = colours_of(chart.series);
  std::string keys;
  const double key_y = use == SvgUse::own_file ? 46 : 14;
  const double top = key_y + 17.0 * legend(keys, chart.series, colours, key_y) - 4;
  const double bottom = top + 290, height = bottom + 44;
  Axis x_axis{0, 1, false};
  if (!chart.x.empty()) x_axis = {chart.x.front(), chart.x.back(), false};
  if (!(x_axis.high > x_axis.low)) x_axis.high = x_axis.low + 1;
  const Axis y_axis = y_axis_of(chart);

  std::string svg = open_svg(chart.title, height, use) + keys;
  svg += fmt::format("<clipPath id=\"plot\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/></clipPath>\n", left_px,
                     top, plot_width, bottom - top);
  svg += "<g clip-path=\"url(#plot)\">\n";
  for (const ChartBand& b : chart.bands) {
    const double x0 = x_axis.place(b.from), x1 = x_axis.place(b.to);
    svg += fmt::format("<rect class=\"band\" x=\"{:.1f}\" y=\"{}\" width=\"{:.1f}\" height=\"{}\"/>\n",
                       left_px + x0 * plot_width, top, std::max(0.0, x1 - x0) * plot_width, bottom - top);
  }
  svg += "</g>\n";
  y_grid(svg, y_axis, chart.unit, top, bottom, chart.y_names);
  if (chart.x_is_time) {
    time_ticks(svg, x_axis, top, bottom);
  } else {
    const auto ticks = round_ticks(x_axis.low, x_axis.high, 8);
    for (const double v : ticks) {
      svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n",
                         left_px + x_axis.place(v) * plot_width, bottom + 17,
                         tick_text(v, ticks.size() > 1 ? ticks[1] - ticks[0] : 1));
    }
  }
  svg += fmt::format("<text x=\"{:.0f}\" y=\"{}\" text-anchor=\"middle\">{}{}</text>\n", left_px + plot_width / 2,
                     bottom + 36, escape_markup(chart.x_is_time ? "local time" : chart.x_label),
                     chart.band_name.empty() ? "" : escape_markup("; shaded: " + chart.band_name));
  svg +=
      fmt::format("<line class=\"axis\" x1=\"{0}\" x2=\"{1}\" y1=\"{2}\" y2=\"{2}\"/>\n<g clip-path=\"url(#plot)\">\n",
                  left_px, width - right_px, bottom);
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    svg += fmt::format("<path class=\"line {}\" d=\"{}\"/>\n", colours[i].classes(),
                       path_of(chart, chart.series[i], x_axis, y_axis, top, bottom));
  }
  return svg + "</g>\n</svg>\n";
}

std::string bar_chart_svg(const BarChart& chart, SvgUse use) {
  const auto colours = colours_of(chart.groups);
  std::string keys;
  double top = 14;
  if (use == SvgUse::own_file) top = 46 + 17.0 * legend(keys, chart.groups, colours, 46) + 4;
  const double bottom = top + 290, height = bottom + 26;
  const Axis axis{0, bar_top(chart), false};
  std::string svg = open_svg(chart.title, height, use) + keys;
  y_grid(svg, axis, chart.unit, top, bottom);

  const double slot = plot_width / static_cast<double>(std::max<std::size_t>(1, chart.categories.size()));
  const double gap = std::min(14.0, slot * 0.22);
  const double bar = std::min(26.0, (slot - gap) / static_cast<double>(std::max<std::size_t>(1, chart.groups.size())));
  const double used = bar * static_cast<double>(chart.groups.size());
  for (std::size_t c = 0; c < chart.categories.size(); ++c) {
    const double middle = left_px + slot * (static_cast<double>(c) + 0.5);
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n", middle, bottom + 17,
                       escape_markup(chart.categories[c]));
    for (std::size_t g = 0; g < chart.groups.size(); ++g) {
      const BarGroup& group = chart.groups[g];
      const double v = group.y[c];
      if (!std::isfinite(v) || v < 0) continue;
      const bool cut = v > axis.high;
      const double x = middle - used / 2 + bar * static_cast<double>(g);
      const double h = std::min(v / axis.high, 1.0) * (bottom - top);
      svg += fmt::format(
          "<g class=\"g{}\"><rect class=\"bar {}\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\">", g,
          colours[g].classes(), x, bottom - h, std::max(1.0, bar - std::min(1.0, bar * 0.15)), h);
      const bool spread = c < group.spread.size() && std::isfinite(group.spread[c]) && group.spread[c] > 0;
      svg += fmt::format("<title>{}, {}: {}{} {}</title></rect>", escape_markup(group.name),
                         escape_markup(chart.categories[c]), number_text(v, chart.decimals),
                         spread ? " ± " + number_text(group.spread[c], chart.decimals) : "", escape_markup(chart.unit));
      if (cut) {  // a slanted gap says that the bar goes on
        svg += fmt::format("<path class=\"cut\" d=\"M{0:.1f} {1:.1f}l{2:.1f} -6v5l-{2:.1f} 6z\"/>", x - 1, top + 16,
                           bar + 2);
        if (bar >= 22 || chart.groups.size() * chart.categories.size() <= 40) {
          svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>", x + bar / 2, top - 3,
                             number_text(v, chart.decimals));
        }
      } else if (spread) {
        const double up = std::min((v + group.spread[c]) / axis.high, 1.0) * (bottom - top);
        const double down = std::max(v - group.spread[c], 0.0) / axis.high * (bottom - top);
        svg += fmt::format("<line class=\"whisker\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1:.1f}\" y2=\"{2:.1f}\"/>",
                           x + bar / 2, bottom - up, bottom - down);
      }
      svg += "</g>\n";
    }
  }
  svg += fmt::format("<line class=\"axis\" x1=\"{0}\" x2=\"{1}\" y1=\"{2}\" y2=\"{2}\"/>\n</svg>\n", left_px,
                     width - right_px, bottom);
  return svg;
}

}  // namespace airside::tools
