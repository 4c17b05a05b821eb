// Buildings that differ from an EnergyPlus twin: models that the engine knows, and what they show.

#include <gtest/gtest.h>

#include <cmath>

#include "gap/needs_engine.hpp"
#include "sim/energyplus/differing/differing_twin.hpp"
#include "sim/energyplus/epjson_lint.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/energyplus/rooms.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "tools/gap/model/energyplus_engine.hpp"
#include "tools/gap/verdict/shared_responses.hpp"

namespace airside::tools::gap {
namespace {

const sim::EnergyPlusTwin& twin_301() {
  static const sim::EnergyPlusTwin twin = sim::twin_of(sim::energyplus_room("301"));
  return twin;
}

/// Days on which every box and fan coil of room 301 runs.
Window days_of(int days) {
  const sim::EnergyPlusTwin& twin = twin_301();
  Window window;
  window.recording.from = sim::civil_midnight(2021, 7, 6);
  window.recording.station = sim::synthetic_weather(5);
  for (int row = 0; row < days * rows_per_day; ++row) {
    const CivilTime t = window.recording.time(window.recording.rows.size());
    window.recording.rows.push_back({row / 60 % 2 == 0 ? 22.0 : 24.0, std::vector<double>(5, 1),
                                     std::vector<double>(5, 1), window.recording.station->at(t).outdoor_temp_degc, 0});
  }
  window.measured.setZero(days * bins_per_day, sim::channels_of(twin).count());
  return window;
}

TEST(DrawnEnergyPlus, AreModelsThatTheEngineKnowsInOtherNumbersAndObjects) {
  AIRSIDE_NEEDS_ENGINE();
  const auto schema = sim::find_energyplus().schema;
  for (const std::uint64_t seed : {2U, 3U}) {
    const sim::EnergyPlusTwin other = differing_twin(twin_301(), seed, 1);
    const auto complaints = sim::epjson_complaints(other.model, schema, {"drawn", sim::LintScope::whole});
    EXPECT_TRUE(complaints.empty()) << complaints.front().what();
    EXPECT_FALSE(other.model.contains("ZoneMixing"));
    EXPECT_TRUE(other.model.contains("ZoneCrossMixing"));
    EXPECT_TRUE(other.model.contains("Shading:Overhang:Projection"));
    EXPECT_EQ(other.model["ZoneInfiltration:EffectiveLeakageArea"].size(), 5U);
    EXPECT_EQ(other.model.contains("EnergyManagementSystem:Program"), seed % 2 == 1) << "boxes modulate";
    EXPECT_NE(other.loops.dampers, twin_301().loops.dampers);
    EXPECT_EQ(other.model, differing_twin(twin_301(), seed, 1).model);
  }
  EXPECT_NE(differing_twin(twin_301(), 2, 1).model, differing_twin(twin_301(), 4, 1).model);
}

TEST(DrawnEnergyPlus, DifferByTheirShare) {
  AIRSIDE_NEEDS_ENGINE();
  const auto multiplier = [](const sim::EnergyPlusTwin& twin) {
    return twin.model.at("ZoneCapacitanceMultiplier:ResearchSpecial")
        .front()
        .at("temperature_capacity_multiplier")
        .get<double>();
  };
  const double twin = multiplier(twin_301());
  const double whole = multiplier(differing_twin(twin_301(), 6, 1)) / twin - 1,
               part = multiplier(differing_twin(twin_301(), 6, 0.3)) / twin - 1;
  EXPECT_GT(std::abs(whole), 0.099);
  EXPECT_LT(std::abs(whole), 0.201);
  EXPECT_NEAR(part, 0.3 * whole, 1e-12);
}

TEST(DrawnEnergyPlus, ShowWhatABuildingOfTheirSeedWould) {
  AIRSIDE_NEEDS_ENGINE();
  const Window window = days_of(1);
  const EnergyPlusEngine engine(twin_301(), "301", {}, false), with_duties(twin_301(), "301", {}, true);
  ASSERT_TRUE(engine.draws_buildings());
  const sim::ChannelTable plain = engine.simulate({}, window.recording);
  const sim::ChannelTable drawn = engine.simulate_differing(3, {}, window.recording);
  ASSERT_EQ(drawn.rows(), plain.rows());
  const sim::Channels at = engine.channels();
  const Eigen::Index temps = at.mau_temp();
  EXPECT_GT((drawn - plain).leftCols(temps).cwiseAbs().maxCoeff(), 0.05);
  EXPECT_LT((drawn - plain).leftCols(temps).cwiseAbs().maxCoeff(), 5) << "but it is the same kind of building";
  EXPECT_TRUE(drawn.rightCols(at.fcus).array().isNaN().all());
  EXPECT_TRUE(drawn.leftCols(at.fcu_duty()) ==
              engine.simulate_differing(3, {}, window.recording).leftCols(at.fcu_duty()));
  EXPECT_FALSE(
      drawn.leftCols(temps).isApprox(engine.simulate_differing(4, {}, window.recording).leftCols(temps), 1e-6));
  const sim::ChannelTable duties = with_duties.simulate_differing(3, {}, window.recording);
  EXPECT_TRUE(duties.leftCols(at.fcu_duty()) == drawn.leftCols(at.fcu_duty()));
  EXPECT_TRUE((duties.rightCols(at.fcus).array() >= 0).all() && (duties.rightCols(at.fcus).array() <= 1).all());
}

TEST(DrawnEnergyPlus, AreDrawnOnceForTheCasesOfAWindow) {
  AIRSIDE_NEEDS_ENGINE();
  const Window window = days_of(2);
  const EnergyPlusEngine engine(twin_301(), "301", {}, false);
  int done = 0;
  SharedResponses shared(engine, {}, window.recording, 1, [&done] { ++done; });
  shared.draw_buildings(engine, window.recording, 0, 1);
  EXPECT_TRUE(shared.borrowed(engine, window.recording).responses.buildings.empty());
  const int runs = done;
  shared.draw_buildings(engine, window.recording, 2, 1, [&done] { ++done; });
  EXPECT_EQ(done, runs + 2);
  sim::Recording warmer = window.recording;
  for (sim::RecordedRow& row : warmer.rows) row.outdoor_temp_degc += 0.1;
  const Responses borrowed = shared.borrowed(engine, warmer).responses;
  ASSERT_EQ(borrowed.buildings.size(), 2U);
  EXPECT_EQ(borrowed.buildings.front().rows(), 2 * bins_per_day);

  const CaseData data{window, window};
  const SharedWindows windows(engine, {}, data, 1, {}, 2);
  const WindowResponses of = windows.of(engine, data, {}, 1);
  EXPECT_EQ(of.reference.buildings.size(), 2U);
  ASSERT_EQ(of.test.buildings.size(), 2U);
  const Eigen::Index shown = engine.channels().fcu_duty();  // without duties
  EXPECT_TRUE(of.test.buildings.front().leftCols(shown).isApprox(of.reference.buildings.front().leftCols(shown)));
}

TEST(DrawnEnergyPlus, AreNoneOfAModelThatControlsItself) {
  AIRSIDE_NEEDS_ENGINE();
  sim::EnergyPlusTwin own = twin_301();
  own.own = sim::OwnNames{};
  const EnergyPlusEngine engine(own, "own", {}, false);
  EXPECT_FALSE(engine.draws_buildings());
  EXPECT_EQ(engine.simulate_differing(3, {}, {}).size(), 0);
}

}  // namespace
}  // namespace airside::tools::gap
