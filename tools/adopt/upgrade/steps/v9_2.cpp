// What EnergyPlus 9.2 changed in the input of 9.1.

#include "tools/adopt/upgrade/steps/steps.hpp"
#include "tools/adopt/upgrade/steps/wholes.hpp"

namespace airside::tools::upgrade {

namespace {

constexpr Word columns_9_2[] = {{"Fixed", "Space"}};
constexpr Word discharging_9_2[] = {{"QuadraticLinear", "FractionDischargedLMTD"}, {"CubicLinear", "LMTDMassFlow"}};
constexpr Word charging_9_2[] = {{"QuadraticLinear", "FractionChargedLMTD"}, {"CubicLinear", "LMTDMassFlow"}};

constexpr Change changes_9_2[] = {
    insert("Foundation:Kiva", 2),
    words("Schedule:File", 7, "column_separator", columns_9_2),
    words("ThermalStorage:Ice:Detailed", 6, "discharging_curve_variable_specifications", discharging_9_2),
    words("ThermalStorage:Ice:Detailed", 8, "charging_curve_variable_specifications", charging_9_2),
    refuse("Table:OneIndependentVariable", "tables are Table:Lookup now"),
    refuse("Table:TwoIndependentVariables", "tables are Table:Lookup now"),
    refuse("Table:MultiVariableLookup", "tables are Table:Lookup now"),
    rename("CoolingTower:SingleSpeed", "free_convection_air_flow_rate", "free_convection_regime_air_flow_rate"),
    rename("CoolingTower:SingleSpeed", "free_convection_air_flow_rate_sizing_factor",
           "free_convection_regime_air_flow_rate_sizing_factor"),
    rename("CoolingTower:SingleSpeed", "free_convection_u_factor_times_area_value",
           "free_convection_regime_u_factor_times_area_value"),
    rename("InternalMass", "zone_name", "zone_or_zonelist_name"),
    rename("ThermalStorage:Ice:Detailed", "discharging_curve_object_type", "discharging_curve_variable_specifications"),
    rename("ThermalStorage:Ice:Detailed", "charging_curve_object_type", "charging_curve_variable_specifications"),
    rename("WindowShadingControl", "construction_with_shading_name_", "construction_with_shading_name"),
    rename("ZoneProperty:UserViewFactors:bySurfaceName", "zone_name", "zone_or_zonelist_name"),
    rename("ZoneHVAC:EquipmentList", "zone_equipment_sequential_cooling_fraction",
           "zone_equipment_sequential_cooling_fraction_schedule_name"),
    rename("ZoneHVAC:EquipmentList", "zone_equipment_sequential_heating_fraction",
           "zone_equipment_sequential_heating_fraction_schedule_name"),
};

}  // namespace

Step step_to_9_2() { return {"9.1", "9.2", changes_9_2, fractions_and_names}; }

}  // namespace airside::tools::upgrade
