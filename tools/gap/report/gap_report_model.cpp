// What the model and the sensors can show at all.

#include <fmt/format.h>

#include <cmath>

#include "tools/gap/map/mapping.hpp"
#include "tools/gap/report/gap_page.hpp"
#include "tools/gap/run/detectable.hpp"

namespace airside::tools {

void add_model(const GapPage& page, ReportInput& input) {
  const gap::Engine& engine = *page.run.loaded.engine;
  if (!engine.plays_commands()) {
    input.blocks.push_back(ReportNote{"The model's own control", {gap::own_control_text(engine)}});
  }
  if (const std::string& map = page.run.request.source.map; !map.empty())
    input.blocks.push_back(ReportNote{"Columns of the log", gap::lines_of(gap::read_mapping(map))});
  if (engine.stand_in()) {
    input.blocks.push_back(ReportNote{
        "A simpler room in the twin's stead",
        {"A run of the twin is dear. So a room of resistances and capacities (RC) stood in for it where effects were "
         "ranked and sizes fitted. It was corrected by runs of the twin: at the fitted parameters, and with each of "
         "the "
         "likeliest effects. The curves, the errors before and after and the patched model are the twin's own."}});
  }
  ReportTable table;
  table.title = "What these sensors could show";
  table.note =
      "From which size each effect would stand out in these days: its expected gain then reaches its limit, by linear "
      "responses and the noise of the reference period, or, without one, of what nothing explains. What was measured "
      "does "
      "not count here.";
  table.row_header = "effect";
  table.prose = true;
  table.columns = {{"stands out from", "", 2, false}, {"largest that is possible", "", 2, false}, {"", "", 0, false}};
  for (const gap::Detectable& d : gap::detectable_sizes(page.run)) {
    const auto number = [&](double x) {
      return text_cell(std::isfinite(x) ? fmt::format("{:.3g} {}", x, d.at.effect->unit) : "no size");
    };
    table.rows.push_back({d.at.text(),
                          {number(d.size), number(d.bound), text_cell(d.visible ? "" : "not visible")},
                          SeriesRole::plain,
                          false});
  }
  for (const gap::NotApplicable& n : page.run.not_applicable)
    table.rows.push_back(
        {n.title, {text_cell("not applicable"), text_cell(""), text_cell(n.why)}, SeriesRole::plain, false});
  input.blocks.push_back(table);
}

}  // namespace airside::tools
