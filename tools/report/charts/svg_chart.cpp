#include "tools/report/charts/svg_chart.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "hal/text/civil_text.hpp"
#include "tools/report/charts/report_text.hpp"
#include "tools/report/charts/series_look.hpp"

namespace airside::tools {
namespace {

constexpr double width = 960, left_px = 62, right_px = 14;

/// Where the curves are, px.
struct Frame {
  double left = left_px, top = 0, bottom = 0;
  double wide() const { return width - left - right_px; }
  double x(double share) const { return left + share * wide(); }
};

/// Names stand left of the curves, whole.
double left_of(const std::vector<std::string>& names) {
  std::size_t longest = 0;
  for (const std::string& name : names) longest = std::max(longest, valid_utf8(name).size());
  return std::clamp(16 + 6.8 * static_cast<double>(longest), left_px, 260.0);
}

std::string classes_of(const SeriesLook& look) { return look.muted ? look.colour + " muted" : look.colour; }

std::string open_svg(const std::string& title, double height, SvgUse use) {
  std::string svg =
      fmt::format("<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {} {}\" role=\"img\" aria-label=\"{}\"",
                  width, height, escape_markup(title));
  if (use == SvgUse::in_page) return svg + ">\n";
  svg += fmt::format(" width=\"{}\" height=\"{}\">\n{}", width, height, own_style);
  return svg + fmt::format("<text class=\"title\" x=\"{}\" y=\"24\">{}</text>\n", left_px, escape_markup(title));
}

/// The edge at the top of a stretch, px: the less the controller has the say, the thicker. As band_edge of
/// chart_parts.js.
double edge_of(const std::string& kind) {
  return kind == "release" ? 10 : kind == "expert" ? 6 : kind == "run" ? 3 : 2;
}

/// A row of keys that wraps.
class Legend {
 public:
  Legend(std::string& svg, double y) : svg_(svg), y_(y) {}
  double height() const { return 17.0 * lines_; }

  void add_lines(const std::vector<SeriesLook>& looks) {
    for (const SeriesLook& look : looks) {
      const auto [x, y] = place(40, look.name);
      svg_ +=
          fmt::format("<path class=\"dash {} {}\" d=\"M{:.0f} {:.0f}h30\"/>", classes_of(look), look.dash, x, y - 4);
      name(x + 35, y, look.name);
    }
  }
  void add_bars(const std::vector<SeriesLook>& looks) {
    for (const SeriesLook& look : looks) {
      const auto [x, y] = place(17, look.name);
      svg_ += fmt::format("<rect class=\"key {}\" x=\"{:.0f}\" y=\"{:.0f}\" width=\"12\" height=\"{}\"/>",
                          classes_of(look), x, y - 8, look.muted ? 3 : 8);
      name(x + 17, y, look.name);
    }
  }
  void add_stretches(const std::vector<ChartStretch>& kinds) {
    for (const ChartStretch& kind : kinds) {
      const auto [x, y] = place(24, kind.name);
      for (const auto& [cls, high] : {std::pair{"stretch ", 14.0}, {"", edge_of(kind.kind) / 2}}) {
        svg_ += fmt::format("<rect class=\"{}{}\" x=\"{:.0f}\" y=\"{:.0f}\" width=\"18\" height=\"{}\"/>", cls,
                            kind.kind, x, y - 11, high);
      }
      name(x + 23, y, kind.name);
    }
  }

 private:
  std::pair<double, double> place(double mark, const std::string& text) {
    const double advance = mark + 17 + 7.2 * static_cast<double>(valid_utf8(text).size());
    if (x_ > left_px && x_ + advance > width - right_px) {
      x_ = left_px;
      ++lines_;
    }
    const double x = x_;
    x_ += advance;
    return {x, y_ + 17 * (lines_ - 1)};
  }
  void name(double x, double y, const std::string& text) {
    svg_ += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\">{}</text>\n", x, y, escape_markup(text));
  }

  std::string& svg_;
  double y_, x_ = left_px;
  int lines_ = 1;
};

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
void y_grid(std::string& svg, const Axis& axis, const std::string& unit, const Frame& frame,
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
    const double y = frame.bottom - axis.place(v) * (frame.bottom - frame.top);
    svg += fmt::format("<line class=\"grid\" x1=\"{}\" x2=\"{}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/>", frame.left,
                       width - right_px, y, y);
    svg += fmt::format("<text x=\"{}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n", frame.left - 7, y + 4,
                       !names.empty() ? escape_markup(names[static_cast<std::size_t>(v)])
                       : axis.log     ? fmt::format("{:g}", v)
                                      : tick_text(v, step));
  }
  svg += fmt::format("<text transform=\"translate(15 {:.0f}) rotate(-90)\" text-anchor=\"middle\">{}</text>\n",
                     (frame.top + frame.bottom) / 2, escape_markup(unit));
}

void time_ticks(std::string& svg, const Axis& x_axis, const Frame& frame) {
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
    const double x = frame.x(x_axis.place(static_cast<double>(t)));
    const std::string text = hal::civil_text(CivilTime{t});
    const bool midnight = CivilTime{t}.second_of_day() == 0;
    svg += fmt::format("<line class=\"grid\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1}\" y2=\"{2}\"/>", x, frame.top,
                       frame.bottom);
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n", x, frame.bottom + 17,
                       midnight ? day_text(CivilTime{t}) : text.substr(11, 5));
  }
}

std::string path_of(const LineChart& chart, const ChartSeries& s, const Axis& x_axis, const Axis& y_axis,
                    const Frame& frame) {
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
    const double x = frame.x(x_axis.place(at));
    const double y = frame.bottom - y_axis.place(v) * (frame.bottom - frame.top);
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

std::string line_chart_svg(const LineChart& chart, SvgUse use) {
  const auto looks = looks_of(chart);
  std::string keys;
  Legend legend(keys, use == SvgUse::own_file ? 46 : 14);
  legend.add_lines(looks);
  legend.add_stretches(kinds_of(chart.stretches));
  Frame frame{left_of(chart.y_names), (use == SvgUse::own_file ? 46 : 14) + legend.height() - 4};
  frame.bottom = frame.top + 290;
  const double high = frame.bottom - frame.top;
  Axis x_axis{0, 1, false};
  if (!chart.x.empty()) x_axis = {chart.x.front(), chart.x.back(), false};
  if (!(x_axis.high > x_axis.low)) x_axis.high = x_axis.low + 1;
  const Axis y_axis = y_axis_of(chart);

  std::string svg = open_svg(chart.title, frame.bottom + 44, use) + keys;
  svg += fmt::format("<clipPath id=\"plot\"><rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\"/></clipPath>\n",
                     frame.left, frame.top, frame.wide(), high);
  svg += "<g clip-path=\"url(#plot)\">\n";
  const auto shade = [&](const std::string& classes, double from, double to, double height, const std::string& said) {
    const double x0 = frame.x(x_axis.place(from)), x1 = frame.x(x_axis.place(to));
    svg += fmt::format("<rect class=\"{}\" x=\"{:.1f}\" y=\"{}\" width=\"{:.1f}\" height=\"{}\">{}</rect>\n", classes,
                       x0, frame.top, std::max(0.0, x1 - x0), height, said);
  };
  for (const ChartBand& b : chart.bands) shade("band", b.from, b.to, high, "");
  for (const ChartStretch& s : chart.stretches) {
    const std::string why = s.why.empty() ? "" : ": " + s.why;
    shade("stretch " + s.kind, s.from, s.to, high, "<title>" + escape_markup(s.name + why) + "</title>");
    shade(s.kind, s.from, s.to, edge_of(s.kind), "");
  }
  svg += "</g>\n";
  y_grid(svg, y_axis, chart.unit, frame, chart.y_names);
  if (chart.x_is_time) {
    time_ticks(svg, x_axis, frame);
  } else {
    const auto ticks = round_ticks(x_axis.low, x_axis.high, 8);
    for (const double v : ticks) {
      svg += fmt::format("<text x=\"{:.1f}\" y=\"{}\" text-anchor=\"middle\">{}</text>\n", frame.x(x_axis.place(v)),
                         frame.bottom + 17, tick_text(v, ticks.size() > 1 ? ticks[1] - ticks[0] : 1));
    }
  }
  svg += fmt::format("<text x=\"{:.0f}\" y=\"{}\" text-anchor=\"middle\">{}{}</text>\n", frame.x(0.5),
                     frame.bottom + 36, escape_markup(chart.x_is_time ? "local time" : chart.x_label),
                     chart.band_name.empty() ? "" : escape_markup("; shaded: " + chart.band_name));
  svg +=
      fmt::format("<line class=\"axis\" x1=\"{0}\" x2=\"{1}\" y1=\"{2}\" y2=\"{2}\"/>\n<g clip-path=\"url(#plot)\">\n",
                  frame.left, width - right_px, frame.bottom);
  for (std::size_t i = 0; i < chart.series.size(); ++i) {
    svg += fmt::format("<path class=\"line {} {}\" d=\"{}\"/>\n", classes_of(looks[i]), looks[i].dash,
                       path_of(chart, chart.series[i], x_axis, y_axis, frame));
  }
  return svg + "</g>\n</svg>\n";
}

std::string bar_chart_svg(const BarChart& chart, SvgUse use) {
  const auto looks = looks_of(chart);
  std::string keys;
  Frame frame{left_px, 14};
  if (use == SvgUse::own_file) {
    Legend legend(keys, 46);
    legend.add_bars(looks);
    frame.top = 46 + legend.height() + 4;
  }
  frame.bottom = frame.top + 290;
  const double top = frame.top, bottom = frame.bottom, height = bottom + 26;
  const Axis axis{0, bar_top(chart), false};
  std::string svg = open_svg(chart.title, height, use) + keys;
  y_grid(svg, axis, chart.unit, frame);

  const double slot = frame.wide() / static_cast<double>(std::max<std::size_t>(1, chart.categories.size()));
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
          classes_of(looks[g]), x, bottom - h, std::max(1.0, bar - std::min(1.0, bar * 0.15)), h);
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
