// Escaping, ticks and numbers.

#include <gtest/gtest.h>

#include <cmath>

#include "tools/report/charts/downsample.hpp"
#include "tools/report/charts/report_text.hpp"

namespace airside::tools {
namespace {

TEST(ReportText, EscapesEveryCharacterThatMarkupGivesMeaning) {
  EXPECT_EQ(escape_markup("<b a='1' c=\"2\">&</b>"), "&lt;b a=&#39;1&#39; c=&quot;2&quot;&gt;&amp;&lt;/b&gt;");
  EXPECT_EQ(escape_markup(std::string("a\x01\x00z", 4)), "az");
  EXPECT_EQ(escape_markup("25 °C"), "25 °C");
}

TEST(ReportText, RepairsTextThatIsNotUtf8) {
  const std::string bad = "\xEF\xBF\xBD";
  EXPECT_EQ(valid_utf8("caf\xE9"), "caf" + bad);
  EXPECT_EQ(valid_utf8("\xC0\xAF"), bad + bad);            // overlong
  EXPECT_EQ(valid_utf8("\xED\xA0\x80"), bad + bad + bad);  // surrogate
  EXPECT_EQ(valid_utf8("\xF0\x9F\x8C\xA1"), "\xF0\x9F\x8C\xA1");
  EXPECT_EQ(valid_utf8("\xF0\x9F\x8C"), bad + bad + bad);  // cut off
}

TEST(ReportText, JsonInAScriptCannotCloseItsElement) {
  EXPECT_EQ(escape_script_json("\"</script><!--&\""), "\"\\u003c/script\\u003e\\u003c!--\\u0026\"");
  EXPECT_EQ(escape_script_json("\"\xE2\x80\xA8\xE2\x80\xA9°\""), "\"\\u2028\\u2029°\"");
}

TEST(ReportText, SlugsAreSafeFileNames) {
  EXPECT_EQ(slug("Room temperature"), "room-temperature");
  EXPECT_EQ(slug("../../etc/passwd"), "etc-passwd");
  EXPECT_EQ(slug("温度"), "chart");
  EXPECT_LE(slug(std::string(500, 'a')).size(), 48u);
}

TEST(ReportText, NumbersAreSetAsTypeNotAsCode) {
  EXPECT_EQ(number_text(-0.5, 2), "−0.50");
  EXPECT_EQ(number_text(-0.0001, 2), "0.00");
  EXPECT_EQ(number_text(1234.5, 1), "1234.5");
  EXPECT_EQ(number_text(1234567, 0),
            "1\xE2\x80\xAF"
            "234\xE2\x80\xAF"
            "567");
  EXPECT_EQ(number_text(std::nan(""), 2), "–");
}

TEST(ReportText, TicksAreRoundAndInside) {
  EXPECT_EQ(round_ticks(0, 10, 5), (std::vector<double>{0, 2, 4, 6, 8, 10}));
  const auto ticks = round_ticks(24.93, 25.61, 6);
  EXPECT_GE(ticks.front(), 24.93);
  EXPECT_LE(ticks.back(), 25.61);
  EXPECT_EQ(tick_text(25.2, 0.2), "25.2");
  EXPECT_EQ(round_ticks(3, 3, 5).size(), 1u);
}

TEST(ReportText, TimesAreThoseOfTheOperatorsPage) {
  const CivilTime t{1628253000};  // 2021-08-06T12:30:00
  EXPECT_EQ(date_text(t), "2021-08-06");
  EXPECT_EQ(minute_text(t), "2021-08-06 12:30");
  EXPECT_EQ(day_text(t), "08-06");
  EXPECT_EQ(days_text(1), "1 day");
  EXPECT_EQ(days_text(0), "0 days");
  EXPECT_EQ(days_text(12), "12 days");
}

TEST(Downsample, KeepsEveryPeakOfEverySeries) {
  LineChart chart;
  ChartSeries up{"up", {}, SeriesRole::plain, false}, down = up, level = up;
  level.y = {1};
  for (int i = 0; i < 50000; ++i) {
    chart.x.push_back(i);
    up.y.push_back(i == 31415 ? 9 : 0);
    down.y.push_back(i == 27182 ? -9 : i < 100 ? std::nan("") : 0);
  }
  chart.series = {up, down, level};
  const LineChart small = downsample(chart, 2000);
  EXPECT_LE(small.x.size(), 2000u);
  EXPECT_EQ(*std::max_element(small.series[0].y.begin(), small.series[0].y.end()), 9);
  EXPECT_EQ(std::count(small.series[1].y.begin(), small.series[1].y.end(), -9), 1);
  EXPECT_TRUE(std::isnan(small.series[1].y[0]));
  EXPECT_EQ(small.series[2].y.size(), 1u);
  for (std::size_t i = 1; i < small.x.size(); ++i) ASSERT_GT(small.x[i], small.x[i - 1]);
  EXPECT_EQ(downsample(chart, 60000).x.size(), 50000u);
}

}  // namespace
}  // namespace airside::tools
