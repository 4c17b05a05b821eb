#include "tools/gap/report/confusion_svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "tools/report/charts/report_text.hpp"

namespace airside::tools::gap {
namespace {

constexpr double cell_width = 24, cell_height = 20, letter = 6.6, group_gap = 8, title_height = 40;
constexpr double lean = 60 * 3.14159265358979 / 180;  // of the column labels

constexpr const char* style = R"(<style>
.cm text{font-family:system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans",sans-serif;font-size:12px;fill:#3d4754}
.cm .title{font-size:16px;font-weight:600;fill:#161c24}.cm .axis{font-weight:600}.cm .paper{fill:#fff}
.cm .empty{fill:#f5f7f9}.cm .n{font-size:11px;text-anchor:middle}.cm .on-dark{fill:#fff}.cm .on-light{fill:#161c24}
.cm .right{stroke:#0b62b4;stroke-width:1.5}
</style>
<rect class="paper" width="100%" height="100%"/>
)";

using Rgb = std::array<double, 3>;
constexpr Rgb right_colour{11, 98, 180}, wrong_colour{209, 87, 15}, abstained_colour{86, 97, 110};

bool is_abstention(const std::string& said) {
  return said == "ambiguous" || said == "unknown" || said == "none" || said == "refused" || said == "no verdict";
}

/// White at 0; a single case of many must still show.
std::string shade(const Rgb& colour, double share) {
  const double depth = 0.14 + 0.86 * share;
  const auto mixed = [depth](double part) { return static_cast<int>(std::lround(255 + depth * (part - 255))); };
  return fmt::format("#{:02x}{:02x}{:02x}", mixed(colour[0]), mixed(colour[1]), mixed(colour[2]));
}

double longest(const std::vector<std::string>& names) {
  std::size_t most = 0;
  for (const std::string& name : names) most = std::max(most, valid_utf8(name).size());
  return letter * static_cast<double>(most);
}

void check_shape(const Confusion& c) {
  bool fits = c.right.size() == c.hidden.size() && c.counts.size() == c.hidden.size();
  for (const auto& row : c.counts) fits = fits && row.size() == c.said.size();
  if (!fits) throw std::invalid_argument("confusion_svg: the counts do not have the shape of the labels");
}

}  // namespace

std::string confusion_svg(const Confusion& c, const std::string& title) {
  check_shape(c);
  const std::size_t rows = c.hidden.size(), columns = c.said.size();
  std::vector<double> x(columns), y(rows);
  const double left = 34 + longest(c.hidden), labels = longest(c.said);
  const double top = title_height + 24 + labels * std::sin(lean) + 10;
  double right = left, bottom = top;
  for (std::size_t j = 0; j < columns; ++j) {
    if (j > 0 && is_abstention(c.said[j]) && !is_abstention(c.said[j - 1])) right += group_gap;
    x[j] = right;
    right += cell_width;
  }
  for (std::size_t i = 0; i < rows; ++i) {
    if (i > 0 && is_abstention(c.right[i]) && !is_abstention(c.right[i - 1])) bottom += group_gap;
    y[i] = bottom;
    bottom += cell_height;
  }
  const double sums_x = right + group_gap + cell_width / 2;
  const double width = std::max(sums_x + 24 + labels * std::cos(lean), 700.0), height = bottom + 46;

  std::string svg = fmt::format(
      "<svg class=\"cm\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\" role=\"img\" aria-label=\"{2}\">\n{3}",
      width, height, escape_markup(title), style);
  svg += fmt::format("<text class=\"title\" x=\"16\" y=\"26\">{}</text>\n", escape_markup(title));
  svg += fmt::format("<text class=\"axis\" x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">hidden ↓  said →</text>\n",
                     left - 8, top - 8);
  const auto slanted = [&](double at, const std::string& name) {
    svg += fmt::format("<text transform=\"translate({:.1f} {:.1f}) rotate(-60)\">{}</text>\n", at + 4, top - 6,
                       escape_markup(name));
  };
  for (std::size_t j = 0; j < columns; ++j) slanted(x[j] + cell_width / 2, c.said[j]);
  slanted(sums_x, "cases");
  for (std::size_t i = 0; i < rows; ++i) {
    int sum = 0;
    for (const int n : c.counts[i]) sum += n;
    const double base = y[i] + cell_height / 2 + 4;
    svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\" text-anchor=\"end\">{}</text>\n", left - 8, base,
                       escape_markup(c.hidden[i]));
    for (std::size_t j = 0; j < columns; ++j) {
      const int n = c.counts[i][j];
      const bool is_right = c.said[j] == c.right[i];
      const double share = sum > 0 ? static_cast<double>(n) / sum : 0;
      const Rgb& colour = is_right ? right_colour : is_abstention(c.said[j]) ? abstained_colour : wrong_colour;
      const std::string fill = n > 0 ? fmt::format(" fill=\"{}\"", shade(colour, share)) : "";
      const char* kind = n > 0 ? (is_right ? "right" : "") : is_right ? "empty right" : "empty";
      svg += fmt::format("<rect class=\"{}\"{} x=\"{:.1f}\" y=\"{:.1f}\" width=\"{}\" height=\"{}\"", kind, fill,
                         x[j] + 1, y[i] + 1, cell_width - 2, cell_height - 2);
      if (n == 0) {
        svg += "/>\n";
        continue;
      }
      svg += fmt::format("><title>hidden {}, said {}: {} of {} ({:.0f} %)</title></rect>", escape_markup(c.hidden[i]),
                         escape_markup(c.said[j]), n, sum, 100 * share);
      svg += fmt::format("<text class=\"n {}\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n",
                         share > 0.5 ? "on-dark" : "on-light", x[j] + cell_width / 2, base, n);
    }
    svg += fmt::format("<text class=\"n\" x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", sums_x, base, sum);
  }
  auto key = [&, at = 16.0](const Rgb& colour, const char* text, double advance) mutable {
    for (const double share : {0.0, 0.5, 1.0}) {
      svg += fmt::format("<rect fill=\"{}\" x=\"{:.0f}\" y=\"{:.0f}\" width=\"10\" height=\"10\"/>",
                         shade(colour, share), at + 22 * share, bottom + 19);
    }
    svg += fmt::format("<text x=\"{:.0f}\" y=\"{:.0f}\">{}</text>\n", at + 40, bottom + 28, text);
    at += advance;
  };
  key(right_colour, "right (framed)", 150);
  key(wrong_colour, "wrong name", 135);
  key(abstained_colour, "abstained", 125);
  svg += fmt::format("<text x=\"426\" y=\"{:.0f}\">colour: share of the row, few to all</text>\n", bottom + 28);
  return svg + "</svg>\n";
}

}  // namespace airside::tools::gap
