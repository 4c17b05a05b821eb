// What EnergyPlus 24.2 changed in the input of 24.1.

#include "tools/adopt/upgrade/steps/steps.hpp"

namespace airside::tools::upgrade {

namespace {

constexpr Word variable_fans_24_2[] = {{"Fan:VariableVolume", ""}};

constexpr Change changes_24_2[] = {
    insert("HeatPump:PlantLoop:EIR:Cooling", 7, 2),
    insert("HeatPump:PlantLoop:EIR:Cooling", 12),
    insert("HeatPump:PlantLoop:EIR:Heating", 7, 2),
    insert("HeatPump:PlantLoop:EIR:Heating", 12),
    insert("OutputControl:Files", 9),
    refuse_if("ZoneHVAC:TerminalUnit:VariableRefrigerantFlow", 14, "supply_air_fan_object_type", variable_fans_24_2,
              "its fan must be a Fan:SystemModel now"),
    rename("IndoorLivingWall", "led_intensity_schedule_name_", "led_intensity_schedule_name"),
    rename("IndoorLivingWall", "led_nominal_intensity_", "led_nominal_intensity"),
    rename("Output:IlluminanceMap", "zone_name", "zone_or_space_name"),
    rename("ZoneCoolTower:Shower", "zone_name", "zone_or_space_name"),
    rename("ZoneRefrigerationDoorMixing", "zone_1_name", "zone_or_space_name_1"),
    rename("ZoneRefrigerationDoorMixing", "zone_2_name", "zone_or_space_name_2"),
    rename("ZoneThermalChimney", "zone_1_name", "zone_or_space_name_1"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_1",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_1"),
    rename("ZoneThermalChimney", "zone_2_name", "zone_or_space_name_2"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_2",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_2"),
    rename("ZoneThermalChimney", "zone_3_name", "zone_or_space_name_3"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_3",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_3"),
    rename("ZoneThermalChimney", "zone_4_name", "zone_or_space_name_4"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_4",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_4"),
    rename("ZoneThermalChimney", "zone_5_name", "zone_or_space_name_5"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_5",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_5"),
    rename("ZoneThermalChimney", "zone_6_name", "zone_or_space_name_6"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_6",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_6"),
    rename("ZoneThermalChimney", "zone_7_name", "zone_or_space_name_7"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_7",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_7"),
    rename("ZoneThermalChimney", "zone_8_name", "zone_or_space_name_8"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_8",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_8"),
    rename("ZoneThermalChimney", "zone_9_name", "zone_or_space_name_9"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_9",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_9"),
    rename("ZoneThermalChimney", "zone_10_name", "zone_or_space_name_10"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_10",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_10"),
    rename("ZoneThermalChimney", "zone_11_name", "zone_or_space_name_11"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_11",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_11"),
    rename("ZoneThermalChimney", "zone_12_name", "zone_or_space_name_12"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_12",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_12"),
    rename("ZoneThermalChimney", "zone_13_name", "zone_or_space_name_13"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_13",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_13"),
    rename("ZoneThermalChimney", "zone_14_name", "zone_or_space_name_14"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_14",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_14"),
    rename("ZoneThermalChimney", "zone_15_name", "zone_or_space_name_15"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_15",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_15"),
    rename("ZoneThermalChimney", "zone_16_name", "zone_or_space_name_16"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_16",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_16"),
    rename("ZoneThermalChimney", "zone_17_name", "zone_or_space_name_17"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_17",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_17"),
    rename("ZoneThermalChimney", "zone_18_name", "zone_or_space_name_18"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_18",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_18"),
    rename("ZoneThermalChimney", "zone_19_name", "zone_or_space_name_19"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_19",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_19"),
    rename("ZoneThermalChimney", "zone_20_name", "zone_or_space_name_20"),
    rename("ZoneThermalChimney", "relative_ratios_of_air_flow_rates_passing_through_zone_20",
           "relative_ratios_of_air_flow_rates_passing_through_inlet_20"),
};

constexpr const char* whole_types_24_2[] = {"MaterialProperty:PhaseChange",
                                            "MaterialProperty:VariableThermalConductivity"};

}  // namespace

Step step_to_24_2() { return {"24.1", "24.2", changes_24_2, nullptr, whole_types_24_2}; }

}  // namespace airside::tools::upgrade
