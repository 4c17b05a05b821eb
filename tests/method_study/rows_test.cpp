// What the rows of `airside study method` change of preset `paper`.

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <set>
#include <string>
#include <utility>

#include "airside/forecast/candidate_search.hpp"
#include "airside/network/forward.hpp"
#include "airside/presets.hpp"
#include "tools/study/method/run.hpp"

namespace airside::tools {
namespace {

TEST(MethodRows, EachChangesExactlyWhatItNames) {
  const ControllerSettings plain = method_settings(paper_settings(), method_row("paper"));
  for (const MethodRow& row : method_rows()) {
    const ControllerSettings changed = method_settings(paper_settings(), row);
    std::set<std::string> named;
    for (const MethodOverride& o : row.overrides) {
      if (o.name != nullptr) named.insert(o.name);
    }
    for (const SettingEntry& e : setting_table) {
      const bool same = e.real != nullptr ? plain.*e.real == changed.*e.real : plain.*e.whole == changed.*e.whole;
      EXPECT_TRUE(same || named.contains(e.name)) << row.name << ": " << e.name;
    }
    for (const MethodOverride& o : row.overrides) {
      if (o.name == nullptr) continue;
      for (const SettingEntry& e : setting_table) {
        if (std::string(e.name) != o.name) continue;
        EXPECT_EQ(e.real != nullptr ? changed.*e.real : changed.*e.whole, o.value) << row.name << ": " << e.name;
        EXPECT_TRUE(o.value >= e.min && o.value <= e.max) << row.name << ": " << e.name;
      }
    }
  }
}

TEST(MethodRows, EachCycleHasARowOfBothPresets) {
  std::set<std::pair<bool, int>> found;
  for (const MethodRow& row : method_rows()) {
    if (row.table == MethodTable::cycle)
      found.insert({row.is_product, method_settings(paper_settings(), row).cycle_min});
  }
  const std::set<std::pair<bool, int>> all = {{false, 6}, {false, 12}, {false, 24},  // 18 is the row "paper"
                                              {true, 6},  {true, 12},  {true, 18},  {true, 24}};
  EXPECT_EQ(found, all);
}

TEST(MethodRows, FilesOfNoTwoRunsHaveOneName) {
  std::vector<MethodTable> all;
  for (int t = 0; t < method_tables; ++t) all.push_back(static_cast<MethodTable>(t));
  std::set<std::string> names;
  for (const MethodJob& job : method_jobs({}, all, 1, 3)) EXPECT_TRUE(names.insert(job.name()).second) << job.name();
}

TEST(MethodRows, ATableBringsWhatItsRunsStartFrom) {
  for (int t = 0; t < method_tables; ++t) {
    const std::vector<MethodJob> jobs = method_jobs({}, {static_cast<MethodTable>(t)}, 7, 1);
    std::set<std::string> names;
    for (const MethodJob& job : jobs) names.insert(job.name());
    for (const MethodJob& job : jobs) {
      const std::string source = job.source_name();
      EXPECT_TRUE(source.empty() || names.contains(source)) << job.name();
    }
  }
}

/// The published network with drawn weights, and a state that it is asked about.
struct Drawn {
  using T = FiveZone;
  Drawn() {
    weights = std::make_unique<NetworkWeights<T, float>>();
    scratch = std::make_unique<NetworkScratch<T, float>>();
    SplitMix64 draw(3);
    initialise_uniform<T, float>(*weights, draw);
    pack(*weights, scratch->kernels, scratch->packed);
    scaler.mean.setConstant(24);
    scaler.scale.setConstant(2);
    now.setConstant(25);
    now.head(5).setConstant(25.6);
  }
  std::unique_ptr<NetworkWeights<T, float>> weights;
  std::unique_ptr<NetworkScratch<T, float>> scratch;
  Scaler<T> scaler;
  CandidateSearch<T, float>::Vector now;
};

TEST(MethodRows, WithoutTheLongTermBranchTheNearestShortForecastWins) {
  Drawn drawn;
  const ForecastModel<FiveZone, float> model{drawn.scaler, drawn.scratch->packed, *drawn.scratch};
  ControllerSettings s = method_settings(paper_settings(), method_row("without-tdb"));
  // A target within what this network foresees.
  CandidateSearch<FiveZone, float> search;
  search.configure(s);
  s.target_degc = search.expected_degc(s, model, drawn.now, 22.3);
  EXPECT_NEAR(search.best_degc(s, model, drawn.now, 20.0), 22.3, 1e-9);
  s.long_term = 1;  // drawn weights foresee another temperature in the long term
  EXPECT_GT(std::abs(search.best_degc(s, model, drawn.now, 20.0) - 22.3), 0.1);
}

}  // namespace
}  // namespace airside::tools
