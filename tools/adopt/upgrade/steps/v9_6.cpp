// What EnergyPlus 9.6 changed in the input of 9.5.

#include "tools/adopt/upgrade/steps/steps.hpp"

namespace airside::tools::upgrade {

namespace {

constexpr Word ventilation_9_6[] = {{"VentilationRateProcedure", "Standard62.1VentilationRateProcedure"}};

constexpr Change changes_9_6[] = {
    remove("AirLoopHVAC:OutdoorAirSystem", 4, "availability_manager_list_name"),
    insert("BuildingSurface:Detailed", 5),
    insert("Ceiling:Adiabatic", 4),
    insert("Ceiling:Interzone", 4),
    insert("Floor:Adiabatic", 4),
    insert("Floor:Detailed", 4),
    insert("Floor:GroundContact", 4),
    insert("Floor:Interzone", 4),
    insert("GroundHeatExchanger:System", 10),
    insert("InternalMass", 4),
    insert("Roof", 4),
    insert("RoofCeiling:Detailed", 4),
    insert("Wall:Adiabatic", 4),
    insert("Wall:Detailed", 4),
    insert("Wall:Exterior", 4),
    insert("Wall:Interzone", 4),
    insert("Wall:Underground", 4),
    words("Controller:MechanicalVentilation", 4, "system_outdoor_air_method", ventilation_9_6),
    words("Sizing:System", 27, "system_outdoor_air_method", ventilation_9_6),
    fill("AirflowNetwork:MultiZone:ReferenceCrackConditions", 2, "reference_temperature", "20"),
    rename("AirConditioner:VariableRefrigerantFlow", "minimum_outdoor_temperature_in_cooling_mode",
           "minimum_condenser_inlet_node_temperature_in_cooling_mode"),
    rename("AirConditioner:VariableRefrigerantFlow", "maximum_outdoor_temperature_in_cooling_mode",
           "maximum_condenser_inlet_node_temperature_in_cooling_mode"),
    rename("AirConditioner:VariableRefrigerantFlow", "minimum_outdoor_temperature_in_heating_mode",
           "minimum_condenser_inlet_node_temperature_in_heating_mode"),
    rename("AirConditioner:VariableRefrigerantFlow", "maximum_outdoor_temperature_in_heating_mode",
           "maximum_condenser_inlet_node_temperature_in_heating_mode"),
    rename("AirConditioner:VariableRefrigerantFlow", "minimum_outdoor_temperature_in_heat_recovery_mode",
           "minimum_condenser_inlet_node_temperature_in_heat_recovery_mode"),
    rename("AirConditioner:VariableRefrigerantFlow", "maximum_outdoor_temperature_in_heat_recovery_mode",
           "maximum_condenser_inlet_node_temperature_in_heat_recovery_mode"),
    rename("Construction:ComplexFenestrationState", "layer_3_material", "layer_3_name"),
    rename("Daylighting:Controls", "zone_name", "zone_or_space_name"),
    rename("Daylighting:ReferencePoint", "zone_name", "zone_or_space_name"),
    rename("ElectricEquipment", "zone_or_zonelist_name", "zone_or_zonelist_or_space_or_spacelist_name"),
    rename("ElectricEquipment:ITE:AirCooled", "zone_name", "zone_or_space_name"),
    rename("GasEquipment", "zone_or_zonelist_name", "zone_or_zonelist_or_space_or_spacelist_name"),
    rename("HotWaterEquipment", "zone_or_zonelist_name", "zone_or_zonelist_or_space_or_spacelist_name"),
    rename("Lights", "zone_or_zonelist_name", "zone_or_zonelist_or_space_or_spacelist_name"),
    rename("OtherEquipment", "zone_or_zonelist_name", "zone_or_zonelist_or_space_or_spacelist_name"),
    rename("People", "zone_or_zonelist_name", "zone_or_zonelist_or_space_or_spacelist_name"),
    rename("People", "people_per_zone_floor_area", "people_per_floor_area"),
    rename("People", "zone_floor_area_per_person", "floor_area_per_person"),
    rename("SteamEquipment", "zone_or_zonelist_name", "zone_or_zonelist_or_space_or_spacelist_name"),
    rename("ZoneBaseboard:OutdoorTemperatureControlled", "zone_name", "zone_or_zonelist_or_space_or_spacelist_name"),
    rename("ZoneProperty:UserViewFactors:BySurfaceName", "zone_or_zonelist_name",
           "zone_or_zonelist_or_space_or_spacelist_name"),
    rename("Daylighting:Controls", "fraction_of_zone_controlled_by_reference_point",
           "fraction_of_lights_controlled_by_reference_point"),
};

}  // namespace

Step step_to_9_6() { return {"9.5", "9.6", changes_9_6}; }

}  // namespace airside::tools::upgrade
