#include "tools/report/gap_report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>

#include "hal/system/version.hpp"
#include "hal/text/civil_text.hpp"
#include "tools/gap/verdict/verdict_json.hpp"
#include "tools/report/charts/report_text.hpp"
#include "tools/report/gap_charts.hpp"

namespace airside::tools {

namespace {

using gap::GapRun;

TableCell number_cell(double value) { return {value, std::nullopt, ""}; }
TableCell text_cell(std::string text) { return {std::nullopt, std::nullopt, std::move(text)}; }

/// "room 1", "FCU room 2", "power 1": what people call a channel.
std::string channel_title(const sim::Channels& at, int c) {
  if (c < at.fcu_temp()) return fmt::format("room {}", c + 1);
  if (c < at.mau_temp()) return fmt::format("FCU room {}", c - at.fcu_temp() + 1);
  if (c == at.mau_temp()) return "MAU outlet";
  if (c == at.supply_temp()) return "supply";
  if (c < at.fcu_duty()) return fmt::format("power {}", c - at.power() + 1);
  return fmt::format("FCU duty {}", c - at.fcu_duty() + 1);
}

std::string finding_magnitude(const gap::Finding& f) {
  const gap::MagnitudeInterval interval = gap::interval_of(f);
  return fmt::format("{:.3g}{} ({:.3g} to {:.3g}; nothing would be {:.3g})", f.magnitude,
                     gap::unit_suffix(*f.at.effect), interval.low, interval.high, f.at.effect->null_value);
}

/// A row that says nothing is left out.
bool ever_measured(const Eigen::MatrixXd& residual, int channel) {
  return std::any_of(residual.col(channel).begin(), residual.col(channel).end(),
                     [](double x) { return std::isfinite(x); });
}

class GapReport {
 public:
  explicit GapReport(const GapRun& run)
      : run_(run), at_(run.channels()), first_(std::min<Eigen::Index>(gap::bins_per_day, run.residual_given.rows())) {
    for (int c = 0; c < at_.count(); ++c) {
      if (ever_measured(run.residual_given, c)) shown_.push_back(c);
    }
  }

  ReportInput make() {
    const gap::Verdict& v = run_.verdict;
    input_.title = titles[static_cast<std::size_t>(v.kind)];
    input_.subtitle = fmt::format("{}: {} against its log of {} to {}", run_.request.site,
                                  run_.loaded.engine->description(), date(run_.loaded.data.test.recording.from),
                                  date({run_.loaded.data.test.recording.to().seconds - 1}));
    input_.headline = ended(gap::sentence_of(run_));
    add_figures();
    add_findings();
    add_experiments();
    add_heat();
    add_clean_up();
    add_maps();
    add_curves();
    add_ranking();
    add_locked_days();
    add_guideline();
    add_ledger();
    add_retraining();
    add_facts();
    return std::move(input_);
  }

 private:
  static constexpr const char* titles[] = {"No gap above the floor", "The missing effect has a name",
                                           "The missing effect is one of several", "Something unknown is missing"};

  static std::string ended(std::string text) {
    if (!text.empty() && text.back() != '.') text += '.';
    return text;
  }
  static std::string date(CivilTime t) { return hal::civil_text(t).substr(0, 10); }
  bool found() const { return !run_.verdict.findings.empty(); }
  Eigen::Index bins() const { return run_.residual_given.rows(); }
  long locked_days() const { return static_cast<long>((bins() - run_.locked_from()) / gap::bins_per_day); }
  gap::ChannelErrors locked(const Eigen::MatrixXd& residual) const {
    return gap::errors_of(residual, run_.locked_from(), bins());
  }

  void add_figures() {
    const gap::ChannelErrors before = locked(run_.residual_before), after = locked(run_.residual_after);
    const auto change = [&](const char* label, int from, int to, const char* unit) {
      const double now = gap::joint_rmse(after, from, to), then = gap::joint_rmse(before, from, to);
      input_.figures.push_back({number_text(now, 2), unit, label,
                                found() ? number_text(then, 2) + " without what was found" : "root mean square"});
    };
    const gap::Verdict& v = run_.verdict;
    input_.figures.push_back({gap::text_of(v.kind), "", "verdict", v.reason});
    input_.figures.push_back({number_text(v.best_gain, 0), "", "best gain of one effect",
                              "limit " + number_text(v.gain_limit, 0) + ", above which it is no noise"});
    change("temperatures, locked days", 0, at_.mau_temp() + 1, "K");
    change("powers, locked days", at_.power(), at_.fcu_duty(), "kW");
    input_.figures.push_back({number_text(v.leftover, 2), "x", "left over, of the noise", "1 is a right model"});
    if (run_.retraining) {
      const gap::RetrainSpread s = gap::spread_of(*run_.retraining, &Metrics::dae_degc);
      input_.figures.push_back({number_text(s.after.mean, 3), "K", "DAE, weights of the patched twin",
                                number_text(s.before.mean, 3) + " with weights of the twin"});
    }
  }

  void add_findings() {
    if (!found()) return;
    ReportTable table;
    table.title = run_.verdict.kind == gap::VerdictKind::named ? "What is missing" : "What might be missing";
    table.note = fmt::format(
        "Gain: twice the logarithm of the likelihood that the effect adds; up to its limit it is noise. Margin: that "
        "gain "
        "over the gain of the best other explanation. Signs: share of two-day blocks that ask for the same direction.");
    table.row_header = "effect";
    table.prose = true;
    for (const char* name : {"magnitude, 95 % interval", "gain", "margin", "signs", "cannot be told from", "looks like",
                             "confirm on site"}) {
      table.columns.push_back({name, "", 0, false});
    }
    for (const gap::Finding& f : run_.verdict.findings) {
      std::string alike;
      for (const sim::EffectAt& other : f.cannot_tell_from) alike += (alike.empty() ? "" : "; ") + other.text();
      table.rows.push_back(
          {f.at.text() + (f.why_not.empty() ? "" : " (" + f.why_not + ")"),
           {text_cell(finding_magnitude(f)), text_cell(number_text(f.gain, 0)),
            text_cell(f.margin > 999 ? "> 999 x" : number_text(f.margin, 1) + " x"),
            text_cell(number_text(100 * f.same_sign, 0) + " %"), text_cell(alike.empty() ? "–" : alike),
            text_cell(f.at.effect->looks_like), text_cell(f.at.effect->confirm)},
           SeriesRole::plain,
           false});
    }
    input_.blocks.push_back(table);
  }

  void add_experiments() {
    if (run_.experiments.empty()) return;
    ReportTable table;
    table.title = "Which test would tell them apart";
    table.note =
        "Simulated on this twin with this weather. Power: the chance to tell the two members apart that are hardest "
        "to, "
        "when five in a hundred decisions may be wrong.";
    table.row_header = "test";
    table.prose = true;
    for (const char* name : {"hours", "power", "rooms", "hardest pair"}) table.columns.push_back({name, "", 0, false});
    for (std::size_t i = 0; i < run_.experiments.size() && i < 5; ++i) {
      const gap::ExperimentProposal& e = run_.experiments[i];
      table.rows.push_back({e.text,
                            {text_cell(number_text(e.hours, 0)),
                             text_cell((e.upper_bound ? "at most " : "") + number_text(100 * e.power, 0) + " %"),
                             text_cell(fmt::format("{:.1f} to {:.1f} °C", e.lowest_room_degc, e.highest_room_degc)),
                             text_cell(e.hardest)},
                            i == 0 && e.separates ? SeriesRole::main : SeriesRole::plain,
                            false});
    }
    input_.blocks.push_back(table);
  }

  void add_heat() {
    if (!run_.heat) return;
    ReportTable table;
    table.title = "What is missing, as heat into each zone";
    table.note = ended(run_.heat->text);
    table.row_header = "zone";
    table.columns = {{"mean", "kW", 2, false},           {"from", "h", 0, false},    {"to", "h", 0, false},
                     {"in those hours", "kW", 2, false}, {"a day", "kWh", 1, false}, {"above noise", "", 0, false}};
    for (const gap::ZoneHeat& z : run_.heat->zones) {
      const bool vav = z.zone < at_.rooms;
      table.rows.push_back(
          {vav ? fmt::format("room {}", z.zone + 1) : fmt::format("FCU room {}", z.zone - at_.rooms + 1),
           {{z.mean_kw, z.mean_sd_kw, ""},
            number_cell(z.from_h),
            number_cell(z.to_h),
            {z.active_kw, z.active_sd_kw, ""},
            number_cell(z.kwh_per_day),
            text_cell(z.above_noise ? "yes" : "no")},
           z.above_noise ? SeriesRole::main : SeriesRole::plain,
           false});
    }
    input_.blocks.push_back(table);
  }

  void add_clean_up() {
    ReportTable table;
    table.title = "What was wrong with the logs";
    table.note = "Nothing is concluded from values that were left out.";
    table.row_header = "defect";
    table.prose = true;
    for (const char* name : {"done", "log", "column", "from", "to", "count", "what was found"}) {
      table.columns.push_back({name, "", 0, false});
    }
    for (const gap::CleanLog* log : {&run_.loaded.logs.reference, &run_.loaded.logs.measured}) {
      for (const gap::Remark& r : gap::shown_remarks(*log)) {
        table.rows.push_back(
            {gap::text_of(r.defect),
             {text_cell(gap::text_of(r.action)), text_cell(log->place), text_cell(r.column.empty() ? "all" : r.column),
              text_cell(hal::civil_text(r.from).substr(0, 16)), text_cell(hal::civil_text(r.to).substr(0, 16)),
              text_cell(std::to_string(r.count)), text_cell(r.text)},
             SeriesRole::plain,
             false});
      }
    }
    if (table.rows.empty()) {
      input_.blocks.push_back(ReportNote{table.title, {"Nothing: no value had to be left out or put right."}});
      return;
    }
    input_.blocks.push_back(table);
  }

  /// Largest common scale of the unit's rows that a few extremes do not spoil.
  std::map<std::string, double> scales(const std::vector<const Eigen::MatrixXd*>& all) const {
    std::map<std::string, std::vector<double>> sizes;
    for (const Eigen::MatrixXd* m : all) {
      for (const int c : shown_) {
        for (const double x : m->row(c)) {
          if (std::isfinite(x)) sizes[at_.unit(c)].push_back(std::abs(x));
        }
      }
    }
    std::map<std::string, double> scale{{"K", 0.1}, {"kW", 0.1}, {"-", 0.05}};
    for (auto& [unit, list] : sizes) {
      std::sort(list.begin(), list.end());
      scale[unit] = std::max(scale[unit], list[list.size() * 97 / 100]);
    }
    return scale;
  }

  HeatMap map_of_channels(const std::string& title, const gap::ErrorMap& errors, const Eigen::MatrixXd& values,
                          const std::map<std::string, double>& scale) const {
    HeatMap map;
    map.title = title;
    map.columns = errors.groups;
    map.full_colour = scale;
    map.values.resize(std::ssize(shown_), values.cols());
    for (std::size_t i = 0; i < shown_.size(); ++i) {
      map.rows.push_back({channel_title(at_, shown_[i]), at_.unit(shown_[i])});
      map.values.row(static_cast<Eigen::Index>(i)) = values.row(shown_[i]);
    }
    return map;
  }

  static std::string scale_text(const std::map<std::string, double>& scale) {
    return fmt::format("Full colour: {:.2g} K, {:.2g} kW, {:.2g} of a duty.", scale.at("K"), scale.at("kW"),
                       scale.at("-"));
  }

  /// One figure: before and after, by one grouping, the mean or the RMSE.
  template <class Grouped>
  void add_map(const std::string& title, const std::string& note, bool mean, const Grouped& grouped,
               const std::function<void(HeatMap&)>& finish) {
    const gap::ErrorMap before = grouped(run_.residual_before), after = grouped(run_.residual_after);
    const Eigen::MatrixXd &b = mean ? before.mean : before.rmse, &a = mean ? after.mean : after.rmse;
    const auto scale = scales({&b, &a});
    PictureRow pictures;
    pictures.title = title;
    pictures.note = note + " " + scale_text(scale);
    const auto draw = [&](const char* name, const gap::ErrorMap& errors, const Eigen::MatrixXd& values) {
      HeatMap map = map_of_channels(name, errors, values, scale);
      finish(map);
      pictures.svg.push_back(heat_map_svg(map));
    };
    draw(run_.before.empty() ? "the twin" : "the twin, fitted to the reference", before, b);
    if (found()) draw("with what was found", after, a);
    input_.blocks.push_back(pictures);
  }

  void add_maps() {
    const auto by_hour = [this](const Eigen::MatrixXd& r) { return gap::errors_by_hour(r, first_); };
    const auto by_weather = [this](const Eigen::MatrixXd& r) {
      return gap::errors_by_weather(r, run_.loaded.data.test.recording, first_);
    };
    const auto by_day = [this](const Eigen::MatrixXd& r) {
      return gap::errors_by_day(r, run_.loaded.data.test.recording.from);
    };
    const auto hours = [](HeatMap& map) { map.column_unit = " h"; };
    add_map("When the twin is wrong, and in which direction",
            "Mean of measured minus simulated by hour of day, all measured days but the first. Orange: measured more "
            "than the twin says; blue: less.",
            true, by_hour, hours);
    add_map("How far the twin is off", "Root mean square error by hour of day, all measured days but the first.", false,
            by_hour, hours);
    add_map(
        "In which weather",
        "Mean of measured minus simulated. Cool, mild and warm: thirds of the measured outdoor temperatures; sunny: "
        "more than 300 W/m² straight from the sun.",
        true, by_weather, [](HeatMap&) {});
    add_map("On which days", "Root mean square error by day.", false, by_day, [this](HeatMap& map) {
      map.marked_from = static_cast<std::size_t>(run_.locked_from() / gap::bins_per_day);
      map.mark = "locked away";
    });
  }

  /// Channels that the findings moved most; without findings those that are off most.
  std::vector<int> telling_channels() const {
    std::vector<std::pair<double, int>> order;
    for (const int c : shown_) {
      const std::string unit = at_.unit(c);
      const double floor = unit == "K" ? 0.1 : unit == "kW" ? 0.2 : 0.1;
      double square = 0;
      int count = 0;
      for (Eigen::Index t = first_; t < bins(); ++t) {
        const double x = found() ? run_.residual_before(t, c) - run_.residual_after(t, c) : run_.residual_before(t, c);
        if (!std::isfinite(x)) continue;
        square += x * x;
        ++count;
      }
      const double left = found() ? gap::errors_of(run_.residual_after, first_, bins()).rmse(c) : 0;
      order.emplace_back(-std::sqrt(square / std::max(1, count)) / (left + floor), c);
    }
    std::sort(order.begin(), order.end());
    std::vector<int> channels;
    for (const auto& [size, c] : order) {
      if (channels.size() < 4) channels.push_back(c);
    }
    return channels;
  }

  void add_curves() {
    const CivilTime from = run_.loaded.data.test.recording.from;
    constexpr double bin_s = 86400.0 / gap::bins_per_day;
    std::vector<double> x(static_cast<std::size_t>(bins()));
    for (std::size_t i = 0; i < x.size(); ++i) {
      x[i] = static_cast<double>(from.seconds) + bin_s * (static_cast<double>(i) + 0.5);
    }
    const auto curve = [](const Eigen::MatrixXd& residual, int c) {
      return std::vector<double>(residual.col(c).begin(), residual.col(c).end());
    };
    for (const int c : telling_channels()) {
      LineChart chart;
      chart.title = channel_title(at_, c) + ": measured minus simulated";
      chart.note = found() ? "One of the channels that what was found moves most; half-hour means."
                           : "One of the channels that are off most; half-hour means.";
      chart.unit = at_.unit(c);
      chart.x = x;
      chart.series.push_back({"no error", {0.0}, SeriesRole::reference});
      chart.series.push_back({run_.before.empty() ? "twin" : "twin, fitted", curve(run_.residual_before, c),
                              found() ? SeriesRole::plain : SeriesRole::main});
      if (found()) chart.series.push_back({"with what was found", curve(run_.residual_after, c), SeriesRole::main});
      chart.bands.push_back({static_cast<double>(from.seconds) + bin_s * static_cast<double>(run_.locked_from()),
                             static_cast<double>(from.seconds) + bin_s * static_cast<double>(bins())});
      chart.band_name = "days locked away";
      input_.blocks.push_back(chart);
    }
  }

  void add_ranking() {
    PictureRow pictures;
    pictures.title = "What else could explain it";
    pictures.note =
        "Gain of each effect alone, before anything was added; from the responses to two magnitudes, so a first look "
        "and not the verdict. Blue: what was found.";
    std::vector<RankBar> bars;
    for (std::size_t i = 0; i < run_.verdict.ranking.size() && i < 10; ++i) {
      const gap::Score& score = run_.verdict.ranking[i];
      const std::string id = run_.responses.test.candidates[score.candidate].at.id();
      const bool is_found = std::any_of(run_.verdict.findings.begin(), run_.verdict.findings.end(),
                                        [&id](const gap::Finding& f) { return f.at.id() == id; });
      bars.push_back({id, score.gain, gap::gain_limit(run_.rules, run_.verdict.nulls, score.candidate), is_found});
    }
    if (bars.empty()) return;
    pictures.svg.push_back(rank_svg(bars, "limit of each effect"));
    input_.blocks.push_back(pictures);
  }

  void add_locked_days() {
    ReportTable table;
    table.title = fmt::format("The {} days that were locked away", locked_days());
    table.note =
        "The last days of the log, which nothing was fitted to. Root mean square error of the model alone, and mean of "
        "measured minus simulated: what anyone gets who runs it.";
    table.row_header = "channel";
    table.columns = {{"unit", "", 0, false},         {"RMSE, twin as given", "", 3, false},
                     {"RMSE, fitted", "", 3, false}, {"RMSE, with what was found", "", 3, false},
                     {"mean, fitted", "", 3, false}, {"mean, with what was found", "", 3, false}};
    const gap::ChannelErrors given = locked(run_.residual_given), before = locked(run_.residual_before),
                             after = locked(run_.residual_after);
    const auto row = [&](const std::string& name, const std::string& unit, std::array<double, 5> v, SeriesRole role) {
      TableRow r{name, {text_cell(unit)}, role, false};
      for (const double x : v) r.cells.push_back(number_cell(x));
      table.rows.push_back(r);
    };
    for (const int c : shown_) {
      row(channel_title(at_, c), at_.unit(c),
          {given.rmse(c), before.rmse(c), after.rmse(c), before.mean(c), after.mean(c)}, SeriesRole::plain);
    }
    const auto joint = [&](const char* name, const char* unit, int from, int to) {
      const double none = std::numeric_limits<double>::quiet_NaN();
      row(name, unit,
          {gap::joint_rmse(given, from, to), gap::joint_rmse(before, from, to), gap::joint_rmse(after, from, to), none,
           none},
          SeriesRole::main);
    };
    joint("all temperatures", "K", 0, at_.mau_temp() + 1);
    joint("all powers", "kW", at_.power(), at_.fcu_duty());
    input_.blocks.push_back(table);
  }

  void add_guideline() {
    using gap::Guideline14;
    ReportTable table;
    table.title = "The usual figures beside them";
    table.note = fmt::format(
        "ASHRAE Guideline 14, hourly means of the locked days; a model is usually accepted below {:.0f} % CV(RMSE) and "
        "{:.0f} % NMBE. Warning: a wrong model can pass. A room that is 2 K off is 8 % off in degrees Celsius, so "
        "kelvin and the verdict decide here, not these limits.",
        Guideline14::cv_rmse_limit_percent, Guideline14::nmbe_limit_percent);
    table.row_header = "model";
    table.columns = {{"room temperature, CV(RMSE)", "%", 1, false},
                     {"room temperature, NMBE", "%", 1, false},
                     {"power, CV(RMSE)", "%", 1, false},
                     {"power, NMBE", "%", 1, false},
                     {"within the limits", "", 0, false}};
    const auto row = [&](const char* name, const Eigen::MatrixXd& residual) {
      const Eigen::MatrixXd& measured = run_.loaded.data.test.measured;
      const Guideline14 temp = gap::guideline_14_room_temp(measured, residual, at_, run_.locked_from(), bins());
      const Guideline14 power = gap::guideline_14_power(measured, residual, at_, run_.locked_from(), bins());
      const char* verdict = temp.passes() && power.passes() ? "both"
                            : temp.passes()                 ? "room temperature"
                            : power.passes()                ? "power"
                                                            : "neither";
      table.rows.push_back({name,
                            {number_cell(temp.cv_rmse_percent), number_cell(temp.nmbe_percent),
                             number_cell(power.cv_rmse_percent), number_cell(power.nmbe_percent), text_cell(verdict)},
                            SeriesRole::plain,
                            false});
    };
    row("twin as given", run_.residual_given);
    if (!run_.before.empty()) row("fitted to the reference", run_.residual_before);
    if (found()) row("with what was found", run_.residual_after);
    table.rows.push_back(
        {"limit",
         {number_cell(Guideline14::cv_rmse_limit_percent), number_cell(Guideline14::nmbe_limit_percent),
          number_cell(Guideline14::cv_rmse_limit_percent), number_cell(Guideline14::nmbe_limit_percent),
          text_cell("–")},
         SeriesRole::reference,
         false});
    input_.blocks.push_back(table);
  }

  void add_ledger() {
    if (!run_.patched) {
      const bool unsure = found() && run_.verdict.kind != gap::VerdictKind::named;
      input_.blocks.push_back(
          ReportNote{"The twin was left as it is",
                     {unsure ? "Only a named effect is written into the twin. --best-guess writes the best guess."
                             : "Nothing was found that could be written into it."}});
      return;
    }
    ReportTable table;
    table.title = "What was written into the twin";
    table.note =
        "The ledger. twin-patch.json holds the change, ledger.json also the way back: "
        "airside gap revert ledger.json MODEL -o OUT.";
    table.row_header = "change";
    table.prose = true;
    for (const char* name : {"why", "magnitude", "in the model", "beside the model"}) {
      table.columns.push_back({name, "", 0, false});
    }
    for (std::size_t k = run_.patched->changes.size(); k-- > 0;) {  // findings first
      const gap::PatchedChange& change = run_.patched->changes[k];
      const bool parameter = k < run_.before.size();
      const double sd = parameter ? run_.parameters[k].sd : run_.verdict.findings[k - run_.before.size()].sd;
      std::string beside;
      for (const std::string& line : change.beside) beside += (beside.empty() ? "" : "; ") + line;
      table.rows.push_back({change.change.at.text(),
                            {text_cell(parameter ? "the reference period asks for it" : "found"),
                             text_cell(fmt::format("{:.3g}{} ± {:.2g}", change.change.magnitude,
                                                   gap::unit_suffix(*change.change.at.effect), 1.96 * sd)),
                             text_cell(edits_text(change.edits)), text_cell(beside.empty() ? "–" : beside)},
                            parameter ? SeriesRole::plain : SeriesRole::main,
                            false});
    }
    input_.blocks.push_back(table);
  }

  /// What the patch is worth to the controller.
  void add_retraining() {
    if (!run_.retraining) return;
    const gap::Retraining& r = *run_.retraining;
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
    input_.blocks.push_back(table);

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
    input_.blocks.push_back(chart);
  }

  static std::string edits_text(const std::vector<gap::ModelEdit>& edits) {
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

  void add_facts() {
    const auto period = [](const gap::Window& window, const gap::CleanLog& log) {
      return fmt::format("{}: {} to {}, {} days", log.place, date(window.recording.from),
                         date({window.recording.to().seconds - 1}), window.measured.rows() / gap::bins_per_day);
    };
    input_.command = run_.request.command;
    input_.facts = {{"site", run_.request.site},
                    {"model", run_.request.source.engine + " " + run_.request.source.model},
                    {"weather", run_.request.source.weather},
                    {"reference", period(run_.loaded.data.reference, run_.loaded.logs.reference)},
                    {"measured", period(run_.loaded.data.test, run_.loaded.logs.measured)},
                    {"effects tried", std::to_string(run_.responses.test.candidates.size() / 2)},
                    {"versions", hal::version_line("airside")}};
    if (run_.patched) {
      input_.facts.push_back({"model before", gap::model_digest(run_.patched->before)});
      input_.facts.push_back({"model after", gap::model_digest(run_.patched->after)});
    }
  }

  const GapRun& run_;
  sim::Channels at_;
  Eigen::Index first_;
  std::vector<int> shown_;
  ReportInput input_;
};

}  // namespace

ReportInput make_gap_report(const gap::GapRun& run) { return GapReport(run).make(); }

}  // namespace airside::tools
