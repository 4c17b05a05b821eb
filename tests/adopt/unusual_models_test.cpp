// Models that are odd and right: they are adopted, and what was odd is said.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <set>
#include <string>

#include "adopt/small_model.hpp"
#include "sim/energyplus/install.hpp"
#include "support/program.hpp"
#include "tools/adopt/adoption.hpp"
#include "tools/adopt/loop/loop_meters.hpp"
#include "tools/adopt/observation.hpp"
#include "tools/adopt/site_text.hpp"
#include "tools/adopt/sizes.hpp"

namespace airside::tools {
namespace {

using nlohmann::json;

/// The model after the adoption's patch of the setpoint.
json patched(const json& model, const Adoption& a) {
  return sim::merge_patched(model, a.setpoint.patch, "twin.patch.json");
}

bool said(const std::vector<std::string>& notes, const std::string& part) {
  return std::any_of(notes.begin(), notes.end(),
                     [&](const std::string& note) { return note.find(part) != std::string::npos; });
}

/// Managers of temperature that set a node, "Type / schedule or reference".
std::vector<std::string> managers_of(const json& model, const std::string& node) {
  const ModelView view(model, "m");
  std::vector<std::string> out;
  for (const ModelObject& m : view.all_of("SetpointManager:")) {
    for (const std::string& n : view.nodes(m.text("setpoint_node_or_nodelist_name"))) {
      if (same_name(n, node))
        out.push_back(m.type + " / " + m.text("schedule_name") + m.text("reference_setpoint_node_name"));
    }
  }
  return out;
}

const std::vector<std::string> ours = {"SetpointManager:Scheduled / airside supply setpoint"};

TEST(UnusualModel, SmallModelIsFoundWhole) {
  const Adoption a = examine(small_model(), "m", "");
  EXPECT_EQ(a.loop.name, "AHU");
  EXPECT_EQ(a.loop.supply_outlet, "AHU Supply Fan Outlet");
  EXPECT_EQ(a.loop.fan.name, "AHU Supply Fan");
  ASSERT_EQ(a.loop.terminals.size(), 5U);
  EXPECT_EQ(a.loop.terminals[0].zone, "Interior 1");
  EXPECT_EQ(a.loop.terminals[4].zone, "Interior 5");
  EXPECT_EQ(a.loop.kind(), TerminalKind::modulating);
  EXPECT_TRUE(a.loop.terminals[0].damper && a.loop.terminals[0].thermostat);
  EXPECT_TRUE(a.loop.outdoor_air_treated);
  EXPECT_EQ(a.loop.outdoor_stream_node, "AHU Outside Air Inlet");
}

TEST(UnusualModel, ManagerAtTheOutletIsReplacedAndTheCoilsFollow) {
  const Adoption a = examine(small_model(), "m", "");
  const json model = patched(small_model(), a);
  EXPECT_EQ(managers_of(model, "AHU Supply Fan Outlet"), ours);
  EXPECT_EQ(managers_of(model, "AHU Cooling Coil Outlet"),
            std::vector<std::string>{"SetpointManager:MixedAir / AHU Supply Fan Outlet"});
  EXPECT_EQ(managers_of(model, "MAU Coil Outlet"), std::vector<std::string>{"SetpointManager:Scheduled / MAU Setpoint"})
      << "a preheat or make-up air coil keeps its own setpoint";
  EXPECT_EQ(managers_of(model, "ChW Supply Outlet"), std::vector<std::string>{"SetpointManager:OutdoorAirReset / "});
}

TEST(UnusualModel, TwoManagersAtTheOutletAreBothReplaced) {
  const json two = small_model_with(R"({"SetpointManager:Warmest": {"Second": {"control_variable": "Temperature",
      "hvac_air_loop_name": "AHU", "minimum_setpoint_temperature": 12, "maximum_setpoint_temperature": 18,
      "setpoint_node_or_nodelist_name": "AHU Supply Fan Outlet"}}})");
  const Adoption a = examine(two, "m", "");
  EXPECT_EQ(managers_of(patched(two, a), "AHU Supply Fan Outlet"), ours);
  EXPECT_TRUE(said(a.setpoint.notes, "SetpointManager:Warmest \"Second\""));
  EXPECT_FALSE(patched(two, a).contains("SetpointManager:Warmest")) << "a type without objects goes as a whole";
}

TEST(UnusualModel, ManagerOfSeveralLoopsGoesOnAtTheOthers) {
  const json shared = small_model_with(R"({"NodeList": {"All": {"nodes": [{"node_name": "AHU Supply Fan Outlet"},
      {"node_name": "Another Outlet"}]}}, "SetpointManager:Scheduled": {"AHU Supply Air Setpoint Manager":
      {"setpoint_node_or_nodelist_name": "All"}}})");
  const json model = patched(shared, examine(shared, "m", ""));
  EXPECT_EQ(managers_of(model, "AHU Supply Fan Outlet"), ours);
  EXPECT_EQ(managers_of(model, "Another Outlet"),
            std::vector<std::string>{"SetpointManager:Scheduled / Supply Air Setpoint"});
}

TEST(UnusualModel, CoilWithARuleOfItsOwnIsMadeToFollow) {
  const json rule = small_model_with(R"({"SetpointManager:MixedAir": null, "SetpointManager:Scheduled": {"Coil":
      {"control_variable": "Temperature", "schedule_name": "Supply Air Setpoint",
       "setpoint_node_or_nodelist_name": "AHU Cooling Coil Outlet"}}})");
  const json model = patched(rule, examine(rule, "m", ""));
  EXPECT_EQ(managers_of(model, "AHU Cooling Coil Outlet"),
            std::vector<std::string>{"SetpointManager:MixedAir / AHU Supply Fan Outlet"});
}

TEST(UnusualModel, UnitarySystemByLoadIsSwitchedToSetpoint) {
  const json unit = small_model_with(R"({"AirLoopHVAC:UnitarySystem": {"Rooftop": {"control_type": "Load",
      "supply_fan_object_type": "Fan:VariableVolume", "supply_fan_name": "AHU Supply Fan",
      "cooling_coil_object_type": "Coil:Cooling:Water", "cooling_coil_name": "AHU Cooling Coil"}},
      "Branch": {"AHU Main Branch": {"components": [{"component_object_type": "AirLoopHVAC:UnitarySystem",
      "component_name": "Rooftop", "component_inlet_node_name": "AHU Air Loop Inlet",
      "component_outlet_node_name": "AHU Supply Fan Outlet"}]}},
      "SetpointManager:SingleZone:Cooling": {"Coil": {"setpoint_node_or_nodelist_name": "AHU Cooling Coil Outlet"}},
      "SetpointManager:MixedAir": null})");
  const Adoption a = examine(unit, "m", "");
  const json model = patched(unit, a);
  EXPECT_EQ(model["AirLoopHVAC:UnitarySystem"]["Rooftop"]["control_type"], "SetPoint");
  const std::string running =
      model["AirLoopHVAC:UnitarySystem"]["Rooftop"]["supply_air_fan_operating_mode_schedule_name"];
  EXPECT_EQ(model["Schedule:Constant"][running]["hourly_value"], 1);
  EXPECT_EQ(a.loop.fan.name, "AHU Supply Fan");
  EXPECT_EQ(managers_of(model, "AHU Supply Fan Outlet"), ours);
  EXPECT_EQ(managers_of(model, "AHU Cooling Coil Outlet"),
            std::vector<std::string>{"SetpointManager:MixedAir / AHU Supply Fan Outlet"})
      << "a manager at a coil inside the unit would compete";
}

TEST(UnusualModel, PlenumsAreNoRooms) {
  const json plenums = small_model_with(R"({"AirLoopHVAC:SupplyPath": {"AHU Supply Path": {"components": [
      {"component_object_type": "AirLoopHVAC:SupplyPlenum", "component_name": "Floor"},
      {"component_object_type": "AirLoopHVAC:ZoneSplitter", "component_name": "AHU Zone Splitter"}]}},
      "AirLoopHVAC:SupplyPlenum": {"Floor": {"zone_name": "Hollow Floor", "inlet_node_name": "AHU Supply Path Inlet",
      "nodes": [{"outlet_node_name": "Behind Floor"}]}},
      "AirLoopHVAC:ZoneSplitter": {"AHU Zone Splitter": {"inlet_node_name": "Behind Floor"}},
      "AirLoopHVAC:ReturnPath": {"AHU Return Path": {"components": [
      {"component_object_type": "AirLoopHVAC:ReturnPlenum", "component_name": "Ceiling"}]}},
      "AirLoopHVAC:ReturnPlenum": {"Ceiling": {"zone_name": "Ceiling Void"}}})");
  const Adoption a = examine(plenums, "m", "");
  EXPECT_EQ(a.loop.terminals.size(), 5U);
  EXPECT_TRUE(said(a.loop.notes, "supply plenum \"Hollow Floor\""));
  EXPECT_TRUE(said(a.loop.notes, "return plenum \"Ceiling Void\""));
}

TEST(UnusualModel, NamesWithUmlautsAndAnotherCaseAreFound) {
  std::string text = small_model().dump();
  for (std::size_t at = 0; (at = text.find("Interior 1", at)) != std::string::npos;)
    text.replace(at, 10, "Büro <Süd>, 1");
  json model = sim::parse_json(text, "m");
  model["AirLoopHVAC"]["AHU"]["branch_list_name"] = "ahu BRANCHES";
  const Adoption a = examine(model, "m", "ahu");
  EXPECT_EQ(a.loop.terminals[0].zone, "Büro <Süd>, 1");
}

TEST(UnusualModel, ScheduleOfOurNameIsLeftAlone) {
  const json taken = small_model_with(R"({"Schedule:Constant": {"Airside Supply Setpoint": {"hourly_value": 3}}})");
  const Adoption a = examine(taken, "m", "");
  EXPECT_EQ(a.setpoint.schedule, "airside supply setpoint 2");
  EXPECT_EQ(patched(taken, a)["Schedule:Constant"]["Airside Supply Setpoint"]["hourly_value"], 3);
}

TEST(UnusualModel, ZoneWithoutThermostatAndLoopWithoutOutdoorAirAreAdopted) {
  const json bare = small_model_with(R"({"ZoneControl:Thermostat": null, "Branch": {"AHU Main Branch": {"components": [
      {"component_object_type": "Coil:Cooling:Water", "component_name": "AHU Cooling Coil",
       "component_inlet_node_name": "AHU Air Loop Inlet", "component_outlet_node_name": "AHU Cooling Coil Outlet"},
      {"component_object_type": "Fan:VariableVolume", "component_name": "AHU Supply Fan",
       "component_inlet_node_name": "AHU Cooling Coil Outlet",
       "component_outlet_node_name": "AHU Supply Fan Outlet"}]}}})");
  const Adoption a = examine(bare, "m", "");
  EXPECT_FALSE(a.loop.terminals[0].thermostat);
  EXPECT_TRUE(a.loop.mixed_air_node.empty());
  EXPECT_FALSE(a.loop.outdoor_air_treated);
}

TEST(UnusualModel, ALoopIsMeteredByItselfWhereNoPlantServesIt) {
  const json model = {
      {"AirLoopHVAC", {{"A", {{"design_supply_air_flow_rate", 4.0}}}}},
      {"Coil:Cooling:DX:TwoSpeed", {{"cold", json::object()}}},
      {"Coil:Heating:Fuel", {{"hot", json::object()}}},
      {"AirTerminal:SingleDuct:VAV:Reheat",
       {{"box", {{"reheat_coil_object_type", "Coil:Heating:Electric"}, {"reheat_coil_name", "box coil"}}}}}};
  const ModelView view(model, "m");
  AirLoop loop;
  loop.name = "A";
  loop.components = {{"Coil:Cooling:DX:TwoSpeed", "cold", "", ""},
                     {"Coil:Heating:Fuel", "hot", "", ""},
                     {"Fan:VariableVolume", "fan", "", ""}};
  loop.terminals.push_back({.type = "AirTerminal:SingleDuct:VAV:Reheat", .name = "box", .zone = "z"});
  const LoopMeters own = loop_meters(view, loop);
  EXPECT_TRUE(own.fans && own.cooling && own.heating);
  EXPECT_EQ(own.patch["Meter:Custom"].size(), 4U);
  EXPECT_EQ(own.patch["Meter:Custom"][loop_heating_meter]["variable_details"][0]["key_name"], "box coil");
  EXPECT_EQ(own.patch["Meter:Custom"][loop_gas_meter]["resource_type"], "NaturalGas");

  json propane = model;
  propane["Coil:Heating:Fuel"]["hot"]["fuel_type"] = "Propane";
  const ModelView other_fuel(propane, "m");
  EXPECT_FALSE(loop_meters(other_fuel, loop).heating) << "no meter of a site shows that fuel";

  loop.components.push_back({"Coil:Heating:Water", "served by a boiler", "", ""});
  loop.components.front().type = "Coil:Cooling:Water";
  const LoopMeters served = loop_meters(view, loop);
  EXPECT_TRUE(served.fans);
  EXPECT_FALSE(served.cooling || served.heating);
  EXPECT_EQ(served.patch["Meter:Custom"].size(), 1U) << "fans alone";
}

TEST(UnusualModel, PartsBesideTheBranchesAreMeteredToo) {
  json model = {{"AirLoopHVAC:OutdoorAirSystem", {{"oa", {{"outdoor_air_equipment_list_name", "oa parts"}}}}},
                {"AirLoopHVAC:OutdoorAirSystem:EquipmentList",
                 {{"oa parts",
                   {{"component_1_object_type", "OutdoorAir:Mixer"},
                    {"component_1_name", "mixer"},
                    {"component_2_object_type", "Coil:Heating:Water"},
                    {"component_2_name", "preheat"},
                    {"component_3_object_type", "Fan:SystemModel"},
                    {"component_3_name", "outdoor fan"}}}}},
                {"AirLoopHVAC:UnitarySystem", {{"unit", {{"supply_fan_name", "unit fan"}}}}},
                {"AirTerminal:SingleDuct:SeriesPIU:Reheat",
                 {{"box",
                   {{"fan_name", "box fan"},
                    {"reheat_coil_object_type", "Coil:Heating:Electric"},
                    {"reheat_coil_name", "box coil"}}}}}};
  AirLoop loop;
  loop.name = "A";
  loop.components = {{"Fan:ConstantVolume", "return fan", "", ""},
                     {"AirLoopHVAC:OutdoorAirSystem", "oa", "", ""},
                     {"AirLoopHVAC:UnitarySystem", "unit", "", ""}};
  loop.fan = {"Fan:SystemModel", "Unit Fan", "", ""};
  loop.terminals.push_back({.type = "AirTerminal:SingleDuct:SeriesPIU:Reheat", .name = "box", .zone = "z"});
  const auto keys_of = [](const LoopMeters& meters) {
    std::set<std::string> keys;
    for (const json& part : meters.patch["Meter:Custom"][loop_fans_meter]["variable_details"])
      keys.insert(part["key_name"].get<std::string>());
    return keys;
  };
  const LoopMeters own = loop_meters(ModelView(model, "m"), loop);
  EXPECT_EQ(keys_of(own), (std::set<std::string>{"box fan", "outdoor fan", "return fan", "unit fan"}));
  EXPECT_FALSE(own.heating) << "the preheat coil is served by a plant";

  model["AirLoopHVAC:OutdoorAirSystem:EquipmentList"]["oa parts"]["component_2_object_type"] = "Coil:Heating:Electric";
  const LoopMeters electric = loop_meters(ModelView(model, "m"), loop);
  EXPECT_TRUE(electric.heating);
  EXPECT_EQ(electric.patch["Meter:Custom"][loop_heating_meter]["variable_details"].size(), 2U) << "preheat and box";
}

TEST(UnusualModel, AHeatingCoilOfTheLoopIsSizedByTheEngineAtEachStart) {
  if (!sim::have_energyplus()) GTEST_SKIP() << "no EnergyPlus";
  const json water = {{"u_factor_times_area_value", "Autosize"}, {"maximum_water_flow_rate", "Autosize"}};
  const json model = {{"Coil:Heating:Water", {{"main", water}, {"box coil", water}}},
                      {"AirTerminal:SingleDuct:VAV:Reheat", {{"box", {{"reheat_coil_name", "Box Coil"}}}}}};
  const TemporaryFolder folder;
  const std::filesystem::path eio = std::filesystem::path(folder.path()) / "eplusout.eio";
  std::ofstream(eio)
      << " Component Sizing Information, Coil:Heating:Water, MAIN, Design Size u-factor_times_area_value "
         "[W/K], 5788.8\n"
         " Component Sizing Information, Coil:Heating:Water, MAIN, Design Size maximum_water_flow_rate "
         "[m3/s], 0.0096\n"
         " Component Sizing Information, Coil:Heating:Water, BOX COIL, Design Size "
         "u-factor_times_area_value [W/K], 260.4\n";
  const FoundSizes sizes = sizes_of_run(ModelView(model, "m"), eio, sim::find_energyplus().schema);
  const json& coils = sizes.patch.at("Coil:Heating:Water");
  EXPECT_FALSE(coils.at("main").contains("u_factor_times_area_value")) << "its design flow is not its largest flow";
  EXPECT_DOUBLE_EQ(coils.at("main").at("maximum_water_flow_rate"), 0.0096);
  EXPECT_DOUBLE_EQ(coils.at("box coil").at("u_factor_times_area_value"), 260.4);
}

TEST(UnusualModel, AHolidayOfTheModelIsNoDayThatIsCompared) {
  if (!sim::have_energyplus()) GTEST_SKIP() << "no EnergyPlus";
  json model = small_model();
  json& schedule = model["Schedule:Compact"]["nobody on holidays"];
  schedule["schedule_type_limits_name"] = "Any Number";
  for (const json& field : {json("Through: 12/31"), json("For: Holidays"), json("Until: 24:00"), json(0.0),
                            json("For: AllOtherDays"), json("Until: 24:00"), json(1.0)})
    schedule["data"].push_back({{"field", field}});
  for (json& people : model["People"]) people["number_of_people_schedule_name"] = "nobody on holidays";
  model["RunPeriodControl:SpecialDays"]["Columbus Day"] = {
      {"start_date", "2nd Monday in October"}, {"duration", 1}, {"special_day_type", "Holiday"}};
  const AirLoop loop = walk_air_loop(ModelView(model, "m"), "AHU");
  const TemporaryFolder folder;
  const sim::EnergyPlusInstall install = sim::find_energyplus();
  const ObservationPlan plan{&model, &loop, sim::default_weather(install), 10, 11, 2};
  const Observation seen = observe(plan, install, folder.path(), "m");
  const auto steps = static_cast<std::size_t>(seen.steps_per_day);
  ASSERT_EQ(seen.steps(), 2 * steps);
  for (const auto& zone : seen.people) {
    ASSERT_EQ(zone.size(), 2 * steps);
    EXPECT_GT(zone[steps / 2], 0) << "11 October";
    EXPECT_DOUBLE_EQ(zone[steps / 2], zone[steps + steps / 2]);
  }
}

/// A week at one step an hour, people from 8 to 18 on working days and to `saturday_to` on Saturday.
Observation week_of(int saturday_to) {
  Observation week;
  week.steps_per_day = 24;
  for (auto* series : {&week.supply_degc, &week.flow_kg_s}) series->assign(168, 1.0);
  week.room_degc = {std::vector<double>(168, 24.0)};
  week.people = {std::vector<double>(168, 0.0)};
  for (std::size_t i = 0; i < 168; ++i) {
    const int day = week.weekday(i), to = day < 5 ? 18 : day == 5 ? saturday_to : 0;
    if (week.hour_of_day(i) >= 8 && week.hour_of_day(i) < to) week.people[0][i] = 5;
  }
  return week;
}

TEST(UnusualModel, WeekendsOfOtherHoursAreADayTypeOfTheirOwn) {
  const SiteChoices half = site_choices(week_of(13), week_of(13), TerminalKind::fixed, {});
  EXPECT_FALSE(half.work.weekday_only);
  EXPECT_TRUE(half.two_day_types) << "ten hours and five";
  EXPECT_EQ(half.people_by_day[5], (PeopleHours{8, 13}));
  EXPECT_EQ(half.people_by_day[6], (PeopleHours{})) << "nobody";
  const SiteChoices closed = site_choices(week_of(0), week_of(0), TerminalKind::fixed, {});
  EXPECT_TRUE(closed.work.weekday_only);
  EXPECT_FALSE(closed.two_day_types) << "weekday_only says it";

  Adoption adoption;
  adoption.choices = half;
  adoption.choices.powers = {"Fans:Electricity"};
  EXPECT_NE(adoption_page(adoption).find("| day types | working days, weekends | people (else thermostats) day by day: "
                                         "Monday to Friday 08:00 to 18:00, Saturday 08:00 to 13:00, Sunday nobody"),
            std::string::npos)
      << adoption_page(adoption);
}

TEST(UnusualModel, LeastOutdoorAirIsOfTheModelOrOfItsSizing) {
  const json model = {
      {"AirLoopHVAC", {{"A", {{"design_supply_air_flow_rate", "Autosize"}}}}},
      {"AirLoopHVAC:OutdoorAirSystem", {{"OA", {{"controller_list_name", "list"}}}}},
      {"AirLoopHVAC:ControllerList",
       {{"list", {{"controller_1_object_type", "Controller:OutdoorAir"}, {"controller_1_name", "oa"}}}}},
      {"Controller:OutdoorAir", {{"oa", {{"minimum_outdoor_air_flow_rate", 1.2}}}}}};
  const ModelView view(model, "m");
  AirLoop loop;
  loop.name = "A";
  loop.components = {{"AirLoopHVAC:OutdoorAirSystem", "OA", "", ""}};
  const json sizes = {{"AirLoopHVAC", {{"A", {{"design_supply_air_flow_rate", 4.0}}}}}};
  EXPECT_DOUBLE_EQ(least_outdoor_share(view, loop, sizes), 0.3);
  EXPECT_EQ(least_outdoor_share(view, loop, json::object()), 0) << "no design flow is known";
  loop.components.clear();
  EXPECT_EQ(least_outdoor_share(view, loop, sizes), 0) << "a loop without outdoor air";
}

}  // namespace
}  // namespace airside::tools
