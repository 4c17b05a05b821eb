// Effects on a model whose names nobody knows: objects are found by type and relation, or the effect is not applicable.

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include "gap/effects_expected.hpp"
#include "gap/effects_library.hpp"
#include "tools/gap/any_model/effect_patch.hpp"
#include "tools/gap/any_model/model_graph.hpp"
#include "tools/gap/any_model/schedule_shift.hpp"

namespace airside::tools::gap {
namespace {

using Json = nlohmann::json;

Json corners_at(std::initializer_list<std::array<double, 3>> list) {
  Json out = Json::array();
  for (const auto& v : list)
    out.push_back({{"vertex_x_coordinate", v[0]}, {"vertex_y_coordinate", v[1]}, {"vertex_z_coordinate", v[2]}});
  return out;
}

Json outer_wall(const char* zone, const Json& corners) {
  return {{"zone_name", zone},
          {"surface_type", "Wall"},
          {"construction_name", "Ziegel"},
          {"outside_boundary_condition", "Outdoors"},
          {"vertices", corners}};
}

Json window_in(const char* in) {
  return {{"building_surface_name", in}, {"surface_type", "Window"}, {"construction_name", "Scheibe"}};
}

/// Two zones of a site and one that is elsewhere; "Nord" looks to the north and the east, "Süd" to the south.
Json foreign_model() {
  const Json north = corners_at({{5, 4, 3}, {5, 4, 0}, {0, 4, 0}, {0, 4, 3}});
  const Json east = corners_at({{5, 0, 3}, {5, 0, 0}, {5, 4, 0}, {5, 4, 3}});
  const Json south = corners_at({{0, 0, 3}, {0, 0, 0}, {5, 0, 0}, {5, 0, 3}});
  const Json roof = corners_at({{0, 0, 3}, {5, 0, 3}, {5, 4, 3}, {0, 4, 3}});
  const char* zones = "zone_or_zonelist_or_space_or_spacelist_name";
  return {
      {"Building", {{"Haus", {{"north_axis", 0}}}}},
      {"GlobalGeometryRules",
       {{"Rules", {{"coordinate_system", "Relative"}, {"vertex_entry_direction", "Counterclockwise"}}}}},
      {"Zone", {{"Nord", Json::object()}, {"Süd", Json::object()}, {"Keller", Json::object()}}},
      {"ZoneList", {{"Alle", {{"zones", {{{"zone_name", "nord"}}, {{"zone_name", "Keller"}}}}}}}},
      {"BuildingSurface:Detailed",
       {{"NW", outer_wall("Nord", north)},
        {"NO", outer_wall("Nord", east)},
        {"SW", outer_wall("Süd", south)},
        {"ND", outer_wall("Nord", roof)},
        {"BN",
         {{"zone_name", "Nord"},
          {"surface_type", "Floor"},
          {"outside_boundary_condition", "Ground"},
          {"vertices", roof}}}}},
      {"FenestrationSurface:Detailed",
       {{"Fenster N", window_in("nw")}, {"Fenster S", window_in("SW")}, {"Oberlicht", window_in("ND")}}},
      {"Construction",
       {{"Ziegel", {{"outside_layer", "Stein"}, {"layer_2", "Wolle"}}}, {"Scheibe", {{"outside_layer", "Glas"}}}}},
      {"Material",
       {{"Stein", {{"thickness", 0.2}, {"conductivity", 1.0}}},
        {"Wolle", {{"thickness", 0.1}, {"conductivity", 0.04}}}}},
      {"WindowMaterial:SimpleGlazingSystem", {{"Glas", {{"u_factor", 2.0}, {"solar_heat_gain_coefficient", 0.5}}}}},
      {"Lights",
       {{"Licht", {{zones, "Süd"}, {"watts_per_floor_area", 8.0}, {"schedule_name", "Zeit"}}},
        {"Licht alle", {{zones, "Alle"}, {"lighting_level", 300.0}, {"schedule_name", "Zeit"}}}}},
      {"Schedule:Compact",
       {{"Zeit",
         {{"data",
           {{{"field", "Through: 12/31"}},
            {{"field", "For: AllDays"}},
            {{"field", "Until: 8:00"}},
            {{"field", 0}},
            {{"field", "Until: 18:00"}},
            {{"field", "1.0"}},
            {{"field", "Until: 24:00"}},
            {{"field", 0.1}}}}}}}},
  };
}

sim::OwnNames foreign_names() {
  sim::OwnNames own;
  own.zones = {"NORD", "Süd"};
  own.supply_air_node = "no such node";
  return own;
}

Json foreign_patch(const char* effect, int place, double magnitude) {
  const sim::EffectChange change{{&sim::effect_named(effect), place}, magnitude};
  return any_model_patch(foreign_model(), foreign_names(), std::span(&change, 1));
}

std::string why_absent(const char* effect, int place) {
  return why_not_applicable(foreign_model(), foreign_names(), {&sim::effect_named(effect), place});
}

TEST(AnyModel, WindowsAreFoundByTheirAzimuth) {
  Json m = foreign_model();
  using Facades = std::array<bool, sim::facades>;  // north, east, south, west
  EXPECT_EQ(ModelGraph(m, foreign_names()).has_facade(), (Facades{true, false, true, false}));
  m["Building"]["Haus"]["north_axis"] = 90;
  EXPECT_EQ(ModelGraph(m, foreign_names()).has_facade(), (Facades{false, true, false, true}));
  m["Zone"]["Nord"]["direction_of_relative_north"] = -100;
  EXPECT_EQ(ModelGraph(m, foreign_names()).has_facade(), (Facades{true, false, false, true}));
  m["GlobalGeometryRules"]["Rules"]["coordinate_system"] = "World";
  EXPECT_EQ(ModelGraph(m, foreign_names()).has_facade(), (Facades{true, false, true, false}));
  m["GlobalGeometryRules"]["Rules"]["vertex_entry_direction"] = "Clockwise";
  EXPECT_EQ(ModelGraph(m, foreign_names()).has_facade(), (Facades{true, false, true, false}));
}

TEST(AnyModel, SunOfOneFacadeLeavesTheOthersGlassAlone) {
  const Json p = foreign_patch("solar_gain", 2, 0.5);
  Json after = foreign_model();
  after.merge_patch(p);
  EXPECT_EQ(after["WindowMaterial:SimpleGlazingSystem"]["Glas"]["solar_heat_gain_coefficient"], 0.5);
  EXPECT_EQ(after["FenestrationSurface:Detailed"]["Fenster N"]["construction_name"], "Scheibe");
  const std::string copy = after["FenestrationSurface:Detailed"]["Fenster S"]["construction_name"];
  const std::string glass = after["Construction"][copy]["outside_layer"];
  EXPECT_EQ(after["WindowMaterial:SimpleGlazingSystem"][glass]["solar_heat_gain_coefficient"], 0.25);
  EXPECT_EQ(after["WindowMaterial:SimpleGlazingSystem"][glass]["u_factor"], 2.0);
  // A second change meets the copy, not the glass that is no longer there.
  const sim::Effect& e = sim::effect_named("solar_gain");
  const sim::EffectChange both[] = {{{&e, 2}, 0.5}, {{&e, 2}, 1.5}};
  Json twice = foreign_model();
  twice.merge_patch(any_model_patch(foreign_model(), foreign_names(), both));
  EXPECT_EQ(twice["WindowMaterial:SimpleGlazingSystem"][glass]["solar_heat_gain_coefficient"], 0.375);
}

TEST(AnyModel, WallsAreChangedWhereTheyInsulate) {
  const Json p = foreign_patch("envelope_u", 0, 1.5);
  EXPECT_EQ(p["Material"], (Json{{"Wolle", {{"conductivity", 0.06}}}}));
  EXPECT_EQ(p["WindowMaterial:SimpleGlazingSystem"]["Glas"]["u_factor"], 3.0);
}

TEST(AnyModel, ZoneIsAskedForItsOwnObjectsAndTheFloorForAll) {
  EXPECT_EQ(foreign_patch("gain_zone", 1, 2), (Json{{"Lights", {{"Licht", {{"watts_per_floor_area", 16.0}}}}}}));
  EXPECT_EQ(foreign_patch("gain_zone", 0, 2), Json::object()) << "its lights are those of another zone too";
  EXPECT_EQ(foreign_patch("occupancy_shift", 0, 2)["Lights"].size(), 2U);
  EXPECT_EQ(foreign_patch("gain_occupied", 0, 2), Json::object()) << "nobody is there";
}

TEST(AnyModel, HeatIsAddedToEveryZoneAndNothingAtNull) {
  const Json p = foreign_patch("gain_base", 0, 4);
  ASSERT_EQ(p["OtherEquipment"].size(), 1U) << "Süd has no floor";
  EXPECT_EQ(p["OtherEquipment"].front()["design_level"], 80.0) << "4 W/m2 on 20 m2";
  EXPECT_EQ(foreign_patch("infiltration", 0, 0.5)["ZoneInfiltration:DesignFlowRate"].size(), 2U);
  EXPECT_EQ(foreign_patch("gain_base", 0, 0), Json::object());
  EXPECT_EQ(foreign_patch("thermal_mass", 0, 2)["ZoneCapacitanceMultiplier:ResearchSpecial"].size(), 1U);
}

TEST(AnyModel, PeopleWhoComeLateHaveACopyOfTheirSchedule) {
  const Json p = foreign_patch("occupancy_shift", 0, 1.5);
  const std::string name = p["Lights"]["Licht"]["schedule_name"];
  EXPECT_NE(name, "Zeit");
  Json fields = Json::array();
  for (const Json& entry : p["Schedule:Compact"][name]["data"]) fields.push_back(entry["field"]);
  EXPECT_EQ(fields, (Json{"Through: 12/31", "For: AllDays", "Interpolate: Average", "Until: 01:30", 0.1, "Until: 09:30",
                          0.0, "Until: 19:30", 1.0, "Until: 24:00", 0.1}));
  EXPECT_FALSE(shifted_compact({{"data", {{{"field", "For: AllDays"}}, {{"field", 7}}}}}, 60));
}

TEST(AnyModel, WhatTheModelLacksIsNotApplicableAndSaidSo) {
  EXPECT_EQ(why_absent("occupancy_shift", 0), "");
  EXPECT_EQ(why_absent("room_sensor_bias", 1), "");
  EXPECT_EQ(why_absent("clock_shift", 0), "");
  EXPECT_EQ(why_absent("setpoint_lag", 0), "");
  EXPECT_NE(why_absent("fan_power", 0).find("Fan:"), std::string::npos) << "the loop cannot be walked";
  EXPECT_NE(why_absent("vav_flow", 1).find("AirTerminal:"), std::string::npos);
  EXPECT_NE(why_absent("solar_gain", 1), "") << "nothing looks to the east";
  EXPECT_NE(why_absent("fcu_degraded", 0), "");
  EXPECT_NE(why_absent("fcu_runs_unrecorded", 0), "") << "nobody commands such a model's fan coils";
}

}  // namespace
}  // namespace airside::tools::gap
