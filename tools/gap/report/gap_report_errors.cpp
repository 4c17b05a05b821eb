// Where and when the model is off: maps, curves, ranking, locked days.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>

#include "tools/gap/report/gap_charts.hpp"
#include "tools/gap/report/gap_page.hpp"

namespace airside::tools {

namespace {

/// Largest common scale of the unit's rows that a few extremes do not spoil.
std::map<std::string, double> scales(const GapPage& page, const std::vector<const Eigen::MatrixXd*>& all) {
  std::map<std::string, std::vector<double>> sizes;
  for (const Eigen::MatrixXd* m : all) {
    for (const int c : page.shown) {
      for (const double x : m->row(c)) {
        if (std::isfinite(x)) sizes[page.at.unit(c)].push_back(std::abs(x));
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

HeatMap map_of_channels(const GapPage& page, const std::string& title, const gap::ErrorMap& errors,
                        const Eigen::MatrixXd& values, const std::map<std::string, double>& scale) {
  HeatMap map;
  map.title = title;
  map.columns = errors.groups;
  map.full_colour = scale;
  map.values.resize(std::ssize(page.shown), values.cols());
  for (std::size_t i = 0; i < page.shown.size(); ++i) {
    map.rows.push_back({channel_title(page.at, page.shown[i]), page.at.unit(page.shown[i])});
    map.values.row(static_cast<Eigen::Index>(i)) = values.row(page.shown[i]);
  }
  return map;
}

std::string scale_text(const std::map<std::string, double>& scale) {
  return fmt::format("Full colour: {:.2g} K, {:.2g} kW, {:.2g} of a duty.", scale.at("K"), scale.at("kW"),
                     scale.at("-"));
}

/// What news_before and news_after do not have.
std::string without_known(const GapPage& page) {
  return std::string("without what the reference days showed already") +
         (page.run.verdict.buildings > 0 ? " and all drawn buildings have" : "");
}

/// One figure: before and after, by one grouping, the mean or the RMSE.
template <class Grouped>
void add_map(const GapPage& page, ReportInput& input, const std::string& title, const std::string& note, bool mean,
             const Grouped& grouped, const std::function<void(HeatMap&)>& finish) {
  const gap::ErrorMap before = grouped(page.news_before), after = grouped(page.news_after);
  const Eigen::MatrixXd &b = mean ? before.mean : before.rmse, &a = mean ? after.mean : after.rmse;
  const auto scale = scales(page, {&b, &a});
  PictureRow pictures;
  pictures.title = title;
  pictures.note = note + " " + scale_text(scale);
  const auto draw = [&](const char* name, const gap::ErrorMap& errors, const Eigen::MatrixXd& values) {
    HeatMap map = map_of_channels(page, name, errors, values, scale);
    finish(map);
    pictures.svg.push_back(heat_map_svg(map));
  };
  draw(page.run.before.empty() ? "the twin" : "the twin, fitted to the reference", before, b);
  if (page.found()) draw("with what was found", after, a);
  input.blocks.push_back(pictures);
}

/// Channels that the findings moved most; without findings those that are off most.
std::vector<int> telling_channels(const GapPage& page) {
  std::vector<std::pair<double, int>> order;
  for (const int c : page.shown) {
    const std::string unit = page.at.unit(c);
    const double floor = unit == "K" ? 0.1 : unit == "kW" ? 0.2 : 0.1;
    double square = 0;
    int count = 0;
    for (Eigen::Index t = page.first; t < page.bins(); ++t) {
      const double x = page.found() ? page.news_before(t, c) - page.news_after(t, c) : page.news_before(t, c);
      if (!std::isfinite(x)) continue;
      square += x * x;
      ++count;
    }
    const double left = page.found() ? gap::errors_of(page.news_after, page.first, page.bins()).rmse(c) : 0;
    order.emplace_back(-std::sqrt(square / std::max(1, count)) / (left + floor), c);
  }
  std::sort(order.begin(), order.end());
  std::vector<int> channels;
  for (const auto& [size, c] : order) {
    if (channels.size() < 4) channels.push_back(c);
  }
  return channels;
}

/// Meter by meter; months only where the locked days hold two.
void add_meters(const GapPage& page, ReportInput& input) {
  using gap::Guideline14;
  ReportTable table;
  table.title = "The same, meter by meter";
  table.note = fmt::format(
      "Hourly means of the locked days, and energies of the months of which they hold {} or more, if there are "
      "two; monthly limits are {:.0f} % CV(RMSE) and {:.0f} % NMBE.",
      days_text(gap::MeterFigures::least_days), Guideline14::monthly_cv_rmse_limit_percent,
      Guideline14::monthly_nmbe_limit_percent);
  table.row_header = "meter and model";
  table.columns = {{"hourly, CV(RMSE)", "%", 1, false},
                   {"hourly, NMBE", "%", 1, false},
                   {"monthly, CV(RMSE)", "%", 1, false},
                   {"monthly, NMBE", "%", 1, false}};
  const gap::Window& test = page.run.loaded.data.test;
  const auto row = [&](int meter, const char* model, const Eigen::MatrixXd& residual) {
    const gap::MeterFigures f =
        gap::guideline_14_meter(test.measured, residual, test.recording, meter, page.run.locked_from(), page.bins());
    const auto monthly = [&](double value) { return f.monthly.count > 1 ? number_cell(value) : text_cell("–"); };
    table.rows.push_back({channel_title(page.at, meter) + ", " + model,
                          {number_cell(f.hourly.cv_rmse_percent), number_cell(f.hourly.nmbe_percent),
                           monthly(f.monthly.cv_rmse_percent), monthly(f.monthly.nmbe_percent)},
                          SeriesRole::plain,
                          false});
  };
  for (int meter = page.at.power(); meter < page.at.fcu_duty(); ++meter) {
    row(meter, "twin as given", page.run.residual_given);
    if (!page.run.before.empty()) row(meter, "fitted to the reference", page.run.residual_before);
    if (page.found()) row(meter, "with what was found", page.run.residual_after);
  }
  if (!table.rows.empty()) input.blocks.push_back(table);
}

}  // namespace

void add_maps(const GapPage& page, ReportInput& input) {
  const auto by_hour = [&page](const Eigen::MatrixXd& r) { return gap::errors_by_hour(r, page.first); };
  const auto by_weather = [&page](const Eigen::MatrixXd& r) {
    return gap::errors_by_weather(r, page.run.loaded.data.test.recording, page.first);
  };
  const auto by_day = [&page](const Eigen::MatrixXd& r) {
    return gap::errors_by_day(r, page.run.loaded.data.test.recording);
  };
  const auto hours = [](HeatMap& map) { map.column_unit = " h"; };
  add_map(page, input, "When the twin is wrong, and in which direction",
          "Mean of measured minus simulated by hour of day, all measured days but the first. Orange: measured more "
          "than the twin says; blue: less. Pictures and curves are " +
              without_known(page) + "; the tables below have the whole difference.",
          true, by_hour, hours);
  add_map(page, input, "How far the twin is off",
          "Root mean square error by hour of day, all measured days but the first.", false, by_hour, hours);
  add_map(page, input, "In which weather",
          "Mean of measured minus simulated. Cool, mild and warm: thirds of the measured outdoor temperatures; sunny: "
          "more than 300 W/m² straight from the sun.",
          true, by_weather, [](HeatMap&) {});
  add_map(page, input, "On which days", "Root mean square error by day.", false, by_day, [&page](HeatMap& map) {
    map.marked_from = static_cast<std::size_t>(page.run.locked_from() / gap::bins_per_day);
    map.mark = "locked away";
  });
}

void add_curves(const GapPage& page, ReportInput& input) {
  const CivilTime from = page.run.loaded.data.test.recording.from;
  constexpr double bin_s = 86400.0 / gap::bins_per_day;
  std::vector<double> x(static_cast<std::size_t>(page.bins()));
  for (std::size_t i = 0; i < x.size(); ++i) {
    x[i] = static_cast<double>(from.seconds) + bin_s * (static_cast<double>(i) + 0.5);
  }
  const auto curve = [](const Eigen::MatrixXd& residual, int c) {
    return std::vector<double>(residual.col(c).begin(), residual.col(c).end());
  };
  for (const int c : telling_channels(page)) {
    LineChart chart;
    chart.title = channel_title(page.at, c) + ": measured minus simulated";
    chart.note =
        page.found() ? "One of the channels that what was found moves most" : "One of the channels that are off most";
    chart.note += "; half-hour means, " + without_known(page) + ".";
    chart.unit = channel_unit(page.at, c);
    chart.x = x;
    chart.series.push_back({"no error", {0.0}, SeriesRole::reference});
    chart.series.push_back({page.run.before.empty() ? "twin" : "twin, fitted", curve(page.news_before, c),
                            page.found() ? SeriesRole::plain : SeriesRole::main});
    if (page.found()) chart.series.push_back({"with what was found", curve(page.news_after, c), SeriesRole::main});
    chart.bands.push_back({static_cast<double>(from.seconds) + bin_s * static_cast<double>(page.run.locked_from()),
                           static_cast<double>(from.seconds) + bin_s * static_cast<double>(page.bins())});
    chart.band_name = "days locked away";
    input.blocks.push_back(chart);
  }
}

void add_ranking(const GapPage& page, ReportInput& input) {
  PictureRow pictures;
  pictures.title = "What else could explain it";
  pictures.note =
      "Gain of each effect alone, before anything was added; from the responses to two magnitudes, so a first look "
      "and not the verdict. Blue: what was found.";
  std::vector<RankBar> bars;
  for (std::size_t i = 0; i < page.run.verdict.ranking.size() && i < 10; ++i) {
    const gap::Score& score = page.run.verdict.ranking[i];
    const std::string id = page.run.responses.test.candidates[score.candidate].at.id();
    const bool is_found = std::any_of(page.run.verdict.findings.begin(), page.run.verdict.findings.end(),
                                      [&id](const gap::Finding& f) { return f.at.id() == id; });
    bars.push_back({effect_title(page, id), score.log_likelihood_ratio,
                    gap::log_likelihood_limit(page.run.rules, page.run.verdict.nulls, score.candidate), is_found});
  }
  if (bars.empty()) return;
  pictures.svg.push_back(rank_svg(bars, "limit of each effect"));
  input.blocks.push_back(pictures);
}

void add_locked_days(const GapPage& page, ReportInput& input) {
  ReportTable table;
  table.title = page.locked_days() == 1 ? "The day that was locked away"
                                        : fmt::format("The {} that were locked away", days_text(page.locked_days()));
  table.note =
      "The last days of the log, which nothing was fitted to. Root mean square error of the model alone, and mean of "
      "measured minus simulated: what anyone gets who runs it.";
  table.row_header = "channel";
  table.columns = {{"unit", "", 0, false},         {"RMSE, twin as given", "", 3, false},
                   {"RMSE, fitted", "", 3, false}, {"RMSE, with what was found", "", 3, false},
                   {"mean, fitted", "", 3, false}, {"mean, with what was found", "", 3, false}};
  const gap::ChannelErrors given = page.locked(page.run.residual_given), before = page.locked(page.run.residual_before),
                           after = page.locked(page.run.residual_after);
  const auto row = [&](const std::string& name, const std::string& unit, std::array<double, 5> v, SeriesRole role) {
    TableRow r{name, {text_cell(unit)}, role, false};
    for (const double x : v) r.cells.push_back(number_cell(x));
    table.rows.push_back(r);
  };
  for (const int c : page.shown) {
    row(channel_title(page.at, c), channel_unit(page.at, c),
        {given.rmse(c), before.rmse(c), after.rmse(c), before.mean(c), after.mean(c)}, SeriesRole::plain);
  }
  const auto joint = [&](const char* name, const char* unit, int from, int to) {
    const double none = std::numeric_limits<double>::quiet_NaN();
    row(name, unit,
        {gap::joint_rmse(given, from, to), gap::joint_rmse(before, from, to), gap::joint_rmse(after, from, to), none,
         none},
        SeriesRole::main);
  };
  joint("all temperatures", "K", 0, page.at.mau_temp() + 1);
  joint("all powers", "kW", page.at.power(), page.at.fcu_duty());
  input.blocks.push_back(table);
}

void add_guideline(const GapPage& page, ReportInput& input) {
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
    const Eigen::MatrixXd& measured = page.run.loaded.data.test.measured;
    const Guideline14 temp =
        gap::guideline_14_room_temp(measured, residual, page.at, page.run.locked_from(), page.bins());
    const Guideline14 power = gap::guideline_14_power(measured, residual, page.at, page.run.locked_from(), page.bins());
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
  row("twin as given", page.run.residual_given);
  if (!page.run.before.empty()) row("fitted to the reference", page.run.residual_before);
  if (page.found()) row("with what was found", page.run.residual_after);
  table.rows.push_back(
      {"limit",
       {number_cell(Guideline14::cv_rmse_limit_percent), number_cell(Guideline14::nmbe_limit_percent),
        number_cell(Guideline14::cv_rmse_limit_percent), number_cell(Guideline14::nmbe_limit_percent), text_cell("–")},
       SeriesRole::reference,
       false});
  input.blocks.push_back(table);
  add_meters(page, input);
}

}  // namespace airside::tools
