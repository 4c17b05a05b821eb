#include "tools/gap/report/reliability_svg.hpp"

#include <fmt/format.h>

#include "tools/gap/score/wilson.hpp"
#include "tools/report/charts/report_text.hpp"

namespace airside::tools::gap {

namespace {

constexpr double plot_width = 420, plot_height = 460, plot_left = 64, plot_top = 56, plot_side = 320;

constexpr const char* reliability_style = R"(<style>
.rl text{font-family:system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans",sans-serif;font-size:12px;fill:#3d4754}
.rl .title{font-size:16px;font-weight:600;fill:#161c24}.rl .axis{font-weight:600}.rl .paper{fill:#fff}
.rl .grid{stroke:#e3e8ee}.rl .diagonal{stroke:#56616e;stroke-dasharray:5 4}
.rl .honest{stroke:#0b62b4;fill:#0b62b4}.rl .off{stroke:#d1570f;fill:#d1570f}.rl .bar{stroke-width:2}
</style>
<rect class="paper" width="100%" height="100%"/>
)";

double plot_x(double share) { return plot_left + plot_side * share; }
double plot_y(double share) { return plot_top + plot_side * (1 - share); }

std::string reliability_axes() {
  std::string svg;
  for (int tenth = 0; tenth <= 10; tenth += 2) {
    const double share = tenth / 10.0;
    svg += fmt::format(
        "<line class=\"grid\" x1=\"{0:.1f}\" x2=\"{0:.1f}\" y1=\"{1:.1f}\" y2=\"{2:.1f}\"/>"
        "<line class=\"grid\" x1=\"{3:.1f}\" x2=\"{4:.1f}\" y1=\"{5:.1f}\" y2=\"{5:.1f}\"/>\n",
        plot_x(share), plot_y(0), plot_y(1), plot_x(0), plot_x(1), plot_y(share));
    svg += fmt::format(
        "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">{}</text>"
        "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n",
        plot_x(share), plot_y(0) + 18, 10 * tenth, plot_x(0) - 8, plot_y(share) + 4, 10 * tenth);
  }
  svg += fmt::format(
      "<line class=\"diagonal\" x1=\"{:.1f}\" y1=\"{:.1f}\" x2=\"{:.1f}\" y2=\"{:.1f}\"/>\n"
      "<text class=\"axis\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"middle\">probability of the likeliest, %</text>\n"
      "<text class=\"axis\" transform=\"translate(20 {:.1f}) rotate(-90)\" text-anchor=\"middle\">it was the truth, "
      "%</text>\n",
      plot_x(0), plot_y(0), plot_x(1), plot_y(1), plot_x(0.5), plot_y(0) + 40, plot_y(0.5));
  return svg;
}

std::string reliability_mark(const ReliabilityBin& bin) {
  const auto [low, high] = wilson_95(bin.came, bin.n);
  const double came = static_cast<double>(bin.came) / bin.n;
  const bool honest = low <= bin.said && bin.said <= high;
  const bool beside_right_edge = bin.said > 0.85;
  return fmt::format(
      "<g class=\"{}\"><title>said {:.0f} %, came {} of {}</title>"
      "<line class=\"bar\" x1=\"{:.1f}\" x2=\"{:.1f}\" y1=\"{:.1f}\" y2=\"{:.1f}\"/>"
      "<circle cx=\"{:.1f}\" cy=\"{:.1f}\" r=\"4\"/></g>"
      "<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"{}\">{}</text>\n",
      honest ? "honest" : "off", 100 * bin.said, bin.came, bin.n, plot_x(bin.said), plot_x(bin.said), plot_y(low),
      plot_y(high), plot_x(bin.said), plot_y(came), plot_x(bin.said) + (beside_right_edge ? -8 : 8), plot_y(came) + 14,
      beside_right_edge ? "end" : "start", bin.n);
}

}  // namespace

std::string reliability_svg(const std::vector<ReliabilityBin>& bins, const std::string& title) {
  std::string svg = fmt::format(
      "<svg class=\"rl\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\" role=\"img\" aria-label=\"{2}\">\n{3}"
      "<text class=\"title\" x=\"16\" y=\"28\">{2}</text>\n",
      plot_width, plot_height, escape_markup(title), reliability_style);
  svg += reliability_axes();
  for (const ReliabilityBin& bin : bins) {
    if (bin.n > 0) svg += reliability_mark(bin);
  }
  svg += fmt::format("<text x=\"16\" y=\"{:.0f}\">bars: 95 % of the share; numbers: explanations</text>\n",
                     plot_height - 14);
  return svg + "</svg>\n";
}

}  // namespace airside::tools::gap
