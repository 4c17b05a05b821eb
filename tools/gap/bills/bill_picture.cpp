#include "tools/gap/bills/bill_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "hal/text/civil_text.hpp"
#include "tools/report/charts/report_text.hpp"

namespace airside::tools::gap {

namespace {

constexpr double bills_width = 760, bills_left = 70, bills_row = 200, bills_bar_room = 130, bills_top = 76;

constexpr const char* bills_style = R"(<style>
.bl text{font-family:system-ui,-apple-system,"Segoe UI",Roboto,"Noto Sans",sans-serif;font-size:12px;fill:#3d4754}
.bl .title{font-size:16px;font-weight:600;fill:#161c24}.bl .axis{font-weight:600}.bl .paper{fill:#fff}
.bl .grid{stroke:#e3e8ee}.bl .bill{fill:#c3ccd6}.bl .model{fill:#0b62b4}
</style>
<rect class="paper" width="100%" height="100%"/>
)";

/// 1, 2 or 5 times a power of ten, at least `value`.
double round_up(double value) {
  const double power = std::pow(10, std::floor(std::log10(std::max(value, 1e-9))));
  for (const double step : {1.0, 2.0, 5.0}) {
    if (value <= step * power) return step * power;
  }
  return 10 * power;
}

std::string meter_row(const BillTable& bills, const BillVerdict& v, Eigen::Index m, double top) {
  const Eigen::Index periods = bills.kwh.rows();
  double most = v.simulated_kwh.col(m).maxCoeff();
  for (Eigen::Index p = 0; p < periods; ++p) {
    if (std::isfinite(bills.kwh(p, m))) most = std::max(most, bills.kwh(p, m));
  }
  most = round_up(most);
  const double base = top + bills_bar_room, wide = (bills_width - bills_left - 20) / static_cast<double>(periods);
  const auto height = [&](double kwh) { return bills_bar_room * std::clamp(kwh / most, 0.0, 1.0); };
  std::string svg = fmt::format("<text class=\"axis\" x=\"16\" y=\"{:.0f}\">{}, kWh</text>\n", top - 10,
                                escape_markup(bills.meters[static_cast<std::size_t>(m)]));
  for (const double share : {0.0, 0.5, 1.0}) {
    svg += fmt::format(
        "<line class=\"grid\" x1=\"{0}\" x2=\"{1}\" y1=\"{2:.1f}\" y2=\"{2:.1f}\"/>"
        "<text x=\"{3}\" y=\"{4:.1f}\" text-anchor=\"end\">{5:g}</text>\n",
        bills_left, bills_width - 20, base - bills_bar_room * share, bills_left - 8, base - bills_bar_room * share + 4,
        share * most);
  }
  for (Eigen::Index p = 0; p < periods; ++p) {
    const double x = bills_left + wide * static_cast<double>(p);
    const double bill = bills.kwh(p, m), model = v.simulated_kwh(p, m);
    const std::string month =
        hal::civil_text(bills.periods[static_cast<std::size_t>(p)].from).substr(0, hal::date_text_size);
    if (std::isfinite(bill)) {
      svg += fmt::format(
          "<rect class=\"bill\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"><title>{}: billed {:.0f} "
          "kWh</title></rect>",
          x + 0.1 * wide, base - height(bill), 0.8 * wide, height(bill), month, bill);
    }
    svg += fmt::format(
        "<rect class=\"model\" x=\"{:.1f}\" y=\"{:.1f}\" width=\"{:.1f}\" height=\"{:.1f}\"><title>{}: model {:.0f} "
        "kWh</title></rect>\n",
        x + 0.35 * wide, base - height(model), 0.3 * wide, height(model), month, model);
    if (periods <= 14 || p % 3 == 0)
      svg += fmt::format("<text x=\"{:.1f}\" y=\"{:.1f}\">{}</text>\n", x + 0.1 * wide, base + 16, month.substr(2, 5));
  }
  return svg;
}

}  // namespace

std::string bills_svg(const BillTable& bills, const BillVerdict& verdict) {
  const double height = bills_top + bills_row * static_cast<double>(bills.meters.size());
  std::string svg = fmt::format(
      "<svg class=\"bl\" xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {0:.0f} {1:.0f}\" width=\"{0:.0f}\" "
      "height=\"{1:.0f}\" role=\"img\" aria-label=\"bills and model\">\n{2}"
      "<text class=\"title\" x=\"16\" y=\"28\">Bills and model</text>\n"
      "<rect class=\"bill\" x=\"170\" y=\"17\" width=\"12\" height=\"12\"/><text x=\"188\" y=\"28\">billed</text>"
      "<rect class=\"model\" x=\"240\" y=\"17\" width=\"12\" height=\"12\"/><text x=\"258\" y=\"28\">the model as it "
      "is, "
      "same days</text>\n",
      bills_width, height, bills_style);
  for (Eigen::Index m = 0; m < bills.kwh.cols(); ++m)
    svg += meter_row(bills, verdict, m, bills_top + bills_row * static_cast<double>(m));
  return svg + "</svg>\n";
}

}  // namespace airside::tools::gap
