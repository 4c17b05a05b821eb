// The user's own suspicions.

#include <fmt/format.h>

#include "tools/gap/report/gap_page.hpp"
#include "tools/gap/verdict/verdict_json.hpp"

namespace airside::tools {

void add_suspicions(const GapPage& page, ReportInput& input) {
  for (const gap::Suspicion& s : page.run.suspicions) {
    const gap::TriedEffect& t = s.tried;
    const gap::MagnitudeInterval interval = gap::interval_of(t.best);
    ReportTable table;
    table.title = "You asked: " + gap::title_of(t);
    table.note = fmt::format(
        "{}: {}. The size that fits best is {:.3g}{} ({:.3g} to {:.3g}; nothing would be {:.3g}). Gain over nothing: "
        "twice the logarithm of the likelihood that the model adds on the fitted days, its parameters fitted. Errors "
        "are of the model alone.",
        t.asked.at.text(), gap::sentence_of(t), t.best.magnitude, gap::unit_suffix(*t.best.at.effect), interval.low,
        interval.high, t.best.at.effect->null_value);
    table.row_header = "model with";
    table.columns = {{"gain", "", 0, false}};
    for (const char* days : {"fitted days", "locked days"}) {
      const std::string in = std::string(", ") + days;
      table.columns.push_back({"temperatures" + in, "K", 2, false});
      table.columns.push_back({"CV(RMSE), rooms" + in, "%", 1, false});
      table.columns.push_back({"powers" + in, "kW", 2, false});
      table.columns.push_back({"CV(RMSE), power" + in, "%", 1, false});
    }
    const auto row = [&](const std::string& name, double gain, const Eigen::MatrixXd& residual, SeriesRole role) {
      TableRow r{name, {number_cell(gain)}, role, false};
      for (const gap::PeriodErrors& e :
           {gap::fitted_errors(page.run, residual), gap::locked_errors(page.run, residual)}) {
        for (const double x : {e.temp_rmse_k, e.room_temp.cv_rmse_percent, e.power_rmse_kw, e.power.cv_rmse_percent})
          r.cells.push_back(number_cell(x));
      }
      table.rows.push_back(std::move(r));
    };
    row("nothing", 0, page.run.residual_before, SeriesRole::plain);
    row(gap::title_of(t), t.over_nothing, s.residual, SeriesRole::main);
    if (page.found()) row("what was found", t.found, page.run.residual_after, SeriesRole::plain);
    input.blocks.push_back(table);
  }
}

}  // namespace airside::tools
