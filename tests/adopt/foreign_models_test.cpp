// Buildings that the project did not write become sites that are in order.

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "adopt/foreign_models.hpp"
#include "adopt/template_model.hpp"
#include "hal/points/point_map.hpp"
#include "sim/energyplus/epjson_lint.hpp"
#include "sim/json/json_file.hpp"
#include "sim/json/merge_patch.hpp"
#include "support/complaint.hpp"
#include "support/program.hpp"
#include "tools/adopt/adoption.hpp"
#include "tools/adopt/advice.hpp"
#include "tools/adopt/model/foreign_file.hpp"
#include "tools/gap/map/mapped_model.hpp"
#include "tools/run/site.hpp"

namespace airside::tools {
namespace {

struct Building {
  const char* name;
  const char* file;
  const char* air_loop;
  const char* shape;  ///< how its topology begins
  TerminalKind kind;
  const char* weather;  ///< of the engine's package; empty: the nearest at hand
  Verdict verdict;
};

void PrintTo(const Building& b, std::ostream* out) { *out << b.name; }

const Building buildings[] = {
    {"VavWithReheat", "RefBldgMediumOfficeNew2004_Chicago", "VAV_1", "5vav-0fcu-", TerminalKind::reheat, "",
     Verdict::control},
    {"VavWithReheatInAnotherClimate", "ASHRAE901_OfficeMedium_STD2019_Denver", "PACU_VAV_top", "5vav-0fcu-",
     TerminalKind::reheat, "USA_FL_Tampa.Intl.AP.722110_TMY3.epw", Verdict::schedule},
    {"SingleZoneOfSeveralLoops", "RefBldgSmallOfficeNew2004_Chicago", "PSZ-AC:1", "1vav-0fcu-", TerminalKind::fixed, "",
     Verdict::control},
    {"PackagedUnitByLoad", "ASHRAE901_RestaurantSitDown_STD2019_Denver", "PSZ-AC_1:1", "1vav-0fcu-",
     TerminalKind::fixed, "", Verdict::own_control},
    {"ThirteenZones", "ASHRAE901_HotelLarge_STD2019_Denver", "VAV WITH REHEAT", "13vav-0fcu-", TerminalKind::reheat, "",
     Verdict::control},
    {"FixedFlowsBesideFanCoils", "RefBldgLargeHotelNew2004_Chicago", "FLR_3_DOAS", "6vav-6fcu-", TerminalKind::fixed,
     "", Verdict::schedule},
};

/// The written files, read as the programs read them.
void check_site(const Adoption& a, const std::filesystem::path& folder) {
  for (const char* file : {"site.toml", "points.csv", "model.epJSON", "twin.patch.json", "map.toml", "adopt.md"})
    EXPECT_TRUE(std::filesystem::is_regular_file(folder / file)) << file;
  EXPECT_TRUE(std::filesystem::is_regular_file(folder / a.weather_name));
  const auto points = hal::PointMap::load((folder / "points.csv").string());
  EXPECT_NE(points.find(fmt::format("room_temp_{}", a.loop.terminals.size())), nullptr);
  const auto model = sim::merge_patched(sim::read_json(folder / "model.epJSON"),
                                        sim::read_json(folder / "twin.patch.json"), "twin.patch.json");
  EXPECT_TRUE(sim::epjson_complaints(model, sim::find_energyplus().schema, {"model"}).empty());
  EXPECT_TRUE(model["Schedule:Constant"].contains(a.setpoint.schedule));
  const gap::Mapping map = gap::read_mapping((folder / "map.toml").string());
  const sim::OwnNames named = gap::own_names_of(map, model);
  EXPECT_EQ(named.supply_setpoint_schedule, a.setpoint.schedule);
  EXPECT_EQ(named.powers, a.choices.powers);
  EXPECT_EQ(named.zones.size(), std::max(a.loop.terminals.size(), a.loop.fcu_zones.size()));
  const Site site = load_site((folder / "site.toml").string());
  EXPECT_EQ(site.counts.name, a.topology());
  const bool band = site.settings.objective == Objective::band;
  EXPECT_EQ(band, points.find("damper_1") != nullptr) << "where boxes show their dampers";
}

/// The supply follows the setpoint, and the numbers of the site are those of a building.
void check_choices(const Adoption& a) {
  const SiteChoices& c = a.choices;
  EXPECT_TRUE(a.response(Season::summer).known);
  EXPECT_NEAR(a.response(Season::summer).supply_gain, 1.0, 0.15);
  EXPECT_GE(c.target_degc, 20);
  EXPECT_LE(c.target_degc, 26);
  EXPECT_LT(c.min_degc, c.max_degc);
  EXPECT_GE(c.work_degc, c.min_degc);
  EXPECT_LE(c.work_degc, c.max_degc);
  EXPECT_LT(c.work.from_h, c.work.to_h);
  EXPECT_FALSE(c.powers.empty());
  EXPECT_FALSE(a.loop.fan.name.empty());
  EXPECT_GT(a.sizes.written, 20);
}

/// What is advised, and that the page says it; figures of the three loops that docs/adopting.md shows.
void check_advice(const Adoption& a, const std::filesystem::path& folder, Verdict verdict) {
  const Advice advice = advice_on(a);
  EXPECT_EQ(advice.verdict, verdict) << text_of(advice.verdict) << ": " << advice.why;
  EXPECT_EQ(advice_of_page(folder / "adopt.md"), advice.headline + ". " + advice.why);
  ASSERT_EQ(a.seasons.size(), 3U);
  for (const Comparison& c : a.seasons) {
    ASSERT_TRUE(c.known()) << text_of(c.season);
    EXPECT_EQ(c.constants.size(), 4U);
    EXPECT_GT(c.own.kwh, 0);
    EXPECT_GT(c.schedule.kwh, 0);
  }
  const Comparison& summer = a.seasons[0];
  if (verdict == Verdict::own_control) {
    EXPECT_GT(summer.best().figures.kwh, 2 * summer.own.kwh);
  } else {
    EXPECT_NEAR(summer.schedule.kwh, summer.own.kwh, 0.1 * summer.own.kwh)
        << "its schedule is the model's own setpoint";
  }
}

class ForeignBuilding : public testing::TestWithParam<Building> {};

TEST_P(ForeignBuilding, BecomesASite) {
  AIRSIDE_NEEDS_FOREIGN_MODELS();
  const Building& b = GetParam();
  const TemporaryFolder folder;
  AdoptRequest request{
      foreign_models() / (std::string(b.file) + ".idf"), b.air_loop, {}, folder.path() / "site", false, {}};
  if (*b.weather != '\0') request.weather = sim::find_energyplus().folder / "WeatherData" / b.weather;
  const Adoption a = adopt(request);
  EXPECT_TRUE(a.topology().starts_with(b.shape)) << a.topology();
  EXPECT_EQ(a.loop.kind(), b.kind) << text_of(a.loop.kind());
  check_choices(a);
  check_site(a, request.folder);
  check_advice(a, request.folder, b.verdict);
}

std::string building_name(const testing::TestParamInfo<Building>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(Of, ForeignBuilding, testing::ValuesIn(buildings), building_name);

TEST(ForeignBuildings, SeveralLoopsAreListed) {
  AIRSIDE_NEEDS_FOREIGN_MODELS();
  const TemporaryFolder folder;
  try {
    (void)adopt(
        {foreign_models() / "ASHRAE901_OfficeMedium_STD2019_Denver.idf", "", {}, folder.path() / "site", false, {}});
    FAIL() << "was adopted";
  } catch (const hal::InputError& error) {
    EXPECT_EQ(error.found(), "3 air loops: \"PACU_VAV_bot\", \"PACU_VAV_mid\", \"PACU_VAV_top\"");
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(ForeignBuildings, TemplatesOfBoxesWithAndWithoutReheatBecomeASite) {
  AIRSIDE_NEEDS_ADOPT_ENGINE();
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "Büro 1.idf") << template_model;
  const Adoption a = adopt({folder.path() / "Büro 1.idf", "", {}, folder.path() / "site", false, {}});
  EXPECT_EQ(a.loop.name, "Anlage 1");
  ASSERT_EQ(a.loop.terminals.size(), 2U);
  EXPECT_EQ(a.loop.terminals[0].zone, "Raum Süd");
  EXPECT_EQ(a.loop.terminals[0].kind, TerminalKind::reheat);
  EXPECT_EQ(a.loop.terminals[1].zone, "Raum Nord");
  EXPECT_EQ(a.loop.terminals[1].kind, TerminalKind::modulating);
  EXPECT_NEAR(a.choices.work.from_h, 7, 0.2);
  EXPECT_NEAR(a.choices.work.to_h, 18, 0.2);
  EXPECT_TRUE(a.choices.work.weekday_only);
  EXPECT_NEAR(a.choices.fan.from_h, 7, 0.2);
  EXPECT_TRUE(a.choices.fan.weekday_only);
  EXPECT_EQ(a.weather_name, "USA_IL_Chicago-OHare.Intl.AP.725300_TMY3.epw") << "the nearest of the engine's";
  check_site(a, folder.path() / "site");
}

/// The template model as EnergyPlus 9.0 had it: walls without a space, old words, an output that is several.
std::string template_model_of_9_0() {
  std::string old = hal::replaced(template_model, "Version,25.2", "Version,9.0");
  for (const char* wall : {"Outdoors,,SunExposed", "Adiabatic,,NoSun"}) {
    for (int n = 0; n < 2; ++n) old = hal::replaced(old, std::string(",,") + wall, std::string(",") + wall);
  }
  return hal::replaced(old, "UpperLeftCorner,CounterClockWise,World", "ULC,CCW,WCS");
}

TEST(ForeignBuildings, ModelOfAnOlderVersionIsTheSameModel) {
  AIRSIDE_NEEDS_ADOPT_ENGINE();
  const TemporaryFolder folder;
  std::ofstream(folder.path() / "new.idf") << template_model;
  std::ofstream(folder.path() / "old.idf") << template_model_of_9_0();
  const auto install = sim::find_energyplus();
  const ForeignModel upgraded = read_foreign_model(folder.path() / "old.idf", install);
  auto as_written = read_foreign_model(folder.path() / "new.idf", install).content;
  for (auto& [name, rules] : as_written["GlobalGeometryRules"].items())
    rules["vertex_entry_direction"] = "Counterclockwise";
  EXPECT_EQ(upgraded.content, as_written);
  EXPECT_EQ(upgraded.upgrade.from, "9.0");
  EXPECT_EQ(upgraded.upgrade.objects(), 5);
}

TEST(ForeignBuildings, EmsProgramsKeepTheOrderOfTheIdf) {
  AIRSIDE_NEEDS_ADOPT_ENGINE();
  const TemporaryFolder folder;
  const std::string programs =
      "EnergyManagementSystem:ProgramCallingManager,Set,BeginNewEnvironment,Set_It;"
      "EnergyManagementSystem:ProgramCallingManager,Ask,BeginNewEnvironment,Ask_It;"
      "EnergyManagementSystem:GlobalVariable,Stage;"
      "EnergyManagementSystem:Program,Set_It,SET Stage = 1;"
      "EnergyManagementSystem:Program,Ask_It,IF Stage == 1,SET Stage = 2,ENDIF;";
  std::ofstream(folder.path() / "ems.idf") << template_model << programs;
  const ForeignModel model = read_foreign_model(folder.path() / "ems.idf", sim::find_energyplus());
  const auto& managers = model.content["EnergyManagementSystem:ProgramCallingManager"];
  ASSERT_EQ(managers.size(), 2U);
  EXPECT_EQ(managers.begin().key(), "001 Set");
  EXPECT_EQ(std::next(managers.begin()).key(), "002 Ask");
}

}  // namespace
}  // namespace airside::tools
