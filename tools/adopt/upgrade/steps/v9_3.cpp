// What EnergyPlus 9.3 changed in the input of 9.2.

#include "tools/adopt/upgrade/steps/steps.hpp"
#include "tools/adopt/upgrade/steps/wholes.hpp"

namespace airside::tools::upgrade {

namespace {

constexpr Word fuels_9_3[] = {
    {"Gas", "NaturalGas"},          {"Natural Gas", "NaturalGas"},
    {"Electric", "Electricity"},    {"Elec", "Electricity"},
    {"FuelOil#1", "FuelOilNo1"},    {"Fuel Oil #1", "FuelOilNo1"},
    {"Fuel Oil", "FuelOilNo1"},     {"Distillate Oil", "FuelOilNo1"},
    {"FuelOil#2", "FuelOilNo2"},    {"Fuel Oil #2", "FuelOilNo2"},
    {"Residual Oil", "FuelOilNo2"}, {"PropaneGas", "Propane"},
    {"Propane Gas", "Propane"},     {"LPG", "Propane"},
};
constexpr Word corners_9_3[] = {
    {"ULC", "UpperLeftCorner"}, {"LLC", "LowerLeftCorner"}, {"LRC", "LowerRightCorner"}, {"URC", "UpperRightCorner"}};
constexpr Word turns_9_3[] = {{"CCW", "Counterclockwise"}, {"CW", "Clockwise"}};
constexpr Word systems_9_3[] = {
    {"WCS", "World"},     {"WorldCoordinateSystem", "World"},       {"Absolute", "World"},
    {"Rel", "Relative"},  {"RelativeCoordinateSystem", "Relative"}, {"Relative Coordinate System", "Relative"},
    {"Local", "Relative"}};
constexpr Word reports_9_3[] = {{"ABUPS", "AnnualBuildingUtilityPerformanceSummary"},
                                {"BEPS", "AnnualBuildingUtilityPerformanceSummary"},
                                {"IVRS", "InputVerificationandResultsSummary"},
                                {"CSS", "ComponentSizingSummary"},
                                {"SHAD", "SurfaceShadowingSummary"},
                                {"EIO", "InitializationSummary"}};
constexpr Word removed_functions_9_3[] = {{"@CpAirFnWTdb", ""}};
constexpr Word types_9_3[] = {
    {"HeatPump:WaterToWater:EIR:Heating", "HeatPump:PlantLoop:EIR:Heating"},
    {"HeatPump:WaterToWater:EIR:Cooling", "HeatPump:PlantLoop:EIR:Cooling"},
    {"AirTerminal:SingleDuct:Uncontrolled", "AirTerminal:SingleDuct:ConstantVolume:NoReheat"}};

constexpr Change changes_9_3[] = {
    words("AirConditioner:VariableRefrigerantFlow", 67, "fuel_type", fuels_9_3),
    words("Boiler:HotWater", 2, "fuel_type", fuels_9_3),
    words("Boiler:Steam", 2, "fuel_type", fuels_9_3),
    words("Chiller:CombustionTurbine", 55, "fuel_type", fuels_9_3),
    words("Chiller:EngineDriven", 36, "fuel_type", fuels_9_3),
    words("ChillerHeater:Absorption:DirectFired", 33, "fuel_type", fuels_9_3),
    words("Coil:Cooling:DX:MultiSpeed", 17, "fuel_type", fuels_9_3),
    words("Coil:Heating:DX:MultiSpeed", 16, "fuel_type", fuels_9_3),
    words("Coil:Heating:Fuel", 3, "fuel_type", fuels_9_3),
    words("EnergyManagementSystem:MeteredOutputVariable", 5, "resource_type", fuels_9_3),
    words("Exterior:FuelEquipment", 2, "fuel_use_type", fuels_9_3),
    words("FuelFactors", 1, "existing_fuel_resource_name", fuels_9_3),
    words("Generator:CombustionTurbine", 22, "fuel_type", fuels_9_3),
    words("Generator:InternalCombustionEngine", 20, "fuel_type", fuels_9_3),
    words("Generator:MicroTurbine", 12, "fuel_type", fuels_9_3),
    words("HVACTemplate:Plant:Boiler", 5, "fuel_type", fuels_9_3),
    words("HVACTemplate:System:VRF", 37, "fuel_type", fuels_9_3),
    words("LifeCycleCost:UseAdjustment", 2, "resource", fuels_9_3),
    words("LifeCycleCost:UsePriceEscalation", 2, "resource", fuels_9_3),
    words("Meter:Custom", 2, "fuel_type", fuels_9_3),
    words("Meter:CustomDecrement", 2, "fuel_type", fuels_9_3),
    words("OtherEquipment", 2, "fuel_type", fuels_9_3),
    words("WaterHeater:Mixed", 11, "heater_fuel_type", fuels_9_3),
    words("WaterHeater:Mixed", 15, "off_cycle_parasitic_fuel_type", fuels_9_3),
    words("WaterHeater:Mixed", 18, "on_cycle_parasitic_fuel_type", fuels_9_3),
    words("WaterHeater:Stratified", 17, "heater_fuel_type", fuels_9_3),
    words("WaterHeater:Stratified", 20, "off_cycle_parasitic_fuel_type", fuels_9_3),
    words("WaterHeater:Stratified", 24, "on_cycle_parasitic_fuel_type", fuels_9_3),
    words("ZoneHVAC:HighTemperatureRadiant", 8, "fuel_type", fuels_9_3),
    words("ZoneHVAC:HybridUnitaryHVAC", 18, "first_fuel_type", fuels_9_3),
    words("ZoneHVAC:HybridUnitaryHVAC", 19, "second_fuel_type", fuels_9_3),
    words("ZoneHVAC:HybridUnitaryHVAC", 20, "third_fuel_type", fuels_9_3),
    words("GlobalGeometryRules", 1, "starting_vertex_position", corners_9_3),
    words("GlobalGeometryRules", 2, "vertex_entry_direction", turns_9_3),
    words("GlobalGeometryRules", 3, "coordinate_system", systems_9_3),
    words("GlobalGeometryRules", 4, "daylighting_reference_point_coordinate_system", systems_9_3),
    words("GlobalGeometryRules", 5, "rectangular_surface_coordinate_system", systems_9_3),
    words("Output:Table:SummaryReports", 0, "", reports_9_3),
    fill("Building", 8, "minimum_number_of_warmup_days", "6"),
    insert("HeatPump:WaterToWater:EIR:Heating", 4, 1, "condenser_type", "WaterSource"),
    retype("HeatPump:WaterToWater:EIR:Heating", "HeatPump:PlantLoop:EIR:Heating"),
    insert("HeatPump:WaterToWater:EIR:Cooling", 4, 1, "condenser_type", "WaterSource"),
    retype("HeatPump:WaterToWater:EIR:Cooling", "HeatPump:PlantLoop:EIR:Cooling"),
    words("EnergyManagementSystem:Actuator", 0, "", types_9_3),
    words("Branch", 0, "", types_9_3),
    words("PlantEquipmentList", 0, "", types_9_3),
    refuse_if("EnergyManagementSystem:Program", 0, "", removed_functions_9_3,
              "its function @CpAirFnWTdb is @CpAirFnW now, without the temperature"),
    refuse_if("EnergyManagementSystem:Subroutine", 0, "", removed_functions_9_3,
              "its function @CpAirFnWTdb is @CpAirFnW now, without the temperature"),
    rename("Controller:MechanicalVentilation", "zone_name", "zone_or_zonelist_name"),
};

constexpr const char* whole_types_9_3[] = {"AirTerminal:SingleDuct:Uncontrolled", "ShadowCalculation"};

}  // namespace

Step step_to_9_3() { return {"9.2", "9.3", changes_9_3, terminals_and_shadows, whole_types_9_3}; }

}  // namespace airside::tools::upgrade
