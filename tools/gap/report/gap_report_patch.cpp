// What was written into the model, and what that is worth to the controller.

#include <fmt/format.h>

#include "tools/gap/report/gap_page.hpp"
#include "tools/gap/verdict/verdict_json.hpp"

namespace airside::tools {

namespace {

std::string edits_text(const std::vector<gap::ModelEdit>& edits) {
  const auto shown = [](const nlohmann::json& value) {
    if (value.is_null()) return std::string("none");
    if (value.is_number_float()) return fmt::format("{:.4g}", value.get<double>());
    const std::string text = value.dump();
    return text.size() > 60 ? text.substr(0, 57) + "..." : text;
  };
  if (edits.empty()) return "–";
  std::string text =
      fmt::format("{}: {} → {}", edits.front().where, shown(edits.front().before), shown(edits.front().after));
  if (edits.size() > 1) text += fmt::format(", and {} more", edits.size() - 1);
  return text;
}

}  // namespace

void add_ledger(const GapPage& page, ReportInput& input) {
  if (!page.run.patched) {
    const bool unsure = page.found() && page.run.verdict.kind != gap::VerdictKind::named;
    input.blocks.push_back(
        ReportNote{"The twin was left as it is",
                   {unsure ? "Only a named effect is written into the twin. --best-guess writes the best guess."
                           : "Nothing was found that could be written into it."}});
    return;
  }
  ReportTable table;
  table.title = "What was written into the twin";
  table.note =
      "The ledger. twin-patch.json holds the change, ledger.json also the patch that takes it back: "
      "airside gap revert ledger.json MODEL -o OUT.";
  table.row_header = "change";
  table.prose = true;
  for (const char* name : {"why", "magnitude", "in the model", "beside the model"}) {
    table.columns.push_back({name, "", 0, false});
  }
  for (std::size_t k = page.run.patched->changes.size(); k-- > 0;) {  // findings first
    const gap::PatchedChange& change = page.run.patched->changes[k];
    const bool parameter = k < page.run.before.size();
    const std::string size =
        parameter ? fmt::format("{:.3g}{} ± {:.2g}", change.change.magnitude,
                                gap::unit_suffix(*change.change.at.effect), 1.96 * page.run.parameters[k].sd)
                  : gap::magnitude_text(page.run.verdict.findings[k - page.run.before.size()]);
    std::string beside;
    for (const std::string& line : change.beside) beside += (beside.empty() ? "" : "; ") + line;
    table.rows.push_back({change.change.at.text(),
                          {text_cell(parameter ? "the reference period asks for it" : "found"), text_cell(size),
                           text_cell(edits_text(change.edits)), text_cell(beside.empty() ? "–" : beside)},
                          parameter ? SeriesRole::plain : SeriesRole::main,
                          false});
  }
  input.blocks.push_back(table);
}

/// What the patch is worth to the controller.
void add_retraining(const GapPage& page, ReportInput& input) {
  if (!page.run.retraining) return;
  const gap::Retraining& r = *page.run.retraining;
  const std::string measured =
      r.stand_in ? "the patched twin in the measured room's stead" : "room " + gap::text_of(r.plan.measured);
  ReportTable table;
  table.title = "What that is worth to the controller";
  table.note = fmt::format(
      "{}. Pretrained for {} days on the twin and on the patched twin, then put on {} for {} days, {} seeds, mean ± "
      "standard deviation over seeds. DAE: mean |room mean - target| in working hours; ME: its worst day; DARV: "
      "unrest of the setpoint.",
      gap::sentence_of(r), r.plan.pretrain_days, measured, r.plan.days, r.runs.size());
  for (const std::string& remark : r.remarks) table.note += " " + remark;
  table.row_header = "weights of";
  TableRow before{"the twin", {}, SeriesRole::plain, true}, after{"the patched twin", {}, SeriesRole::main, true},
      change{"change, seed by seed", {}, SeriesRole::reference, false},
      lower{"seeds lower", {}, SeriesRole::reference, false};
  for (const gap::RetrainFigure& f : gap::retrain_figures()) {
    const gap::RetrainSpread s = gap::spread_of(r, f.figure);
    table.columns.push_back({f.title, "K", 3, true});
    before.cells.push_back({s.before.mean, s.before.sd, ""});
    after.cells.push_back({s.after.mean, s.after.sd, ""});
    change.cells.push_back({s.change.mean, s.change.sd, ""});
    lower.cells.push_back(text_cell(fmt::format("{} of {}", r.seeds_lower(f.figure), r.runs.size())));
  }
  table.rows = {before, after, change, lower};
  input.blocks.push_back(table);

  BarChart chart;
  chart.title = "DAE day by day, with weights of either twin";
  chart.note = fmt::format("On {}; whiskers: standard deviation over {} seeds.", measured, r.runs.size());
  chart.unit = "K";
  chart.decimals = 3;
  BarGroup twin{"weights of the twin", {}, {}, SeriesRole::plain},
      patched{"weights of the patched twin", {}, {}, SeriesRole::main};
  for (std::size_t day = 0; day < static_cast<std::size_t>(r.plan.days); ++day) {
    const gap::RetrainSpread s = gap::daily_dae(r, day);
    chart.categories.push_back(fmt::format("day {}", day + 1));
    twin.y.push_back(s.before.mean);
    twin.spread.push_back(s.before.sd);
    patched.y.push_back(s.after.mean);
    patched.spread.push_back(s.after.sd);
  }
  chart.groups = {twin, patched};
  input.blocks.push_back(chart);
}

}  // namespace airside::tools
