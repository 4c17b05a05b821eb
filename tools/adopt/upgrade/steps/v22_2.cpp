// What EnergyPlus 22.2 changed in the input of 22.1.

#include "tools/adopt/upgrade/steps/steps.hpp"

namespace airside::tools::upgrade {

namespace {

constexpr Change changes_22_2[] = {
    insert("Coil:Cooling:DX:CurveFit:Speed", 9),
    insert("Coil:Cooling:DX:MultiSpeed", 24),
    insert("Coil:Cooling:DX:MultiSpeed", 44),
    insert("Coil:Cooling:DX:MultiSpeed", 64),
    insert("Coil:Cooling:DX:MultiSpeed", 84),
    insert("Coil:Cooling:DX:SingleSpeed", 8),
    insert("Coil:Cooling:WaterToAirHeatPump:EquationFit", 11, 3),
    insert("Coil:Heating:DX:MultiSpeed", 23),
    insert("Coil:Heating:DX:MultiSpeed", 35),
    insert("Coil:Heating:DX:MultiSpeed", 47),
    insert("Coil:Heating:DX:MultiSpeed", 59),
    insert("Coil:Heating:DX:SingleSpeed", 7),
    insert("Coil:Heating:WaterToAirHeatPump:EquationFit", 10, 3),
    remove("FuelFactors", 2, "units_of_measure"),
    remove("FuelFactors", 2, "energy_per_unit_factor"),
    insert("Space", 3, 2),
    fill("CoolingTower:SingleSpeed", 34, "cell_control", "MinimalCell"),
    fill("CoolingTower:TwoSpeed", 41, "cell_control", "MinimalCell"),
    fill("CoolingTower:VariableSpeed", 27, "cell_control", "MinimalCell"),
    fill("CoolingTower:VariableSpeed:Merkel", 41, "cell_control", "MinimalCell"),
    rename("Coil:Cooling:DX:CurveFit:Speed", "rated_evaporator_fan_power_per_volume_flow_rate",
           "2017_rated_evaporator_fan_power_per_volume_flow_rate"),
    rename("Coil:Cooling:DX:MultiSpeed", "speed_1_rated_evaporator_fan_power_per_volume_flow_rate",
           "2017_speed_1_rated_evaporator_fan_power_per_volume_flow_rate"),
    rename("Coil:Cooling:DX:MultiSpeed", "speed_2_rated_evaporator_fan_power_per_volume_flow_rate",
           "2017_speed_2_rated_evaporator_fan_power_per_volume_flow_rate"),
    rename("Coil:Cooling:DX:MultiSpeed", "speed_3_rated_evaporator_fan_power_per_volume_flow_rate",
           "2017_speed_3_rated_evaporator_fan_power_per_volume_flow_rate"),
    rename("Coil:Cooling:DX:MultiSpeed", "speed_4_rated_evaporator_fan_power_per_volume_flow_rate",
           "2017_speed_4_rated_evaporator_fan_power_per_volume_flow_rate"),
    rename("Coil:Cooling:DX:SingleSpeed", "rated_evaporator_fan_power_per_volume_flow_rate",
           "2017_rated_evaporator_fan_power_per_volume_flow_rate"),
    rename("Coil:Heating:DX:MultiSpeed", "speed_1_rated_supply_air_fan_power_per_volume_flow_rate",
           "2017_speed_1_rated_supply_air_fan_power_per_volume_flow_rate"),
    rename("Coil:Heating:DX:MultiSpeed", "speed_2_rated_supply_air_fan_power_per_volume_flow_rate",
           "2017_speed_2_rated_supply_air_fan_power_per_volume_flow_rate"),
    rename("Coil:Heating:DX:MultiSpeed", "speed_3_rated_supply_air_fan_power_per_volume_flow_rate",
           "2017_speed_3_rated_supply_air_fan_power_per_volume_flow_rate"),
    rename("Coil:Heating:DX:MultiSpeed", "speed_4_rated_supply_air_fan_power_per_volume_flow_rate",
           "2017_speed_4_rated_supply_air_fan_power_per_volume_flow_rate"),
    rename("Coil:Heating:DX:SingleSpeed", "rated_supply_fan_power_per_volume_flow_rate",
           "2017_rated_supply_fan_power_per_volume_flow_rate"),
    rename("ZoneCrossMixing", "zone_name", "zone_or_space_name"),
    rename("ZoneCrossMixing", "flow_rate_per_zone_floor_area", "flow_rate_per_floor_area"),
    rename("ZoneCrossMixing", "source_zone_name", "source_zone_or_space_name"),
    rename("ZoneCrossMixing", "minimum_zone_temperature_schedule_name", "minimum_receiving_temperature_schedule_name"),
    rename("ZoneCrossMixing", "maximum_zone_temperature_schedule_name", "maximum_receiving_temperature_schedule_name"),
    rename("ZoneCrossMixing", "minimum_source_zone_temperature_schedule_name",
           "minimum_source_temperature_schedule_name"),
    rename("ZoneCrossMixing", "maximum_source_zone_temperature_schedule_name",
           "maximum_source_temperature_schedule_name"),
    rename("ZoneInfiltration:DesignFlowRate", "zone_or_zonelist_name", "zone_or_zonelist_or_space_or_spacelist_name"),
    rename("ZoneInfiltration:DesignFlowRate", "flow_per_zone_floor_area", "flow_rate_per_floor_area"),
    rename("ZoneInfiltration:DesignFlowRate", "flow_per_exterior_surface_area", "flow_rate_per_exterior_surface_area"),
    rename("ZoneInfiltration:EffectiveLeakageArea", "zone_name", "zone_or_space_name"),
    rename("ZoneInfiltration:FlowCoefficient", "zone_name", "zone_or_space_name"),
    rename("ZoneMixing", "zone_name", "zone_or_space_name"),
    rename("ZoneMixing", "flow_rate_per_zone_floor_area", "flow_rate_per_floor_area"),
    rename("ZoneMixing", "source_zone_name", "source_zone_or_space_name"),
    rename("ZoneMixing", "minimum_zone_temperature_schedule_name", "minimum_receiving_temperature_schedule_name"),
    rename("ZoneMixing", "maximum_zone_temperature_schedule_name", "maximum_receiving_temperature_schedule_name"),
    rename("ZoneMixing", "minimum_source_zone_temperature_schedule_name", "minimum_source_temperature_schedule_name"),
    rename("ZoneMixing", "maximum_source_zone_temperature_schedule_name", "maximum_source_temperature_schedule_name"),
    rename("ZoneVentilation:DesignFlowRate", "zone_or_zonelist_name", "zone_or_zonelist_or_space_or_spacelist_name"),
    rename("ZoneVentilation:DesignFlowRate", "flow_rate_per_zone_floor_area", "flow_rate_per_floor_area"),
    rename("ZoneVentilation:WindandStackOpenArea", "zone_name", "zone_or_space_name"),
};

}  // namespace

Step step_to_22_2() { return {"22.1", "22.2", changes_22_2}; }

}  // namespace airside::tools::upgrade
