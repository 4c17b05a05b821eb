// The blind generator on EnergyPlus: what is hidden is hidden by other objects than the library's, the engine's schema
// knows every one of them, and a short case shows it.

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "gap/needs_engine.hpp"
#include "sim/energyplus/epjson_lint.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/energyplus/plant.hpp"
#include "sim/weather/epw.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "support/test_folder.hpp"
#include "tools/gap/blind/blind_energyplus.hpp"

namespace airside::tools::gap {
namespace {

namespace fs = std::filesystem;

const std::vector<sim::Effect>& library() {
  static const std::vector<sim::Effect> effects = sim::load_effects(sim::find_effects());
  return effects;
}

const EnergyPlusRoom& room(bool feedback) {
  static const EnergyPlusRoom closed = energyplus_measured_room("301", 3, true);
  static const EnergyPlusRoom open = energyplus_measured_room("301", 3, false);
  return feedback ? closed : open;
}

const std::vector<Hidden>& outside() {
  static const std::vector<Hidden> list{{"fcu_dial", -1, 1.5},
                                        {"odd_heater", 7, 1500},
                                        {"escape_door", 8, 8},
                                        {"ahu_time_switch", -1, 2.5},
                                        {"hot_gas_bypass", -1, 0.4}};
  return list;
}

TEST(BlindEnergyPlus, EveryHiddenThingMakesAModelThatTheEngineKnows) {
  AIRSIDE_NEEDS_ENGINE();
  const fs::path schema = sim::find_energyplus().schema;
  sim::RoomLoopOptions plain_loops = room(false).options.rooms;
  const nlohmann::json plain = built_model(room(false), plain_loops);
  std::vector<Hidden> list = outside();
  int hideable = 0;
  for (const sim::Effect& e : library()) {
    if (!energyplus_can_hide(e)) continue;
    ++hideable;
    list.push_back({e.name, 1,
                    e.name == "fcu_rests_unrecorded"  ? 0
                    : e.name == "fcu_runs_unrecorded" ? 1
                                                      : e.probe[1]});
  }
  EXPECT_GE(hideable, 20);
  for (const Hidden& h : list) {
    const EnergyPlusRoom with = hide(room(true), {h}, library(), 1);
    sim::RoomLoopOptions loops = with.options.rooms;
    const nlohmann::json model = built_model(with, loops);
    const auto complaints = sim::epjson_complaints(model, schema, {h.effect, sim::LintScope::whole});
    EXPECT_TRUE(complaints.empty()) << h.effect << ": " << complaints.front().what();
    const EnergyPlusRoom open = hide(room(false), {h}, library(), 1);
    loops = open.options.rooms;
    const bool model_differs = built_model(open, loops) != plain;
    const bool loops_differ = loops.dampers != plain_loops.dampers || loops.supply_lag_s != plain_loops.supply_lag_s ||
                              loops.supply_bias_k != plain_loops.supply_bias_k ||
                              loops.occupancy_scale != plain_loops.occupancy_scale ||
                              loops.occupancy_shift_min != plain_loops.occupancy_shift_min ||
                              loops.fcu_setpoint_degc != plain_loops.fcu_setpoint_degc;
    const bool shown_differs =
        !open.sensors.empty() || open.clock_ahead_h != 0 || open.outdoor_shown_k != 0 ||
        open.options.weather_change.solar_factor != room(false).options.weather_change.solar_factor;
    EXPECT_TRUE(model_differs || loops_differ || shown_differs) << h.effect << " is hidden nowhere";
  }
}

TEST(BlindEnergyPlus, LivesOnFromTheDaysThatItWasMeasured) {
  AIRSIDE_NEEDS_ENGINE();
  const hal::TestFolder folder("blind_ep_on");
  const fs::path weather = folder.file("w.epw");
  sim::write_epw(weather.string(), *sim::synthetic_weather(5), 2021);
  for (const bool feedback : {false, true}) {
    MeasuredRun run{sim::civil_midnight(2021, 7, 6), 3, 4, feedback, 0};
    const std::vector<hal::LogRow> measured = measure(room(feedback), weather, run);
    run.passive_days = run.days;
    run.days = 5;
    const std::vector<hal::LogRow> longer = measure(room(feedback), weather, run);
    ASSERT_EQ(longer.size(), 5U * rows_per_day);
    std::size_t differ = 0;
    for (std::size_t row = 0; row < measured.size(); ++row) {
      if (measured[row].value != longer[row].value) ++differ;
    }
    EXPECT_EQ(differ, 0U) << "of " << measured.size() << (feedback ? " with feedback" : " rows");
  }
}

TEST(BlindEnergyPlus, SameEffectByOtherObjects) {
  AIRSIDE_NEEDS_ENGINE();
  const auto model_with = [](const Hidden& h) {
    const EnergyPlusRoom with = hide(room(false), {h}, library(), 1);
    sim::RoomLoopOptions loops = with.options.rooms;
    return built_model(with, loops);
  };
  const nlohmann::json none = [] {
    sim::RoomLoopOptions loops = room(false).options.rooms;
    return built_model(room(false), loops);
  }();
  EXPECT_FALSE(none.contains("ZoneMixing"));
  EXPECT_EQ(none["ZoneCrossMixing"].size(), 13U);
  EXPECT_EQ(none["ZoneInfiltration:EffectiveLeakageArea"].size(), 5U);
  EXPECT_FALSE(none.contains("ZoneVentilation:DesignFlowRate"));
  const nlohmann::json leak = model_with({"infiltration", 0, 0.4});
  EXPECT_EQ(leak["ZoneVentilation:DesignFlowRate"].size(), 10U);
  EXPECT_EQ(leak["ZoneInfiltration:EffectiveLeakageArea"], none["ZoneInfiltration:EffectiveLeakageArea"]);
  const nlohmann::json heat = model_with({"gain_base", 0, 5});
  EXPECT_EQ(heat["ElectricEquipment"].size(), none["ElectricEquipment"].size() + 10);
  const nlohmann::json u = model_with({"envelope_u", 0, 2});
  EXPECT_EQ(u["Material"]["Insulation"]["conductivity"], none["Material"]["Insulation"]["conductivity"]);
  EXPECT_NEAR(u["Material"]["Insulation"]["thickness"].get<double>(),
              none["Material"]["Insulation"]["thickness"].get<double>() / 2, 1e-12);
}

TEST(BlindEnergyPlus, ShortCaseRepeatsItsBitsAndShowsWhatIsHidden) {
  AIRSIDE_NEEDS_ENGINE();
  const hal::TestFolder root("blind_ep");
  const fs::path weather = root.file("w.epw");
  sim::write_epw(weather.string(), *sim::synthetic_weather(5), 2021);
  const MeasuredRun run{sim::civil_midnight(2021, 7, 6), 1, 4, true, 0.01};
  const auto log = [&](const std::vector<Hidden>& hidden) {
    return measure(hide(room(true), hidden, library(), 4), weather, run);
  };
  const auto plain = log({}), again = log({}), hot = log({{"gain_base", 0, 15}, {"clock_shift", 0, 1}});
  ASSERT_EQ(plain.size(), static_cast<std::size_t>(rows_per_day));
  EXPECT_EQ(plain.front().time, run.start);
  ASSERT_EQ(hot.size(), plain.size());
  int missing = 0, warmer = 0;
  double dearer = 0;
  for (std::size_t i = 0; i < plain.size(); ++i) {
    for (std::size_t k = 0; k < plain[i].value.size(); ++k) {
      const double x = plain[i].value[k], y = again[i].value[k];
      EXPECT_TRUE(x == y || (std::isnan(x) && std::isnan(y)));
      missing += std::isnan(x) ? 1 : 0;
    }
    if (hot[i].value[5] > plain[i].value[5]) ++warmer;
    const double more = hot[i].value[21] - plain[i].value[21];
    if (std::isfinite(more)) dearer += more / rows_per_day;
  }
  EXPECT_GT(missing, 20);
  EXPECT_LT(missing, 150);
  EXPECT_GT(warmer, rows_per_day / 2) << "the first façade zone";
  EXPECT_GT(dearer, 0.3) << "kW of the plant: feedback turns heat into power";
  // The sun's traces come an hour late in the log: outdoor temperatures are those of an hour before.
  double aligned = 0;
  for (std::size_t i = 10; i < plain.size(); ++i) {
    const double a = plain[i - 10].value[23], b = hot[i].value[23];
    if (std::isfinite(a) && std::isfinite(b)) aligned = std::max(aligned, std::abs(a - b));
  }
  EXPECT_LT(aligned, 0.3);
}

}  // namespace
}  // namespace airside::tools::gap
