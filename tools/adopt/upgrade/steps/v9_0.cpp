// What EnergyPlus 9.0 changed in the input of 8.9.

#include "tools/adopt/upgrade/steps/steps.hpp"
#include "tools/adopt/upgrade/steps/wholes.hpp"

namespace airside::tools::upgrade {

namespace {

constexpr Word blinds_9_0[] = {{"Venetian", "VenetianHorizontal"}};
constexpr Word start_days_9_0[] = {{"UseWeatherFile", ""}};

constexpr Change changes_9_0[] = {
    remove("Boiler:HotWater", 7, "design_water_outlet_temperature"),
    remove("FenestrationSurface:Detailed", 7, "shading_control_name"),
    remove("GlazedDoor", 4, "shading_control_name"),
    remove("Window", 4, "shading_control_name"),
    words("RunPeriod:CustomRange", 8, "day_of_week_for_start_day", start_days_9_0),
    retype("RunPeriod:CustomRange", "RunPeriod"),
    words("WindowMaterial:ComplexShade", 2, "layer_type", blinds_9_0),
    refuse("AirflowNetwork:Distribution:Component:OutdoorAirFlow", "it must name its outdoor air mixer"),
    refuse("AirflowNetwork:Distribution:Component:ReliefAirFlow", "it must name its outdoor air mixer"),
};

constexpr const char* whole_types_9_0[] = {"RunPeriod", "RunPeriod:CustomRange", "WindowProperty:ShadingControl",
                                           "Schedule:Year"};

}  // namespace

Step step_to_9_0() { return {"8.9", "9.0", changes_9_0, run_periods_and_shading, whole_types_9_0}; }

}  // namespace airside::tools::upgrade
