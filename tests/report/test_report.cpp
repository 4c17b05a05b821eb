// The page's text: complete, small, safe, and refused when its parts do not fit.

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <regex>
#include <sstream>

#include "hal/text/input_error.hpp"
#include "report/synthetic_run.hpp"
#include "tools/report/charts/report_text.hpp"
#include "tools/report/charts/svg_chart.hpp"
#include "tools/report/report.hpp"

namespace airside::tools {
namespace {

std::size_t count_of(const std::string& text, const std::string& part) {
  std::size_t n = 0;
  for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + part.size())) ++n;
  return n;
}

TEST(Report, HoldsEverythingNeededToRepeatTheRun) {
  const RunRecord run = synthetic_run();
  const std::string page = report_html(make_run_report(run));
  for (const std::string& text :
       {run.site, run.plant, run.weather, run.seeds, run.versions, run.weights_digest, run.command}) {
    EXPECT_NE(page.find(text), std::string::npos) << text;
  }
  EXPECT_NE(page.find("Copyright (c) 2022 Leon Sorokin"), std::string::npos);
}

TEST(Report, SaysInPlainWordsHowItWent) {
  const ReportInput input = make_run_report(synthetic_run());
  EXPECT_NE(
      input.headline.find("Over 14 days the mean of the five rooms was 0.06 K from the 25.25 °C target on average "
                          "in working hours, and 0.09 K on the worst day."),
      std::string::npos)
      << input.headline;
  EXPECT_NE(input.headline.find("The expert schedule was 1.78 K from it on the same days"), std::string::npos)
      << input.headline;
  EXPECT_NE(input.headline.find("29.2 kWh of electricity a day, this control 28.9 kWh."), std::string::npos)
      << input.headline;
}

TEST(Report, PraisesNoMethodThatFails) {
  for (const MethodResult& method : synthetic_run(2).methods) {
    RunRecord run = synthetic_run(2);
    run.methods = {{method.name, MethodResult::Kind::ours, method.runs}};
    const std::string text = make_run_report(run).headline;
    const double off = spread_of(method.runs, &Metrics::dae_degc).mean;
    const double worst = spread_of(method.runs, &Metrics::me_degc).mean;
    const std::string said = "the mean of the five rooms was " + number_text(off, 2) +
                             " K from the 25.25 °C target on average in working hours, and " + number_text(worst, 2) +
                             " K on the worst day.";
    EXPECT_NE(text.find(said), std::string::npos) << method.name << ": " << text;
    EXPECT_EQ(text.find("within"), std::string::npos) << method.name << ": " << text;
  }
  RunRecord day = synthetic_run(1);
  day.methods.resize(1);
  EXPECT_NE(make_run_report(day).headline.find("Over 1 day the mean"), std::string::npos);
}

TEST(Report, HasDifferencesInKelvinAndTemperaturesInDegrees) {
  const std::string page = report_html(make_run_report(synthetic_run(2)));
  EXPECT_EQ(page.find("°C h"), std::string::npos);
  EXPECT_EQ(page.find("DAE, °C"), std::string::npos);
  EXPECT_EQ(page.find("<span class=\"unit\">°C</span>"), std::string::npos)
      << "no table and no figure is a temperature";
  for (const char* text : {"K h a day", "DAE, K", "\"unit\":\"°C\"", "25.25&nbsp;°C", "2021-07-01 to 2021-07-02"})
    EXPECT_NE(page.find(text), std::string::npos) << text;
}

TEST(Report, OfAFortnightAtSixMinutesStaysBelowTwoMegabytes) {
  const std::string page = report_html(make_run_report(synthetic_run(14)));
  EXPECT_LT(page.size(), 2'000'000u);
  EXPECT_GT(page.size(), 100'000u);
  // A year too, at the price of points.
  EXPECT_LT(report_html(make_run_report(synthetic_run(365))).size(), 3'000'000u);
}

TEST(Report, LoadsNothingFromElsewhere) {
  const std::string page = report_html(make_run_report(synthetic_run()));
  const std::regex fetch(
      R"((src|href|action|poster)\s*=\s*["']?\s*(https?:|//)|@import|url\(\s*["']?(https?:|//)|<link|<iframe|<img)",
      std::regex::icase);
  // Past the policy and licence, the vendored script is the only large text; it is searched as well.
  EXPECT_FALSE(std::regex_search(page, fetch));
  EXPECT_NE(page.find("default-src 'none'"), std::string::npos);
}

TEST(Report, TextsOfASiteFileCannotBecomeMarkupOrScript) {
  const std::string attack = "</script><script>document.title='owned'</script><img src=x onerror=alert(1)>\"'&";
  RunRecord run = synthetic_run(1);
  run.site = run.plant = run.weather = run.seeds = run.versions = run.weights_digest = run.command = attack;
  for (std::string& name : run.room_names) name = attack;
  for (NamedValues& room : run.room_temp_degc) room.name = attack;
  for (NamedValues& power : run.power_kw) power.name = attack;
  for (NamedValues& loss : run.losses) loss.name = attack;
  for (MethodResult& method : run.methods) method.name = attack;
  run.more_facts = {{attack, attack}};
  const ReportInput input = make_run_report(run);
  const std::string page = report_html(input);
  EXPECT_EQ(page.find("<script>document"), std::string::npos);
  EXPECT_EQ(page.find("<img"), std::string::npos);
  EXPECT_EQ(count_of(page, "</script>"), 2u);
  for (const ReportBlock& block : input.blocks) {
    std::string svg;
    if (const auto* line = std::get_if<LineChart>(&block)) svg = line_chart_svg(*line);
    if (const auto* bars = std::get_if<BarChart>(&block)) svg = bar_chart_svg(*bars);
    EXPECT_EQ(svg.find("<script"), std::string::npos);
    EXPECT_EQ(svg.find("<img"), std::string::npos);
  }
}

TEST(Report, MarksTheBestOfEachColumnAmongThoseThatCompete) {
  std::vector<MethodResult> methods = {{"ours", MethodResult::Kind::ours, {synthetic_metrics(2, 0.05, 0.2, 28)}},
                                       {"peer", MethodResult::Kind::peer, {synthetic_metrics(2, 0.09, 0.1, 28)}},
                                       {"floor", MethodResult::Kind::floor, {synthetic_metrics(2, 0.01, 0.01, 28)}}};
  ReportInput input;
  input.blocks = {methods_table(methods)};
  const std::string page = report_html(input);
  EXPECT_NE(page.find("<b>" + number_text(methods[0].runs[0].dae_degc, 3)), std::string::npos);  // least DAE
  EXPECT_NE(page.find("<b>0.100</b>"), std::string::npos);  // the peer the least DARV
  EXPECT_EQ(page.find("<b>0.010</b>"), std::string::npos);  // the floor is no competitor
}

TEST(Report, TheScheduleMayHaveTheBestOfAColumn) {
  const std::vector<MethodResult> methods = {
      {"ours", MethodResult::Kind::ours, {synthetic_metrics(2, 0.05, 0.2, 28)}},
      {"expert", MethodResult::Kind::schedule, {synthetic_metrics(2, 1.7, 0.0, 28)}}};
  ReportInput input;
  input.blocks = {methods_table(methods)};
  const std::string page = report_html(input);
  EXPECT_NE(page.find("<b>0.000</b>"), std::string::npos) << "its setpoint never moves";
  EXPECT_EQ(page.find("standard deviation"), std::string::npos) << "of one run there is none";
  input.blocks = {methods_table(synthetic_run(2).methods)};
  EXPECT_NE(report_html(input).find("standard deviation"), std::string::npos);
}

TEST(Report, AnHourOfReleaseAndABoxThatClosesAreSeen) {
  RunRecord r = synthetic_run(2);
  const std::size_t rows = r.row_time.size();
  r.mode.assign(rows, "learn");
  r.reason.assign(rows, "none");
  for (std::size_t i = 100; i < 110; ++i) {
    r.mode[i] = "release";
    r.reason[i] = "released by hand";
  }
  r.boxes_on = {{"west 1", std::vector<double>(rows, 1)}, {"core", std::vector<double>(rows, 1)}};
  for (std::size_t i = 50; i < 60; ++i) r.boxes_on[1].values[i] = 0;
  const ReportInput page = make_run_report(r);
  const LineChart* boxes = nullptr;
  const LineChart* modes = nullptr;
  const ReportTable* events = nullptr;
  for (const ReportBlock& block : page.blocks) {
    if (const auto* chart = std::get_if<LineChart>(&block)) {
      if (chart->title == "Closed boxes") boxes = chart;
      if (chart->title == "Control mode") modes = chart;
    }
    const auto* table = std::get_if<ReportTable>(&block);
    if (table != nullptr && table->row_header == "from") events = table;
  }
  ASSERT_TRUE(boxes != nullptr && modes != nullptr && events != nullptr);
  EXPECT_EQ(boxes->y_names, (std::vector<std::string>{"west 1", "core"}));
  EXPECT_EQ(boxes->series[0].y[55], 0);
  EXPECT_EQ(boxes->series[1].y[49], 1);
  EXPECT_EQ(boxes->series[1].y[55], 1.7);
  EXPECT_EQ(modes->series[0].y[99], 3);
  EXPECT_EQ(modes->series[0].y[105], 0);
  ASSERT_EQ(events->rows.size(), 1U);
  EXPECT_EQ(events->rows[0].name, "2021-07-01 10:00");
  EXPECT_EQ(events->rows[0].cells[0].text, "2021-07-01 11:00");
  EXPECT_EQ(events->rows[0].cells[1].text, "1.0 h");
  EXPECT_EQ(events->rows[0].cells[3].text, "released by hand: an operator has released the AHU");
  const std::string svg = line_chart_svg(*boxes);
  EXPECT_NE(svg.find(">west 1</text>"), std::string::npos);
  EXPECT_NE(svg.find(">07-02</text>"), std::string::npos) << "days as in the page";

  const ReportInput quiet = make_run_report(synthetic_run(2));
  for (const ReportBlock& block : quiet.blocks) {
    const auto* table = std::get_if<ReportTable>(&block);
    EXPECT_FALSE(table != nullptr && table->row_header == "from") << "nothing happened";
  }
}

TEST(Report, ShadesWorkingHoursOfWorkingDaysOnly) {
  MetricsSettings settings;
  const CivilTime monday{4 * 86400};
  EXPECT_EQ(working_hours(monday, {monday.seconds + 7 * 86400 - 1}, settings).size(), 7u);
  settings.weekdays_only = true;
  const auto bands = working_hours(monday, {monday.seconds + 7 * 86400 - 1}, settings);
  ASSERT_EQ(bands.size(), 5u);
  EXPECT_EQ(bands[0].from, 4 * 86400 + 7 * 3600);
  EXPECT_EQ(bands[0].to, 4 * 86400 + 19 * 3600);
}

TEST(Report, RefusesPartsThatDoNotFit) {
  ReportInput input;
  LineChart chart;
  chart.title = "crooked";
  chart.x = {1, 2, 3};
  chart.series = {{"two of three", {1, 2}, SeriesRole::plain, false}};
  input.blocks = {chart};
  try {
    report_html(input);
    FAIL() << "accepted a series that is too short";
  } catch (const hal::InputError& error) {
    EXPECT_NE(std::string(error.what()).find("two of three"), std::string::npos);
  }
  chart.series[0].y.push_back(3);
  chart.x = {1, 3, 2};
  input.blocks = {chart};
  EXPECT_THROW(report_html(input), hal::InputError);
  input.blocks = {BarChart{"b", "", "", {"one", "two"}, {{"g", {1}, {}, SeriesRole::plain}}, 2}};
  EXPECT_THROW(report_html(input), hal::InputError);
  input.blocks = {ReportTable{"t", "", "row", false, {{"c", "", 2, true}}, {{"r", {}, SeriesRole::plain}}}};
  EXPECT_THROW(report_html(input), hal::InputError);
  RunRecord run = synthetic_run(1);
  run.methods.erase(run.methods.begin());
  EXPECT_THROW(make_run_report(run), hal::InputError);
}

TEST(Report, ShowsGapsForValuesThatAreNotNumbersAndForNonPositiveOnesOnALogAxis) {
  LineChart chart;
  chart.title = "gaps";
  chart.log_axis = true;
  chart.x = {0, 360, 720, 1080};
  chart.series = {{"loss", {0.1, std::nan(""), 0.0, 0.2}, SeriesRole::plain, false}};
  ReportInput input;
  input.blocks = {chart};
  EXPECT_NE(report_html(input).find("\"y\":[0.1,null,null,0.2]"), std::string::npos);
  const std::string svg = line_chart_svg(chart);
  EXPECT_EQ(svg.find("nan"), std::string::npos);
  EXPECT_EQ(svg.find("inf"), std::string::npos);
}

TEST(Report, AnEmptyReportIsStillAPage) {
  const std::string page = report_html({});
  EXPECT_NE(page.find("</html>"), std::string::npos);
}

TEST(Report, WritesThePageAndOneSvgAChart) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "airside_report_files" / "deep";
  std::filesystem::remove_all(folder);
  const auto written = write_report(folder / "report.html", make_run_report(synthetic_run(2)));
  EXPECT_EQ(written.front(), folder / "report.html");
  EXPECT_EQ(written.size(), 8u);  // 6 line charts, 1 bar chart
  for (const auto& path : written) {
    std::ifstream file(path);
    std::stringstream text;
    text << file.rdbuf();
    EXPECT_GT(text.str().size(), 500u) << path;
    if (path.extension() == ".svg") {
      EXPECT_TRUE(text.str().starts_with("<svg xmlns=")) << path;
      EXPECT_EQ(count_of(text.str(), "<g>") + count_of(text.str(), "<g "), count_of(text.str(), "</g>")) << path;
    }
  }
  for (const auto& entry : std::filesystem::directory_iterator(folder)) EXPECT_NE(entry.path().extension(), ".part");
  EXPECT_THROW(write_report("/proc/no/report.html", make_run_report(synthetic_run(1))), hal::InputError);
}

}  // namespace
}  // namespace airside::tools
