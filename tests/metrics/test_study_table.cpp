// The study's table: its columns, its ratios, and the days on which the product lost to the tuned integral.

#include <gtest/gtest.h>

#include <algorithm>
#include <sstream>

#include "tools/cli/command.hpp"
#include "tools/study/control_methods.hpp"
#include "tools/study/table.hpp"

namespace airside::tools {
namespace {

nlohmann::json run_with(double dae, double darv, const std::vector<double>& days) {
  Metrics m;
  m.dae_degc = dae;
  m.darv_degc = darv;
  m.cdh_degch = 512;
  m.hdh_degch = 3.5;
  m.degree_hours_degch = 1.5;
  m.degree_hours_above_degch = 0.75;
  for (const double d : days) {
    m.days.emplace_back();
    m.days.back().dae_degc = d;
  }
  return json_of(m);
}

TEST(WorseDays, CountsTheDaysAboveTheMarginAndFindsTheWorst) {
  const std::vector<Outcome> outcomes = {
      {{"ours-product", run_with(0, 0, {0.05, 0.10, 0.13})}, {"integral-tuned", run_with(0, 0, {0.08, 0.09, 0.10})}},
      {{"ours-product", run_with(0, 0, {0.10, 0.10})}, {"integral-tuned", run_with(0, 0, {0.09, 0.05})}},
      {{"ours-product", run_with(0, 0, {9.0})}},  // without the peer: no day
  };
  const auto found = worse_days(outcomes, "ours-product", "integral-tuned", 0.02);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->days, 5);
  EXPECT_EQ(found->worse, 2);
  EXPECT_NEAR(found->worst_degc, 0.05, 1e-12);
  EXPECT_FALSE(worse_days(outcomes, "ours-product", "pid-tuned", 0.02));
}

TEST(WorseDays, AreNegativeWhereEveryDayWasBetter) {
  const std::vector<Outcome> outcomes = {{{"a", run_with(0, 0, {0.05, 0.06})}, {"b", run_with(0, 0, {0.08, 0.07})}}};
  EXPECT_EQ(worse_days(outcomes, "a", "b", 0.02)->worse, 0);
  EXPECT_NEAR(worse_days(outcomes, "a", "b", 0.02)->worst_degc, -0.01, 1e-12);
}

TEST(StudyTable, HasEveryFigureOfTheRulesAndRatiosRoomByRoom) {
  const std::vector<Outcome> outcomes = {
      {{"m", run_with(0.1, 0.4, {})}, {"floor-full", run_with(0.1, 0.1, {})}},
      {{"m", run_with(0.3, 0.6, {})}, {"floor-full", run_with(0.1, 0.3, {})}},
  };
  const nlohmann::json figures = study_figures(outcomes, "m", "floor-full");
  EXPECT_NEAR(figures["dae_over_floor-full"].get<double>(), 2.0, 1e-12);
  EXPECT_NEAR(figures["darv_over_floor-full"].get<double>(), 3.0, 1e-12);  // (4 + 2) / 2, not 1.0 / 0.4
  const std::string text = study_markdown({{"m", figures}}, {"m"}, "floor-full");
  for (const char* title : {"DAE °C", "ME °C", "day 1 °C", "DARV °C", "CDH °C h", "HDH °C h", "degree-hours/day",
                            "above target/day", "kWh/day", "DAE / floor", "DARV / floor"}) {
    EXPECT_NE(text.find(title), std::string::npos) << title;
  }
  for (const char* cell : {"| m ", "0.200 ± 0.141", "512 ± 0", "3.5 ± 0.0", "0.75 ± 0.00", "| 2.00 ", "| 3.00 "}) {
    EXPECT_NE(text.find(cell), std::string::npos) << cell << '\n' << text;
  }
  std::istringstream lines(text);
  std::string line;
  std::size_t bars = 0;
  while (std::getline(lines, line)) {
    const auto here = static_cast<std::size_t>(std::count(line.begin(), line.end(), '|'));
    EXPECT_EQ(here, bars == 0 ? here : bars) << line;
    bars = here;
  }
  EXPECT_EQ(bars, 13U);
}

TEST(StudyTable, DefaultsToEveryPeerOfTheRulesAndKnowsThemAll) {
  for (const bool energyplus : {false, true}) {
    const auto methods = study_methods(energyplus);
    for (const std::string& name : methods) EXPECT_NO_THROW(check_method("--methods", name, energyplus)) << name;
    for (const char* name :
         {"pid-tuned", "integral-tuned", "arx-rls", "g36-written-16", "g36-written-18", "g36-site-i0", "g36-site-i1",
          "g36-site-i2", "constant-20.5", "constant-22.5", "expert", "floor-full"}) {
      EXPECT_NE(std::find(methods.begin(), methods.end(), name), methods.end()) << name;
    }
  }
}

}  // namespace
}  // namespace airside::tools
