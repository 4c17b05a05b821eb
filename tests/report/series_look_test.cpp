// Lines of a chart are told apart without colour: on the page, in pictures, and in the palette that both have.

#include <gtest/gtest.h>

#include <fstream>
#include <map>
#include <regex>
#include <set>
#include <sstream>

#include "report/synthetic_run.hpp"
#include "tools/report/charts/series_look.hpp"
#include "tools/report/charts/svg_chart.hpp"

namespace airside::tools {
namespace {

std::set<std::string> all_of(const std::string& text, const std::string& pattern) {
  const std::regex regex(pattern);
  std::set<std::string> found;
  for (std::sregex_iterator m(text.begin(), text.end(), regex); m != std::sregex_iterator(); ++m) found.insert((*m)[1]);
  return found;
}

/// The light half of palette.css: values by name.
std::map<std::string, std::string> palette() {
  std::ifstream file(std::string(AIRSIDE_SOURCE_DIR) + "/tools/report/palette.css");
  std::stringstream text;
  text << file.rdbuf();
  const std::string css = text.str();
  const std::string light = css.substr(0, css.find("@media"));
  std::map<std::string, std::string> values;
  const std::regex value("--([a-z0-9-]+):([^;]+);");
  for (std::sregex_iterator m(light.begin(), light.end(), value); m != std::sregex_iterator(); ++m)
    values[(*m)[1]] = (*m)[2];
  return values;
}

LineChart rooms_of(std::size_t count) {
  LineChart chart;
  chart.x = {0, 360};
  for (std::size_t i = 0; i < count; ++i)
    chart.series.push_back({"room " + std::to_string(i + 1), {20, 21}, SeriesRole::muted});
  chart.series.push_back({"mean", {20, 21}, SeriesRole::main});
  chart.series.push_back({"target", {22}, SeriesRole::reference});
  return chart;
}

void expect_own_patterns(const LineChart& chart) {
  std::set<std::string> dashes;
  for (const SeriesLook& look : looks_of(chart)) dashes.insert(look.dash);
  EXPECT_EQ(dashes.size(), chart.series.size()) << chart.title;
  const std::string svg = line_chart_svg(chart);
  for (const char* part :
       {"class=\"line [a-z0-9 ]*?(d(?:[0-9]+|ref))\"", "class=\"dash [a-z0-9 ]*?(d(?:[0-9]+|ref))\""})
    EXPECT_EQ(all_of(svg, part), dashes) << chart.title << ": curves and keys";
}

TEST(SeriesLook, GivesEveryLineOfEveryChartAPatternOfItsOwn) {
  RunRecord run = synthetic_run(1);
  run.losses = {{"total", run.confidence}};
  for (const char* name : {"short term", "deviation", "gradient", "residual", "reconstruction"})
    run.losses.push_back({name, run.confidence});
  std::size_t charts = 0;
  for (const ReportBlock& block : make_run_report(run).blocks) {
    const auto* chart = std::get_if<LineChart>(&block);
    if (chart == nullptr) continue;
    expect_own_patterns(*chart);
    ++charts;
  }
  EXPECT_GE(charts, 6U);
  expect_own_patterns(rooms_of(11));
}

TEST(SeriesLook, GivesNoTwoLinesOfManyOneColourAndPattern) {
  std::set<std::pair<std::string, std::string>> looks;
  const LineChart chart = rooms_of(40);
  for (const SeriesLook& look : looks_of(chart)) looks.insert({look.colour, look.dash});
  EXPECT_EQ(looks.size(), chart.series.size());
}

TEST(SeriesLook, OfARoomIsTheSameInEveryChart) {
  LineChart with_mean = rooms_of(5), alone = with_mean;
  alone.series.resize(5);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_EQ(looks_of(with_mean)[i].dash, looks_of(alone)[i].dash);
    EXPECT_EQ(looks_of(with_mean)[i].colour, looks_of(alone)[i].colour);
  }
  alone.series.resize(1);
  EXPECT_EQ(looks_of(alone)[0].dash, "d0") << "nothing to be told apart from";
}

TEST(SeriesLook, OfPicturesIsThatOfThePalette) {
  const auto values = palette();
  const std::string style = own_style;
  int colours = 0;
  std::set<std::string> patterns;
  for (const auto& [name, value] : values) {
    if (std::regex_match(name, std::regex("main|ref|c[0-9]"))) {
      EXPECT_NE(style.find("." + name + "{--c:" + value + "}"), std::string::npos) << name;
      ++colours;
    }
    if (!std::regex_match(name, std::regex("d([0-9]+|ref)"))) continue;
    EXPECT_TRUE(patterns.insert(value).second) << name << " is a pattern that there is already";
    const bool is_drawn = style.find("." + name + "{stroke-dasharray:" + value + "}") != std::string::npos;
    EXPECT_EQ(is_drawn, value != "none") << name;
  }
  EXPECT_EQ(colours, 10);
  EXPECT_EQ(patterns.size(), 13U);
}

}  // namespace
}  // namespace airside::tools
