// What EnergyPlus 24.1 changed in the input of 23.2.

#include "tools/adopt/upgrade/steps/steps.hpp"
#include "tools/adopt/upgrade/steps/wholes.hpp"

namespace airside::tools::upgrade {

namespace {

constexpr Word radiant_24_1[] = {{"ZoneAveraged", "EnclosureAveraged"}};

// A unit without the field ran its fan at low speed without load only where a coil has variable speed.
constexpr const char* low_speed_24_1 = "no_load_supply_air_flow_rate_control_set_to_low_speed";
constexpr Word speeds_24_1[] = {{"Coil:Heating:DX:VariableSpeed", "Yes"}, {"Coil:Cooling:DX:VariableSpeed", "Yes"}};

constexpr Change changes_24_1[] = {
    insert_by("AirLoopHVAC:UnitarySystem", 39, low_speed_24_1, "No", speeds_24_1),
    insert_by("ZoneHVAC:PackagedTerminalAirConditioner", 10, low_speed_24_1, "No", speeds_24_1),
    insert_by("ZoneHVAC:PackagedTerminalHeatPump", 10, low_speed_24_1, "No", speeds_24_1),
    remove("ComfortViewFactorAngles", 2, "zone_name"),
    insert("ZoneHVAC:WaterToAirHeatPump", 10, 1, low_speed_24_1, "No"),
    words("People", 13, "mean_radiant_temperature_calculation_type", radiant_24_1),
    rename("ElectricEquipment", "watts_per_zone_floor_area", "watts_per_floor_area"),
    rename("ElectricEquipment:ITE:AirCooled", "watts_per_zone_floor_area", "watts_per_floor_area"),
    rename("GasEquipment", "power_per_zone_floor_area", "power_per_floor_area"),
    rename("HotWaterEquipment", "power_per_zone_floor_area", "power_per_floor_area"),
    rename("Lights", "watts_per_zone_floor_area", "watts_per_floor_area"),
    rename("OtherEquipment", "power_per_zone_floor_area", "power_per_floor_area"),
    rename("SteamEquipment", "power_per_zone_floor_area", "power_per_floor_area"),
};

constexpr const char* whole_types_24_1[] = {"HeatExchanger:AirToAir:SensibleAndLatent"};

}  // namespace

Step step_to_24_1() { return {"23.2", "24.1", changes_24_1, heat_recovery_tables, whole_types_24_1}; }

}  // namespace airside::tools::upgrade
