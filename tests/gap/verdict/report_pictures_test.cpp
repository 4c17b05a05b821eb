// The pictures of a gap report show the differences that the verdict was drawn from; the tables the whole ones.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <variant>

#include "sim/rc/rc_room_file.hpp"
#include "tools/gap/model/engine.hpp"
#include "tools/gap/report/gap_page.hpp"

namespace airside::tools {
namespace {

using Eigen::Index;

/// A run of four days whose plain differences are 1 (before) and 0.8 (after), and the verdict's 0.6 and 0.1; channel 1
/// is no evidence.
gap::GapRun a_run(int buildings) {
  gap::GapRun run;
  run.loaded.engine = std::make_unique<gap::RcEngine>(sim::load_room("301"));
  const Index bins = 4 * gap::bins_per_day, channels = run.channels().count();
  const auto all = [&](double value) { return Eigen::MatrixXd::Constant(bins, channels, value).eval(); };
  run.residual_given = run.residual_before = all(1);
  run.residual_after = all(0.8);
  run.verdict.residual_before = all(0.6);
  run.verdict.residual_after = all(0.1);
  run.verdict.residual_before.col(1).setConstant(std::numeric_limits<double>::quiet_NaN());
  run.verdict.residual_after.col(1).setConstant(std::numeric_limits<double>::quiet_NaN());
  run.verdict.buildings = buildings;
  run.loaded.data.test.recording.from = sim::civil_midnight(2021, 7, 1);
  run.loaded.data.test.measured = all(20);
  run.verdict.findings.emplace_back();
  return run;
}

TEST(GapReportPictures, HaveTheVerdictsDifferencesWhereAChannelIsEvidence) {
  const gap::GapRun run = a_run(24);
  const GapPage page(run);
  for (Index c = 0; c < page.news_before.cols(); ++c) {
    EXPECT_EQ(page.news_before(5, c), c == 1 ? 1 : 0.6) << c;
    EXPECT_EQ(page.news_after(5, c), c == 1 ? 0.8 : 0.1) << c;
  }
  EXPECT_EQ(page.shown.size(), static_cast<std::size_t>(page.news_before.cols()));
}

TEST(GapReportPictures, HaveThePlainOnesWhereTheVerdictHasNone) {
  gap::GapRun run = a_run(0);
  run.verdict.residual_before.resize(0, 0);
  run.verdict.residual_after.resize(0, 0);
  const GapPage page(run);
  EXPECT_EQ(page.news_before, run.residual_before);
  EXPECT_EQ(page.news_after, run.residual_after);
}

TEST(GapReportPictures, CurvesShowThemAndSayWhatWasTakenOff) {
  for (const int buildings : {0, 24}) {
    const gap::GapRun run = a_run(buildings);
    ReportInput input;
    add_curves(GapPage(run), input);
    ASSERT_FALSE(input.blocks.empty());
    for (const ReportBlock& block : input.blocks) {
      const auto& chart = std::get<LineChart>(block);
      ASSERT_EQ(chart.series.size(), 3U);
      const bool evidence = chart.series[1].y[5] != 1;
      EXPECT_EQ(chart.series[1].y[5], evidence ? 0.6 : 1) << chart.title;
      EXPECT_EQ(chart.series[2].y[5], evidence ? 0.1 : 0.8) << chart.title;
      EXPECT_NE(chart.note.find("without what the reference days showed already"), std::string::npos) << chart.note;
      EXPECT_EQ(chart.note.find("drawn buildings") != std::string::npos, buildings > 0) << chart.note;
    }
  }
}

TEST(GapReportPictures, HeadlineShowsThatTheGapShrinksAsTheVerdictSawIt) {
  const gap::GapRun run = a_run(24);
  ReportInput input;
  add_figures(GapPage(run), input);
  for (const KeyFigure& figure : input.figures) {
    if (figure.label != "powers, locked days") continue;
    EXPECT_EQ(figure.value, "0.10");
    EXPECT_EQ(figure.note, "0.60 without what was found");
    return;
  }
  ADD_FAILURE() << "no figure of the powers";
}

}  // namespace
}  // namespace airside::tools
