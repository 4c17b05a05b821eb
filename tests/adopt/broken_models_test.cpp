// Models whose air loop leads nowhere, in every place where it can.

#include <gtest/gtest.h>

#include "adopt/small_model.hpp"
#include "support/complaint.hpp"
#include "tools/adopt/adoption.hpp"

namespace airside::tools {
namespace {

struct Case {
  const char* name;
  const char* patch;  ///< on the small model
  const char* air_loop;
  hal::Complaint want;
};

void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

const Case loops[] = {
    {"NoAirLoop",
     R"({"AirLoopHVAC": null})",
     "",
     {"m.idf: AirLoopHVAC", "no air loop: the zones have units of their own", "central air handling unit",
      "adopt a model with an AirLoopHVAC"}},
    {"SeveralAirLoops",
     R"({"AirLoopHVAC": {"Nord": {}}})",
     "",
     {"m.idf: AirLoopHVAC", "2 air loops: \"AHU\", \"Nord\"", "one to adopt", "--air-loop \"AHU\""}},
    {"AirLoopOfAnotherName", "{}", "Nord", {"--air-loop", "\"Nord\"", "\"AHU\"", "choose one"}},
    {"NoBranchList",
     R"({"AirLoopHVAC": {"AHU": {"branch_list_name": null}}})",
     "",
     {"AirLoopHVAC / AHU / branch_list_name", "nothing", "BranchList", "name it"}},
    {"BranchListNowhere",
     R"({"AirLoopHVAC": {"AHU": {"branch_list_name": "Air Branches"}}})",
     "",
     {"AHU / branch_list_name", "\"Air Branches\", which no object BranchList has", "BranchList", "correct the name"}},
    {"BranchNowhere",
     R"({"BranchList": {"AHU Branches": {"branches": [{"branch_name": "Nowhere"}]}}})",
     "",
     {"BranchList / AHU Branches / branches", "\"Nowhere\"", "Branch", "correct the name"}},
    {"BranchListEmpty",
     R"({"BranchList": {"AHU Branches": {"branches": []}}})",
     "",
     {"BranchList / AHU Branches", "no equipment", "air handling unit", "name its branch"}},
    {"BranchWithoutEquipment",
     R"({"Branch": {"AHU Main Branch": {"components": []}}})",
     "",
     {"Branch / AHU Main Branch / components", "without type, name or nodes", "inlet and outlet", "complete"}},
    {"EquipmentNowhere",
     R"({"Fan:VariableVolume": null})",
     "",
     {"Branch / AHU Main Branch", "\"AHU Supply Fan\"", "Fan:VariableVolume", "add that object"}},
    {"EquipmentWithoutNode",
     R"({"Branch": {"AHU Main Branch": {"components": [{"component_object_type": "Fan:VariableVolume",
         "component_name": "AHU Supply Fan", "component_outlet_node_name": "AHU Supply Fan Outlet"}]}}})",
     "",
     {"Branch / AHU Main Branch", "without type, name or nodes", "", "complete"}},
    {"SupplySideInACircle",
     R"({"Branch": {"AHU Main Branch": {"components": [{"component_object_type": "Fan:VariableVolume",
         "component_name": "AHU Supply Fan", "component_inlet_node_name": "AHU Supply Fan Outlet",
         "component_outlet_node_name": "AHU Supply Fan Outlet"}]}}})",
     "",
     {"AirLoopHVAC / AHU", "passes twice", "one behind the other", "Fan:VariableVolume / AHU Supply Fan"}},
    {"SupplyOutletNowhere",
     R"({"AirLoopHVAC": {"AHU": {"supply_side_outlet_node_names": "Nowhere"}}})",
     "",
     {"supply_side_outlet_node_names", "\"Nowhere\"", "\"AHU Supply Fan Outlet\"", "correct the branch"}},
    {"TwoSupplyOutlets",
     R"({"AirLoopHVAC": {"AHU": {"supply_side_outlet_node_names": "AHU Mixed Air Nodes"}}})",
     "",
     {"supply_side_outlet_node_names", "2 nodes", "one supply outlet", "single-duct"}},
    {"NoSupplyOutlet",
     R"({"AirLoopHVAC": {"AHU": {"supply_side_outlet_node_names": null}}})",
     "",
     {"supply_side_outlet_node_names", "no node", "one supply outlet", "name the node"}},
    {"NoDemandInlet",
     R"({"AirLoopHVAC": {"AHU": {"demand_side_inlet_node_names": ""}}})",
     "",
     {"demand_side_inlet_node_names", "no node", "one inlet", "name the node"}},
    {"OutdoorAirListNowhere",
     R"({"AirLoopHVAC:OutdoorAirSystem:EquipmentList": null})",
     "",
     {"AirLoopHVAC:OutdoorAirSystem / AHU OA System", "\"AHU OA System Equipment\"", "EquipmentList", "correct"}},
    {"OutdoorAirMixerNowhere",
     R"({"OutdoorAir:Mixer": {"AHU OA Mixing Box": null}})",
     "",
     {"EquipmentList / AHU OA System Equipment / component_3_name", "\"AHU OA Mixing Box\"", "OutdoorAir:Mixer", ""}},
};

const Case zones[] = {
    {"NoSupplyPath",
     R"({"AirLoopHVAC:SupplyPath": null})",
     "",
     {"demand_side_inlet_node_names", "no AirLoopHVAC:SupplyPath begins", "supply path", "add the path"}},
    {"SupplyPathElsewhere",
     R"({"AirLoopHVAC:SupplyPath": {"AHU Supply Path": {"supply_air_path_inlet_node_name": "Nowhere"}}})",
     "",
     {"demand_side_inlet_node_names", "\"AHU Supply Path Inlet\"", "supply path", "correct the node"}},
    {"SplitterNowhere",
     R"({"AirLoopHVAC:ZoneSplitter": null})",
     "",
     {"AirLoopHVAC:SupplyPath / AHU Supply Path", "\"AHU Zone Splitter\"", "ZoneSplitter", "add that object"}},
    {"NoSplitter",
     R"({"AirLoopHVAC:SupplyPath": {"AHU Supply Path": {"components": []}}})",
     "",
     {"AirLoopHVAC:SupplyPath / AHU Supply Path", "no zone splitter", "splitter", "name it"}},
    {"SplitterOfAnotherInlet",
     R"({"AirLoopHVAC:ZoneSplitter": {"AHU Zone Splitter": {"inlet_node_name": "Elsewhere"}}})",
     "",
     {"ZoneSplitter / AHU Zone Splitter / inlet_node_name", "\"Elsewhere\"", "\"AHU Supply Path Inlet\"", "correct"}},
    {"SupplyPathInACircle",
     R"({"AirLoopHVAC:ZoneSplitter": {"AHU Zone Splitter": {"nodes": [{"outlet_node_name": "AHU Supply Path Inlet"}]}}})",
     "",
     {"ZoneSplitter / AHU Zone Splitter", "back to itself", "ends at terminals", "inlet and outlet nodes"}},
    {"NoZone",
     R"({"AirLoopHVAC:ZoneSplitter": {"AHU Zone Splitter": {"nodes": []}}})",
     "",
     {"AirLoopHVAC / AHU", "no zone on this loop", "at least one zone", "choose another loop"}},
    {"TerminalNowhere",
     R"({"AirTerminal:SingleDuct:VAV:NoReheat": {"Interior 3 VAV": null}})",
     "",
     {"AirLoopHVAC / AHU", "\"Interior 3 VAV Inlet\"", "AirTerminal with this inlet", "add the terminal"}},
    {"TerminalOfUnknownKind",
     R"({"AirTerminal:SingleDuct:VAV:NoReheat": {"Interior 3 VAV": null},
         "AirTerminal:DualDuct:VAV": {"Interior 3 VAV": {"cold_air_inlet_node_name": "Interior 3 VAV Inlet"}}})",
     "",
     {"AirTerminal:DualDuct:VAV / Interior 3 VAV", "kind that is not known", "single-duct", "another air loop"}},
    {"NoDistributionUnit",
     R"({"ZoneHVAC:AirDistributionUnit": {"Interior 2 ATU": null}})",
     "",
     {"Interior 2 VAV", "no ZoneHVAC:AirDistributionUnit", "belongs to a zone", "air_terminal_name"}},
    {"UnitInNoList",
     R"({"ZoneHVAC:EquipmentList": {"Interior 2 Equipment": {"equipment": []}}})",
     "",
     {"ZoneHVAC:AirDistributionUnit / Interior 2 ATU", "no zone whose equipment list", "EquipmentList", "add it"}},
    {"ListOfNoZone",
     R"({"ZoneHVAC:EquipmentConnections": {"Interior 2 Connections": null}})",
     "",
     {"ZoneHVAC:AirDistributionUnit / Interior 2 ATU", "no zone", "EquipmentConnections", "add it"}},
    {"ZoneNowhere",
     R"({"Zone": {"Interior 4": null}})",
     "",
     {"ZoneHVAC:EquipmentConnections", "\"Interior 4\"", "a Zone of the model", "add that zone"}},
    {"ReturnMixerNowhere",
     R"({"AirLoopHVAC:ZoneMixer": null})",
     "",
     {"AirLoopHVAC:ReturnPath / AHU Return Path", "\"AHU Zone Mixer\"", "ZoneMixer", "add that object"}},
};

const Case setpoints[] = {
    {"NoSetpointManager",
     R"({"SetpointManager:Scheduled": {"AHU Supply Air Setpoint Manager": null}, "SetpointManager:MixedAir": null})",
     "",
     {"AirLoopHVAC / AHU", "no setpoint manager at \"AHU Supply Fan Outlet\"", "follow a setpoint",
      "setpoint manager"}},
    {"UnitControlledByLoad",
     R"({"AirLoopHVAC:UnitaryHeatCool": {"Rooftop": {"supply_air_fan_name": "AHU Supply Fan"}},
         "Branch": {"AHU Main Branch": {"components": [{"component_object_type": "AirLoopHVAC:UnitaryHeatCool",
         "component_name": "Rooftop", "component_inlet_node_name": "AHU Air Loop Inlet",
         "component_outlet_node_name": "AHU Supply Fan Outlet"}]}}})",
     "",
     {"AirLoopHVAC:UnitaryHeatCool / Rooftop", "controlled by the zone's load", "UnitarySystem",
      "control_type SetPoint"}},
    {"UnitWithVariableFan",
     R"({"AirLoopHVAC:UnitarySystem": {"Rooftop": {"control_type": "SingleZoneVAV"}},
         "Branch": {"AHU Main Branch": {"components": [{"component_object_type": "AirLoopHVAC:UnitarySystem",
         "component_name": "Rooftop", "component_inlet_node_name": "AHU Air Loop Inlet",
         "component_outlet_node_name": "AHU Supply Fan Outlet"}]}}})",
     "",
     {"AirLoopHVAC:UnitarySystem / Rooftop / control_type", "SingleZoneVAV", "SetPoint", "another loop"}},
    {"NamesThatDifferInCase",
     R"({"Zone": {"INTERIOR 1": {}}})",
     "",
     {"m.idf: Zone / ", "but for upper case", "each name once", "rename"}},
    {"TypeThatIsAList", R"({"Zone": [1]})", "", {"m.idf: Zone", "array", "named objects", "--convert-only"}},
    {"ObjectThatIsANumber",
     R"({"Zone": {"Interior 1": 5}})",
     "",
     {"m.idf: Zone / Interior 1", "number", "an object of fields", "--convert-only"}},
};

class BrokenModel : public testing::TestWithParam<Case> {};

TEST_P(BrokenModel, IsRefusedWithPlaceFindingExpectationAndRemedy) {
  const Case& c = GetParam();
  hal::expect_complaint(c.want, [&] { (void)examine(small_model_with(c.patch), "m.idf", c.air_loop); });
}

std::string model_case_name(const testing::TestParamInfo<Case>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(Loop, BrokenModel, testing::ValuesIn(loops), model_case_name);
INSTANTIATE_TEST_SUITE_P(Zone, BrokenModel, testing::ValuesIn(zones), model_case_name);
INSTANTIATE_TEST_SUITE_P(Setpoint, BrokenModel, testing::ValuesIn(setpoints), model_case_name);

TEST(BrokenModels, ListInsteadOfAnObjectIsRefused) {
  hal::expect_complaint({"m.idf", "array", "object types", "EnergyPlus model"},
                        [] { (void)examine(nlohmann::json::array(), "m.idf", ""); });
}

TEST(BrokenModels, MoreTerminalsThanASiteCanHaveAreRefused) {
  nlohmann::json model = small_model();
  auto& nodes = model["AirLoopHVAC:ZoneSplitter"]["AHU Zone Splitter"]["nodes"];
  for (int n = 6; n <= 33; ++n) {
    const std::string zone = "Interior " + std::to_string(n);
    nodes.push_back({{"outlet_node_name", zone + " VAV Inlet"}});
    model["Zone"][zone] = nlohmann::json::object();
    model["AirTerminal:SingleDuct:VAV:NoReheat"][zone + " VAV"] = {{"air_inlet_node_name", zone + " VAV Inlet"}};
    model["ZoneHVAC:AirDistributionUnit"][zone + " ATU"] = {
        {"air_terminal_name", zone + " VAV"}, {"air_terminal_object_type", "AirTerminal:SingleDuct:VAV:NoReheat"}};
    model["ZoneHVAC:EquipmentList"][zone + " Equipment"]["equipment"] = {
        {{"zone_equipment_object_type", "ZoneHVAC:AirDistributionUnit"}, {"zone_equipment_name", zone + " ATU"}}};
    model["ZoneHVAC:EquipmentConnections"][zone] = {{"zone_name", zone},
                                                    {"zone_conditioning_equipment_list_name", zone + " Equipment"}};
  }
  hal::expect_complaint({"AirLoopHVAC / AHU", "33 terminals", "at most 32 boxes", "smaller air loop"},
                        [&] { (void)examine(model, "m.idf", ""); });
}

}  // namespace
}  // namespace airside::tools
