// What is looked for in a model that somebody else wrote; no engine takes part.

#include <gtest/gtest.h>

#include "hal/text/input_error.hpp"
#include "sim/energyplus/adopted/own_model.hpp"

namespace airside::sim {
namespace {

using nlohmann::json;

json small_model() {
  return json::parse(R"({
    "Zone": {"Core": {}, "Hall \u00e4": {}},
    "ZoneList": {"All": {"zones": [{"zone_name": "CORE"}, {"zone_name": "Hall \u00e4"}]}},
    "Space": {"Desk": {"zone_name": "Core"}},
    "SpaceList": {"Desks": {"spaces": [{"space_name": "Desk"}]}},
    "Schedule:Constant": {"Supply Setpoint": {"hourly_value": 14}},
    "Schedule:Compact": {"Office Hours": {}, "Cleaners": {}},
    "People": {
      "Staff": {"zone_or_zonelist_or_space_or_spacelist_name": "Desks", "number_of_people_schedule_name": "Office Hours"},
      "Cleaners": {"zone_or_zonelist_or_space_or_spacelist_name": "All", "number_of_people_schedule_name": "Cleaners"}},
    "AirTerminal:SingleDuct:VAV:NoReheat": {"Core VAV": {"air_inlet_node_name": "Core VAV In"}},
    "Fan:VariableVolume": {"AHU Fan": {"air_outlet_node_name": "AHU Out"}},
    "Fan:OnOff": {"Coil Fan": {}},
    "ZoneHVAC:EquipmentConnections": {"c": {"zone_name": "Hall \u00e4", "zone_conditioning_equipment_list_name": "l"}},
    "ZoneHVAC:EquipmentList": {"l": {"equipment": [
      {"zone_equipment_object_type": "ZoneHVAC:FourPipeFanCoil", "zone_equipment_name": "hall coil"}]}},
    "ZoneHVAC:FourPipeFanCoil": {"Hall Coil": {"supply_air_fan_name": "Coil Fan"}},
    "SimulationControl": {"s": {"run_simulation_for_weather_file_run_periods": "No", "do_zone_sizing_calculation": "Yes"}},
    "RunPeriodControl:DaylightSavingTime": {"d": {}},
    "Output:Variable": {"o": {}},
    "Output:Table:SummaryReports": {"t": {}}})");
}

OwnNames good_names() {
  OwnNames names;
  names.supply_setpoint_schedule = "SUPPLY SETPOINT";
  names.supply_air_node = "ahu out";
  names.zones = {"core", "Hall \u00e4"};
  names.terminals = {"Core VAV", ""};
  names.fcu_zones = {"hall \u00e4"};
  names.supply_fan = "ahu fan";
  names.occupancy = {"Core"};
  return names;
}

TEST(OwnModel, TakesNamesInAnyCase) {
  for (const hal::InputError& error : missing_own_names(small_model(), good_names(), "m"))
    ADD_FAILURE() << error.what();
}

TEST(OwnModel, SaysOfEveryWrongNameWhatIsNearIt) {
  struct {
    const char* key;
    void (*spoil)(OwnNames&);
    const char* said;
  } const cases[] = {
      {"zones", [](OwnNames& n) { n.zones[0] = "Cor"; }, "near it: 'Core'"},
      {"terminals", [](OwnNames& n) { n.terminals[0] = "Core VAW"; }, "near it: 'Core VAV'"},
      {"supply_setpoint_schedule", [](OwnNames& n) { n.supply_setpoint_schedule = "supply"; }, "'Supply Setpoint'"},
      {"supply_setpoint_schedule", [](OwnNames& n) { n.supply_setpoint_schedule = "cleaners"; }, "Schedule:Compact"},
      {"supply_air_node", [](OwnNames& n) { n.supply_air_node = "AHU Outt"; }, "near it: 'AHU Out'"},
      {"mau_outlet_node", [](OwnNames& n) { n.mau_outlet_node = "VAV In"; }, "'Core VAV In'"},
      {"supply_fan", [](OwnNames& n) { n.supply_fan = "Fan"; }, "'AHU Fan'"},
      {"fcu_zones", [](OwnNames& n) { n.fcu_zones[0] = "Core"; }, "no unit with a fan"},
      {"occupancy", [](OwnNames& n) { n.occupancy[0] = "Attic"; }, "no 'Attic'"},
  };
  for (const auto& c : cases) {
    OwnNames names = good_names();
    c.spoil(names);
    const auto missing = missing_own_names(small_model(), names, "m.epJSON");
    ASSERT_EQ(missing.size(), 1U) << c.key;
    EXPECT_EQ(missing[0].place(), std::string("m.epJSON: ") + c.key);
    EXPECT_NE(missing[0].found().find(c.said), std::string::npos) << missing[0].what();
  }
}

TEST(OwnModel, FindsPeopleThroughListsAndSpacesAndTheFanInAZonesUnit) {
  const OwnParts parts = own_parts(small_model(), good_names());
  EXPECT_EQ(parts.people_schedules, (std::vector<std::string>{"Cleaners", "Office Hours"}));
  EXPECT_EQ(parts.fcu_fans, std::vector<std::string>{"Coil Fan"});
  OwnNames hall = good_names();
  hall.occupancy = {"Hall \u00e4"};
  EXPECT_EQ(own_parts(small_model(), hall).people_schedules, std::vector<std::string>{"Cleaners"});
}

TEST(OwnModel, RunsTheWeatherFileWithoutReportsAndDaylightSaving) {
  json model = small_model();
  prepare_own_model(model, "m");
  EXPECT_FALSE(model.contains("Output:Variable"));
  EXPECT_FALSE(model.contains("Output:Table:SummaryReports"));
  EXPECT_FALSE(model.contains("RunPeriodControl:DaylightSavingTime"));
  ASSERT_EQ(model["SimulationControl"].size(), 1U);
  const json& control = *model["SimulationControl"].begin();
  EXPECT_EQ(control["run_simulation_for_weather_file_run_periods"], "Yes");
  EXPECT_EQ(control["do_zone_sizing_calculation"], "Yes");
  EXPECT_TRUE(model.contains("People"));
}

TEST(OwnModel, RefusesTemplatesThatNobodyHasExpanded) {
  json model = small_model();
  model["HVACTemplate:Zone:VAV"] = {{"t", json::object()}};
  EXPECT_THROW(prepare_own_model(model, "m"), hal::InputError);
}

}  // namespace
}  // namespace airside::sim
