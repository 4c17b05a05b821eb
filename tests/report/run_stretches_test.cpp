// What the controller did, and why: behind the charts, in a list, in the words of the operator's page.

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "hal/points/point_map.hpp"
#include "report/synthetic_run.hpp"
#include "tools/report/charts/svg_chart.hpp"
#include "tools/report/report.hpp"
#include "tools/report/run_stretches.hpp"

namespace airside::tools {
namespace {

/// Two days, in them an hour of release.
RunRecord with_an_hour_of_release() {
  RunRecord r = synthetic_run(2);
  r.mode.assign(r.row_time.size(), "learn");
  r.reason.assign(r.row_time.size(), "none");
  r.fault.assign(r.row_time.size(), "none");
  for (std::size_t i = 100; i < 110; ++i) {
    r.mode[i] = "release";
    r.reason[i] = "overridden";
  }
  return r;
}

TEST(RunStretches, AnHourOfReleaseStandsBehindTheCurvesWhereItsSpikeIs) {
  const RunRecord r = with_an_hour_of_release();
  int shaded = 0;
  for (const ReportBlock& block : make_run_report(r).blocks) {
    const auto* chart = std::get_if<LineChart>(&block);
    if (chart == nullptr || chart->stretches.empty()) continue;
    ++shaded;
    ASSERT_EQ(chart->stretches.size(), 1U) << chart->title;
    const ChartStretch& stretch = chart->stretches[0];
    EXPECT_EQ(stretch.from, static_cast<double>(r.row_time[100].seconds));
    EXPECT_EQ(stretch.to, static_cast<double>(r.row_time[110].seconds));
    EXPECT_EQ(stretch.kind, "release");
    EXPECT_EQ(stretch.name, "Released");
    EXPECT_EQ(stretch.why, "overridden");
    const std::string svg = line_chart_svg(*chart);
    EXPECT_NE(svg.find("class=\"stretch release\""), std::string::npos);
    EXPECT_NE(svg.find("<title>Released: overridden</title>"), std::string::npos);
    EXPECT_NE(svg.find(">Released</text>"), std::string::npos) << "the key";
  }
  EXPECT_EQ(shaded, 4) << "rooms, setpoint, power, outdoor";
  const std::string page = report_html(make_run_report(r));
  EXPECT_NE(page.find("<ul class=\"stretches\"><li><i class=\"release\"></i>Released</li></ul>"), std::string::npos);
}

TEST(RunStretches, UndisturbedLearningIsNotShadedAndAnAlarmWhileItLearnsIs) {
  RunRecord r = with_an_hour_of_release();
  r.mode.assign(r.row_time.size(), "learn");
  r.reason.assign(r.row_time.size(), "none");
  EXPECT_TRUE(stretches_of(r).empty());
  EXPECT_FALSE(events_table(r));
  r.reason[7] = "setpoint altered";
  r.fault[9] = "learning rejected";
  const auto stretches = stretches_of(r);
  ASSERT_EQ(stretches.size(), 1U) << "an update that was refused is no alarm";
  EXPECT_EQ(stretches[0].kind, "alarm");
  EXPECT_EQ(stretches[0].name, "Controls and learns, with an alarm");
}

TEST(RunStretches, TheListSaysReasonFaultAndSignal) {
  RunRecord r = with_an_hour_of_release();
  r.signal.assign(r.row_time.size(), "");
  for (std::size_t i = 20; i < 25; ++i) {
    r.mode[i] = "expert";
    r.reason[i] = "signal lost";
    r.fault[i] = "not finite";
    r.signal[i] = "room_temp_2";
  }
  const auto table = events_table(r);
  ASSERT_TRUE(table);
  ASSERT_EQ(table->rows.size(), 2U);
  EXPECT_EQ(table->rows[0].name, "2021-07-01 02:00");
  EXPECT_EQ(table->rows[0].cells[0].text, "2021-07-01 02:30");
  EXPECT_EQ(table->rows[0].cells[2].text, "Schedule");
  EXPECT_EQ(table->rows[0].cells[3].text, "signal lost: a signal is gone for longer than it may be held");
  EXPECT_EQ(table->rows[0].cells[4].text, "not finite: room_temp_2");
  EXPECT_EQ(table->rows[1].cells[3].text, "overridden: somebody else has set the setpoint");
  EXPECT_EQ(table->rows[1].cells[4].text, "");
}

TEST(RunStretches, WordsOfModesAreThoseOfTheOperatorsPage) {
  std::ifstream file(std::string(AIRSIDE_SOURCE_DIR) + "/firmware/page/web/texts/en.json");
  const auto words = nlohmann::json::parse(file);
  for (const char* mode : {"learn", "run", "expert", "release"})
    EXPECT_EQ(mode_words(mode), words.at(std::string("badge.") + mode).get<std::string>());
  EXPECT_EQ(reason_words("overridden"), "overridden: " + words.at("reason.overridden.why").get<std::string>());
}

/// Rows of four rooms that all move, without a fault.
std::vector<hal::LogRow> moving_rows(const hal::TopologyCounts& counts) {
  std::vector<hal::LogRow> rows;
  for (int t = 0; t < 20; ++t) {
    hal::LogRow row = hal::make_log_row(counts);
    row.time = {t * row_s};
    for (std::size_t i = 0; i < row.value.size(); ++i) row.value[i] = 24 + 0.01 * t + 0.1 * static_cast<double>(i);
    row.controller.fault = "none";
    rows.push_back(row);
  }
  return rows;
}

TEST(RunStretches, NameTheSignalThatAFaultIsAbout) {
  hal::TopologyCounts counts;
  counts.vavs = 4;
  counts.powers = 1;
  std::vector<hal::LogRow> rows = moving_rows(counts);
  for (const std::string& signal : signals_at_fault(counts, rows)) EXPECT_EQ(signal, "");

  rows[5].value[1] = std::nan("");
  rows[5].controller.fault = rows[6].controller.fault = "not finite";
  for (hal::LogRow& row : rows) row.value[3] = std::nan("");  // never there
  EXPECT_EQ(signals_at_fault(counts, rows)[5], "room_temp_2");
  EXPECT_EQ(signals_at_fault(counts, rows)[6], "room_temp_2") << "back before the next decision";
  EXPECT_EQ(signals_at_fault(counts, rows)[7], "");

  rows = moving_rows(counts);
  for (std::size_t t = 8; t < rows.size(); ++t) rows[t].value[2] = rows[8].value[2];
  rows[15].controller.fault = "stuck";
  EXPECT_EQ(signals_at_fault(counts, rows)[15], "room_temp_3");

  rows = moving_rows(counts);
  rows[3].value[0] = 31;
  rows[3].controller.fault = "disagrees with the other rooms";
  EXPECT_EQ(signals_at_fault(counts, rows)[3], "room_temp_1");
  rows[4].controller.fault = "learning rejected";
  rows[4].value[0] = std::nan("");
  EXPECT_EQ(signals_at_fault(counts, rows)[4], "") << "no fault of a signal";
}

}  // namespace
}  // namespace airside::tools
