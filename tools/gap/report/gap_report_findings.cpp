// What was found: figures, findings, tests on site, missing heat, clean-up.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "tools/gap/report/gap_page.hpp"
#include "tools/gap/verdict/verdict_json.hpp"
#include "tools/report/charts/report_text.hpp"

namespace airside::tools {

namespace {

std::string finding_magnitude(const gap::Finding& f) {
  const gap::MagnitudeInterval interval = gap::interval_of(f);
  return fmt::format("{:.3g}{} ({:.3g} to {:.3g}; nothing would be {:.3g})", f.magnitude,
                     gap::unit_suffix(*f.at.effect), interval.low, interval.high, f.at.effect->null_value);
}

std::string energy_text(const gap::GapRun& run, std::size_t finding) {
  const gap::FindingEnergy& e = run.energy[finding];
  if (e.by_meter.empty()) return "–";
  std::string text = fmt::format("{:+.1f} kWh a day ({:+.1f} to {:+.1f}) on {:.1f}", e.total, e.low, e.high, e.without);
  const gap::Price& price = run.request.price;
  if (price.per_kwh > 0) text += fmt::format("; {:+.2f} {} a day", price.per_kwh * e.total, price.currency);
  return text;
}

void add_meter_offsets(const GapPage& page, ReportInput& input) {
  if (page.run.meter_offsets.empty()) return;
  ReportTable table;
  table.title = "What is missing, as power of a meter";
  table.note = "Measured less simulated, after the missing heat was put into the zones.";
  table.row_header = "meter";
  table.columns = {{"from", "h", 0, false},
                   {"to", "h", 0, false},
                   {"in those hours", "kW", 2, false},
                   {"a day", "kWh", 1, false},
                   {"above noise", "", 0, false}};
  for (const gap::MeterOffset& offset : page.run.meter_offsets) {
    table.rows.push_back({fmt::format("power {}", offset.meter + 1),
                          {number_cell(offset.from_h),
                           number_cell(offset.to_h),
                           {offset.kw, offset.sd_kw, ""},
                           number_cell(offset.kwh_per_day),
                           text_cell(offset.above_noise ? "yes" : "no")},
                          offset.above_noise ? SeriesRole::main : SeriesRole::plain,
                          false});
  }
  input.blocks.push_back(table);
}

}  // namespace

void add_figures(const GapPage& page, ReportInput& input) {
  const gap::ChannelErrors before = page.locked(page.news_before), after = page.locked(page.news_after);
  const auto change = [&](const char* label, int from, int to, const char* unit) {
    const double now = gap::joint_rmse(after, from, to), then = gap::joint_rmse(before, from, to);
    input.figures.push_back({number_text(now, 2), unit, label,
                             page.found() ? number_text(then, 2) + " without what was found" : "root mean square"});
  };
  add_verdict_figure(page, input);
  change("temperatures, locked days", 0, page.at.mau_temp() + 1, "K");
  change("powers, locked days", page.at.power(), page.at.fcu_duty(), "kW");
  input.figures.push_back(
      {number_text(page.run.verdict.residual_ratio, 2), "x", "left over, of the noise", "1 is a right model"});
  if (page.run.retraining) {
    const gap::RetrainSpread s = gap::spread_of(*page.run.retraining, &Metrics::dae_degc);
    input.figures.push_back({number_text(s.after.mean, 3), "K", "DAE, weights of the patched twin",
                             number_text(s.before.mean, 3) + " with weights of the twin"});
  }
}

void add_findings(const GapPage& page, ReportInput& input) {
  if (!page.found()) return;
  ReportTable table;
  table.title = page.run.verdict.kind == gap::VerdictKind::named ? "What is missing" : "What might be missing";
  table.note =
      "Energy: by the site's meters, with it less without it, under the commands of the log. Days that agree: share of "
      "two-day blocks that ask for a change in the same direction.";
  table.row_header = "effect";
  table.prose = true;
  for (const char* name :
       {"probability", "magnitude, 95 % interval", "energy", "days that agree", "looks like", "confirm on site"}) {
    table.columns.push_back({name, "", 0, false});
  }
  std::vector<gap::Finding> listed = page.run.verdict.findings;
  listed.insert(listed.end(), page.run.verdict.unsure.begin(), page.run.verdict.unsure.end());
  for (std::size_t i = 0; i < listed.size(); ++i) {
    const gap::Finding& f = listed[i];
    const double probability = probability_of(page, f);
    const bool own_reason = !f.why_not.empty() && !f.why_not.starts_with("not sure");
    table.rows.push_back(
        {f.at.text() + (own_reason ? " (" + f.why_not + ")" : ""),
         {text_cell(std::isfinite(probability) ? number_text(100 * probability, 0) + " %" : "–"),
          text_cell(finding_magnitude(f)), text_cell(i < page.run.energy.size() ? energy_text(page.run, i) : "–"),
          text_cell(number_text(100 * f.same_sign, 0) + " %"), text_cell(f.at.effect->looks_like),
          text_cell(f.at.effect->confirm)},
         SeriesRole::plain,
         false});
  }
  input.blocks.push_back(table);
}

void add_posteriors(const GapPage& page, ReportInput& input) {
  const gap::Verdict& v = page.run.verdict;
  for (std::size_t i = 0; i < v.posteriors.size(); ++i) {
    const gap::Posterior& p = v.posteriors[i];
    const gap::Alternatives& tried = v.alternatives[i];
    std::vector<std::string> titles;
    for (const std::string& id : tried.beside) titles.push_back(effect_title(page, id));
    ReportTable table;
    table.title = tried.beside.empty() ? "How probable each explanation is"
                                       : fmt::format("How probable each is beside {}", fmt::join(titles, ", "));
    table.note = fmt::format(
        "Bold: the fewest that together hold 90 %. A name needs {:.0f} % of what is not something else. Gain: "
        "twice the logarithm of the likelihood that an explanation adds; on days that nothing was fitted to, what "
        "the fitted days let expect and what came.",
        100 * p.name_needs);
    table.row_header = "explanation";
    table.prose = true;
    table.columns = {{"probability", "", 0, false},
                     {"size, 95 % interval", "", 0, false},
                     {"gain on the locked days: predicted, came", "2 ln likelihood ratio", 0, false}};
    std::vector<std::pair<double, TableRow>> rows;
    const auto add = [&](const std::string& id, const std::string& what, double probability, const std::string& size,
                         const std::string& locked) {
      const bool in_set = std::ranges::find(p.set, id) != p.set.end();
      rows.emplace_back(probability, TableRow{what,
                                              {text_cell(number_text(100 * probability, 1) + " %"), text_cell(size),
                                               text_cell(locked)},
                                              in_set ? SeriesRole::main : SeriesRole::plain,
                                              false});
    };
    for (const gap::EffectProbability& e : p.effects) {
      if (e.probability < 0.01) break;
      const gap::Alternative& a = tried.list[e.from];
      add(a.at.id(), a.at.text(), e.probability, gap::magnitude_text(a),
          a.locked ? fmt::format("{:.0f}, {:.0f}{}", a.locked_expected, a.locked_log_likelihood_ratio,
                                 e.vetoed ? ": contradicted" : "")
                   : "–");
    }
    add("nothing", "nothing", p.nothing, "–", "–");
    add("other", "something that no effect is", p.other, "–", "–");
    std::ranges::stable_sort(rows, [](const auto& a, const auto& b) { return a.first > b.first; });
    for (auto& [probability, row] : rows) table.rows.push_back(std::move(row));
    input.blocks.push_back(table);
  }
}

void add_experiments(const GapPage& page, ReportInput& input) {
  if (page.run.experiments.empty()) return;
  ReportTable table;
  table.title = "Which test would tell them apart";
  table.note =
      "Simulated on this twin with this weather; airside gap next judges anew with the test's log. Power: the chance "
      "to tell the two members apart that are hardest "
      "to, "
      "when five in a hundred decisions may be wrong.";
  table.row_header = "test";
  table.prose = true;
  for (const char* name : {"name for --test", "hours", "power", "rooms", "hardest pair"})
    table.columns.push_back({name, "", 0, false});
  for (std::size_t i = 0; i < page.run.experiments.size() && i < 5; ++i) {
    const gap::ExperimentProposal& e = page.run.experiments[i];
    table.rows.push_back({e.text,
                          {text_cell(e.name), text_cell(number_text(e.hours, 0)),
                           text_cell((e.upper_bound ? "at most " : "") + number_text(100 * e.power, 0) + " %"),
                           text_cell(fmt::format("{:.1f} to {:.1f} °C", e.lowest_room_degc, e.highest_room_degc)),
                           text_cell(with_titles(page, e.hardest))},
                          i == 0 && e.separates ? SeriesRole::main : SeriesRole::plain,
                          false});
  }
  input.blocks.push_back(table);
}

void add_heat(const GapPage& page, ReportInput& input) {
  if (!page.run.heat) return;
  ReportTable table;
  table.title = "What is missing, as heat into each zone";
  for (const gap::ZoneHeat& z : page.run.heat->zones) {
    if (!z.text.empty()) table.note += (table.note.empty() ? "" : " ") + as_sentence(z.text);
  }
  if (table.note.empty()) table.note = as_sentence(page.run.heat->text);
  table.row_header = "zone";
  table.columns = {{"mean", "kW", 2, false},           {"from", "h", 0, false},    {"to", "h", 0, false},
                   {"in those hours", "kW", 2, false}, {"a day", "kWh", 1, false}, {"above noise", "", 0, false}};
  for (const gap::ZoneHeat& z : page.run.heat->zones) {
    const bool vav = z.zone < page.at.rooms;
    table.rows.push_back(
        {vav ? fmt::format("room {}", z.zone + 1) : fmt::format("FCU room {}", z.zone - page.at.rooms + 1),
         {{z.mean_kw, z.mean_sd_kw, ""},
          number_cell(z.from_h),
          number_cell(z.to_h),
          {z.active_kw, z.active_sd_kw, ""},
          number_cell(z.kwh_per_day),
          text_cell(z.above_noise ? "yes" : "no")},
         z.above_noise ? SeriesRole::main : SeriesRole::plain,
         false});
  }
  input.blocks.push_back(table);
  add_meter_offsets(page, input);
}

void add_clean_up(const GapPage& page, ReportInput& input) {
  ReportTable table;
  table.title = "What was wrong with the logs";
  table.note = "Nothing is concluded from values that were left out.";
  table.row_header = "defect";
  table.prose = true;
  for (const char* name : {"done", "log", "column", "from", "to", "count", "what was found"}) {
    table.columns.push_back({name, "", 0, false});
  }
  for (const gap::CleanLog* log : gap::logs_of(page.run)) {
    for (const gap::Remark& r : gap::shown_remarks(*log)) {
      table.rows.push_back({gap::text_of(r.defect),
                            {text_cell(gap::text_of(r.action)), text_cell(log->place),
                             text_cell(r.column.empty() ? "all" : r.column), text_cell(minute_text(r.from)),
                             text_cell(minute_text(r.to)), text_cell(std::to_string(r.count)), text_cell(r.text)},
                            r.action == gap::Action::warned ? SeriesRole::main : SeriesRole::plain,
                            false});
    }
  }
  if (table.rows.empty()) {
    input.blocks.push_back(ReportNote{table.title, {"Nothing: no value had to be left out or put right."}});
    return;
  }
  input.blocks.push_back(table);
}

}  // namespace airside::tools
