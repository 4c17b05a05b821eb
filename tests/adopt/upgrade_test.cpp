// Small IDFs of our own, one step each: what a version changed is changed, and what needs more is refused.

#include <gtest/gtest.h>

#include <algorithm>

#include "support/complaint.hpp"
#include "tools/adopt/upgrade/upgrade.hpp"

namespace airside::tools {
namespace {

struct StepCase {
  const char* name;
  const char* from;
  const char* to;
  std::string before, after;
};

void PrintTo(const StepCase& c, std::ostream* out) { *out << c.name; }

/// Without blanks before and line ends behind fields.
std::string packed(const std::string& text) {
  std::string out;
  for (std::size_t at = 0; at < text.size(); ++at) {
    if (text[at] == '\n') {
      while (at + 1 < text.size() && (text[at + 1] == ' ' || text[at + 1] == '\n')) ++at;
    } else {
      out += text[at];
    }
  }
  return out;
}

const std::string heat_recovery = "HeatExchanger:AirToAir:SensibleAndLatent,HX,On,1,";

std::vector<StepCase> envelope_steps() {
  return {
      {"RunPeriodGetsYears", "8.9", "9.0", "RunPeriod,R,7,1,6,30,UseWeatherFile,Yes,No,No,Yes,Yes,1,Yes,2017;",
       "RunPeriod,R,7,1,2017,6,30,2018,,Yes,No,No,Yes,Yes;"},
      {"RunPeriodWithADay", "8.9", "9.0", "RunPeriod,,1,1,12,31,Tuesday;", "RunPeriod,,1,1,,12,31,,Tuesday;"},
      {"CustomRange", "8.9", "9.0", "RunPeriod:CustomRange,R,1,1,2017,2,1,2017,UseWeatherFile,Yes;",
       "RunPeriod,R,1,1,2017,2,1,2017,,Yes;"},
      {"ShadingNamesItsWindows", "8.9", "9.0",
       "BuildingSurface:Detailed,W,Wall,C,Zone 1,Outdoors;FenestrationSurface:Detailed,F,Window,C,w,,0.5,s,Frame;"
       "WindowProperty:ShadingControl,S,InteriorShade,,AlwaysOn,,,No,No,Cloth;",
       "BuildingSurface:Detailed,W,Wall,C,Zone 1,Outdoors;FenestrationSurface:Detailed,F,Window,C,w,,0.5,Frame;"
       "WindowShadingControl,S,Zone 1,1,InteriorShade,,AlwaysOn,,,No,No,Cloth,,,,,Sequential,F;"},
      {"EquipmentListIsWider", "9.0", "9.1", "ZoneHVAC:EquipmentList,L,SequentialLoad,A,a,1,1,B,b,2,2;",
       "ZoneHVAC:EquipmentList,L,SequentialLoad,A,a,1,1,,,B,b,2,2;"},
      {"FractionIsASchedule", "9.1", "9.2", "ZoneHVAC:EquipmentList,L,SequentialLoad,A,a,1,1,0.4;RunPeriod,,1,1;",
       "ZoneHVAC:EquipmentList,L,SequentialLoad,A,a,1,1,L Fraction 6;RunPeriod,Run Period 1,1,1;"
       "Schedule:Constant,L Fraction 6,,0.4;"},
      {"ShadowsHaveAMethod", "9.2", "9.3",
       "ShadowCalculation,TimestepFrequency,30,15000,SutherlandHodgman,SimpleSkyDiffuseModeling,ImportedShading,No,"
       "Yes;",
       "ShadowCalculation,Imported,Timestep,30,15000,SutherlandHodgman,,SimpleSkyDiffuseModeling,No,Yes;"},
      {"WordsOfGeometry", "9.2", "9.3", "GlobalGeometryRules,ULC,ccw,WCS,Relative;Building,B,0,City;",
       "GlobalGeometryRules,UpperLeftCorner,Counterclockwise,World,Relative;Building,B,0,City,,,,,6;"},
      {"OneDiagnostics", "9.3", "9.4", "Output:Diagnostics,A;Zone,Z;Output:Diagnostics,B,C;",
       "Output:Diagnostics,A,B,C;Zone,Z;"},
      {"AirBoundary", "9.4", "9.5", "Construction:AirBoundary,B,GroupedZones,GroupedZones,SimpleMixing,0.5,;",
       "Construction:AirBoundary,B,SimpleMixing,0.5,;"},
      {"SurfacesHaveSpaces", "9.5", "9.6", "BuildingSurface:Detailed,W,Wall,C,Z,Outdoors,,SunExposed;Roof,R,C,Z,0;",
       "BuildingSurface:Detailed,W,Wall,C,Z,,Outdoors,,SunExposed;Roof,R,C,Z,,0;"},
      {"PeopleAndEnclosures", "23.2", "24.1", "People,P,Z,S,People,1,,,0.3,,A,,,ZoneAveraged;",
       "People,P,Z,S,People,1,,,0.3,,A,,,EnclosureAveraged;"},
      {"NothingChanges", "22.2", "23.1", "Version,22.2;Zone,Z;Gone:Fishing,1,2;",
       "Version,23.1;Zone,Z;Gone:Fishing,1,2;"},
      {"NothingChangesIn25", "24.2", "25.1", "Version,24.2;Zone,Z;", "Version,25.1;Zone,Z;"},
  };
}

std::vector<StepCase> system_steps() {
  return {
      {"Boiler", "8.9", "9.0", "Boiler:HotWater,B,Electricity,1000,0.8,L,C,60,0.1;",
       "Boiler:HotWater,B,Electricity,1000,0.8,L,C,0.1;"},
      {"UncontrolledTerminal", "9.2", "9.3",
       "AirTerminal:SingleDuct:Uncontrolled,T,On,Node,0.5;ZoneHVAC:EquipmentList,L,,"
       "AirTerminal:SingleDuct:Uncontrolled,t,1,1;AirLoopHVAC:ZoneSplitter,S,In,Other,node;",
       "ZoneHVAC:EquipmentList,L,,ZoneHVAC:AirDistributionUnit,T ADU,1,1;AirLoopHVAC:ZoneSplitter,S,In,Other,Node "
       "ATInlet;ZoneHVAC:AirDistributionUnit,T ADU,Node,AirTerminal:SingleDuct:ConstantVolume:NoReheat,T;"
       "AirTerminal:SingleDuct:ConstantVolume:NoReheat,T,On,Node ATInlet,Node,0.5;"},
      {"NodeInAList", "9.2", "9.3",
       "AirTerminal:SingleDuct:Uncontrolled,T,,N;NodeList,Inlets,N;AirLoopHVAC,A,,,1,B,,i,o,Inlets;",
       "NodeList,Inlets,N;AirLoopHVAC,A,,,1,B,,i,o,Inlets ATInlet;NodeList,Inlets ATInlet,N ATInlet;"
       "ZoneHVAC:AirDistributionUnit,T ADU,N,AirTerminal:SingleDuct:ConstantVolume:NoReheat,T;"
       "AirTerminal:SingleDuct:ConstantVolume:NoReheat,T,,N ATInlet,N;"},
      {"Fuels", "9.2", "9.3", "Boiler:HotWater,B,Gas;Coil:Heating:Fuel,C,,FuelOil#1;",
       "Boiler:HotWater,B,NaturalGas;Coil:Heating:Fuel,C,,FuelOilNo1;"},
      {"SensorNames", "9.3", "9.4", "EnergyManagementSystem:Sensor,S,F,Fan Electric Power;",
       "EnergyManagementSystem:Sensor,S,F,Fan Electricity Rate;"},
      {"OutdoorAirSystem", "9.5", "9.6", "AirLoopHVAC:OutdoorAirSystem,O,C,E,M;",
       "AirLoopHVAC:OutdoorAirSystem,O,C,E;"},
      {"PluginPaths", "9.6", "22.1", "PythonPlugin:SearchPaths,P,Yes,Yes,a;", "PythonPlugin:SearchPaths,P,Yes,Yes,,a;"},
      {"FanPowerOfTwoYears", "22.1", "22.2", "Coil:Cooling:DX:SingleSpeed,C,On,1,0.7,3,0.1,773,In;",
       "Coil:Cooling:DX:SingleSpeed,C,On,1,0.7,3,0.1,773,,In;"},
      {"DistrictHeat", "23.1", "23.2", "DistrictHeating,D,i,o,1;Branch,B,,DistrictHeating,D,i,o;",
       "DistrictHeating:Water,D,i,o,1;Branch,B,,DistrictHeating:Water,D,i,o;"},
      {"TwoSpeedCoil", "23.1", "23.2", "Coil:Cooling:DX:TwoSpeed,C,On,1,0.7,3,0.1,400,In,Out;",
       "Coil:Cooling:DX:TwoSpeed,C,On,1,0.7,3,0.1,,,400,In,Out;"},
      {"HeatRecoveryWithATable", "23.2", "24.1", heat_recovery + "0.7,0.6,0.75,0.6,0.7,0.6,0.7,0.6,a,b;",
       heat_recovery +
           "0.7,0.6,0.7,0.6,a,b,,,,,,,,,,,HX Effectiveness 1;"
           "Table:Lookup,HX Effectiveness 1,Heat Exchanger Flow Ratios,DivisorOnly,0.7,0,10,Dimensionless,,,,0.75,0.7;"
           "Table:IndependentVariableList,Heat Exchanger Flow Ratios,Heat Exchanger Flow Ratio;"
           "Table:IndependentVariable,Heat Exchanger Flow Ratio,Linear,Linear,0,10,,Dimensionless,,,,0.75,1;"},
      {"HeatRecoveryWithout", "23.2", "24.1", heat_recovery + "0.7,0.6,0.7,0.6,0.7,0.6,0.7,0.6,a,b;",
       heat_recovery + "0.7,0.6,0.7,0.6,a,b;"},
      {"NoLowSpeedWithoutLoad", "23.2", "24.1", "ZoneHVAC:PackagedTerminalHeatPump,P,On,i,o,,,a,b,c,0.1;",
       "ZoneHVAC:PackagedTerminalHeatPump,P,On,i,o,,,a,b,c,No,0.1;"},
      {"LowSpeedOfAVariableCoil", "23.2", "24.1",
       "ZoneHVAC:PackagedTerminalHeatPump,P,On,i,o,,,a,b,c,0.1,Coil:Cooling:DX:VariableSpeed;",
       "ZoneHVAC:PackagedTerminalHeatPump,P,On,i,o,,,a,b,c,Yes,0.1,Coil:Cooling:DX:VariableSpeed;"},
      {"HeatPump", "24.1", "24.2", "HeatPump:PlantLoop:EIR:Heating,H,a,b,c,d,e,f,g,h,i,j;",
       "HeatPump:PlantLoop:EIR:Heating,H,a,b,c,d,e,,,f,g,h,,i,j;"},
      {"CoilHasASchedule", "25.1", "25.2", "Coil:Heating:DX:VariableSpeed,C,In,Out;",
       "Coil:Heating:DX:VariableSpeed,C,,In,Out;"},
  };
}

class UpgradeStep : public testing::TestWithParam<StepCase> {};

TEST_P(UpgradeStep, ChangesWhatTheVersionChanged) {
  const StepCase& c = GetParam();
  Upgrade done;
  EXPECT_EQ(packed(upgraded_idf(c.before, "m.idf", c.from, c.to, done)), c.after);
  EXPECT_EQ(done.from, c.from);
  EXPECT_EQ(done.to, c.to);
}

std::string step_case_name(const testing::TestParamInfo<StepCase>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(Envelope, UpgradeStep, testing::ValuesIn(envelope_steps()), step_case_name);
INSTANTIATE_TEST_SUITE_P(Systems, UpgradeStep, testing::ValuesIn(system_steps()), step_case_name);

struct RefusedCase {
  const char* name;
  const char* from;
  const char* idf;
  hal::Complaint want;
};

void PrintTo(const RefusedCase& c, std::ostream* out) { *out << c.name; }

const RefusedCase refused_cases[] = {
    {"TableOfOldKind",
     "9.0",
     "Version,9.0;\n\nTable:OneIndependentVariable, Pump curve,\n Linear;\nTable:OneIndependentVariable,B;\n"
     "Table:TwoIndependentVariables,C;",
     {"m.idf:3: Table:OneIndependentVariable / Pump curve", "of EnergyPlus 9.1 that 9.2 changed", "tables bring",
      "--transitions"}},
    {"OthersAreCounted",
     "9.0",
     "Table:OneIndependentVariable,A;Table:OneIndependentVariable,B;Table:MultiVariableLookup,C;",
     {"m.idf:1: ", "1 more of this type; 1 of Table:MultiVariableLookup", "", ""}},
    {"CoefficientsOfACoil",
     "9.4",
     "Coil:Heating:WaterToAirHeatPump:EquationFit,C,a;",
     {"Coil:Heating:WaterToAirHeatPump:EquationFit / C", "curves of their own", "", "--transitions"}},
    {"RadiantFloor", "8.9", "Construction:InternalSource,Floor,1;", {"/ Floor", "9.4 that 9.5 changed", "", ""}},
    {"InteriorWindow", "9.4", "Construction:AirBoundary,B,InteriorWindow;", {"/ B", "group their zones", "", ""}},
    {"RepeatedRun", "8.9", "RunPeriod,R,1,1,12,31,,,,,,,3;", {"RunPeriod / R", "is repeated", "", ""}},
    {"FunctionThatIsGone",
     "9.2",
     "EnergyManagementSystem:Program,P,SET c = @cpairfnwtdb w t;",
     {"EnergyManagementSystem:Program / P", "@CpAirFnW now", "", ""}},
    {"UnitaryHeatPump",
     "22.1",
     "AirLoopHVAC:UnitarySystem,U,,,,,,,,,,,,,,Coil:Cooling:WaterToAirHeatPump:EquationFit;",
     {"AirLoopHVAC:UnitarySystem / U", "fields of its coils", "", ""}},
    {"ShadingWithoutAZone",
     "8.9",
     "Window,W,C,Nowhere,S;WindowProperty:ShadingControl,S,InteriorShade;",
     {"WindowProperty:ShadingControl / S", "which is not found", "", ""}},
    {"ObjectWithoutAnEnd", "9.0", "Version,9.0;\nZone,\n A\n", {"m.idf:2", "does not end", "\";\"", "copy is whole"}},
};

class RefusedUpgrade : public testing::TestWithParam<RefusedCase> {};

TEST_P(RefusedUpgrade, SaysWhereAndWhy) {
  const RefusedCase& c = GetParam();
  hal::expect_complaint(c.want, [&] {
    Upgrade done;
    (void)upgraded_idf(c.idf, "m.idf", c.from, "25.2", done);
  });
}

std::string refused_case_name(const testing::TestParamInfo<RefusedCase>& info) { return info.param.name; }
INSTANTIATE_TEST_SUITE_P(Model, RefusedUpgrade, testing::ValuesIn(refused_cases), refused_case_name);

TEST(Upgrade, CountsObjectsByTypeAndStep) {
  Upgrade done;
  (void)upgraded_idf(
      "! 9.5\nVersion,9.5;Wall:Exterior,A,C,Z,180;Wall:Exterior,B,C,Z,90;"
      "Coil:Cooling:DX:SingleSpeed,C,On,1,0.7,3,0.1,773,In,Out,a,b,c,d,e,0,1,,,,,,,,,,,,X,Y;Zone,Z;",
      "m.idf", "9.5", "25.2", done);
  ASSERT_EQ(done.types.size(), 2U);
  EXPECT_EQ(text_of(done), "upgraded from EnergyPlus 9.5 to 25.2: 3 objects of 2 types");
  EXPECT_EQ(text_of(Upgrade{}), "");
  EXPECT_EQ(text_of(Upgrade{"9.6", "25.2", "", {{"Roof", 1, "9.6"}}}),
            "upgraded from EnergyPlus 9.6 to 25.2: 1 object of 1 type");
  EXPECT_EQ(done.types[0].type, "Coil:Cooling:DX:SingleSpeed");
  EXPECT_EQ(done.types[0].versions, "22.2, 23.2");
  EXPECT_EQ(done.types[1].type, "Wall:Exterior");
  EXPECT_EQ(done.types[1].objects, 2);
}

TEST(Upgrade, KnowsItsVersions) {
  EXPECT_EQ(oldest_version(), "8.9");
  EXPECT_TRUE(tables_lead("8.9", "25.2"));
  EXPECT_TRUE(tables_lead("24.2", "25.1"));
  EXPECT_FALSE(tables_lead("8.8", "25.2"));
  EXPECT_FALSE(tables_lead("25.2", "26.1"));
  EXPECT_TRUE(is_older("9.6", "22.1"));
  EXPECT_FALSE(is_older("22.1", "9.6"));
  EXPECT_FALSE(is_older("9.6", "9.6"));
  EXPECT_EQ(short_version("9.0.1"), "9.0");
}

TEST(Upgrade, EpjsonKeepsItsNames) {
  auto model = nlohmann::json::parse(R"({"Version": {"Version 1": {"version_identifier": "9.5"}},
    "Lights": {"L": {"zone_or_zonelist_name": "Z", "watts_per_zone_floor_area": 8}},
    "Daylighting:Controls": {"D": {"control_data": [{"fraction_of_zone_controlled_by_reference_point": 0.5}]}},
    "AirLoopHVAC:OutdoorAirSystem": {"O": {"availability_manager_list_name": "M", "controller_list_name": "C"}},
    "DistrictHeating": {"H": {"inlet_node_name": "i"}}, "Zone": {"Z": {}}})");
  Upgrade done;
  upgrade_epjson(model, "m.epJSON", "9.5", "25.2", done);
  EXPECT_EQ(model, nlohmann::json::parse(R"({"Version": {"Version 1": {"version_identifier": "25.2"}},
    "Lights": {"L": {"zone_or_zonelist_or_space_or_spacelist_name": "Z", "watts_per_floor_area": 8}},
    "Daylighting:Controls": {"D": {"control_data": [{"fraction_of_lights_controlled_by_reference_point": 0.5}]}},
    "AirLoopHVAC:OutdoorAirSystem": {"O": {"controller_list_name": "C"}},
    "DistrictHeating:Water": {"H": {"inlet_node_name": "i"}}, "Zone": {"Z": {}}})"));
  EXPECT_EQ(done.objects(), 4);
  EXPECT_EQ(done.types.back().versions, "9.6, 24.1");
}

TEST(Upgrade, EpjsonOfAnotherShapeIsRefused) {
  auto model = nlohmann::json::parse(R"({"Version": {"V": {"version_identifier": "9.0"}},
    "PlantEquipmentList": {"P": {"equipment_1_name": "Boiler"}}})");
  hal::expect_complaint({"m.epJSON: PlantEquipmentList / P", "its shape in epJSON is another", "", "as an IDF"}, [&] {
    Upgrade done;
    upgrade_epjson(model, "m.epJSON", "9.0", "25.2", done);
  });
}

}  // namespace
}  // namespace airside::tools
