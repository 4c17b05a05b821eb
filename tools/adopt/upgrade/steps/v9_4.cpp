// What EnergyPlus 9.4 changed in the input of 9.3.

#include "tools/adopt/upgrade/steps/steps.hpp"
#include "tools/adopt/upgrade/steps/wholes.hpp"

namespace airside::tools::upgrade {

namespace {

constexpr Word flags_9_4[] = {{"1", "Yes"}, {"1.0", "Yes"}, {"0", "No"}, {"0.0", "No"}};
constexpr Word controls_9_4[] = {{"Electric Power Level", "Electricity Rate"}, {"Gas Power Level", "NaturalGas Rate"}};
constexpr Word outputs_9_4[] = {{" Electric Power", " Electricity Rate"}, {" Electric Energy", " Electricity Energy"},
                                {" Gas Rate", " NaturalGas Rate"},        {" Gas Energy", " NaturalGas Energy"},
                                {"Fuel Oil #1", "Fuel Oil No 1"},         {"Fuel Oil #2", "Fuel Oil No 2"}};
constexpr Word meters_9_4[] = {{"Gas:Facility", "NaturalGas:Facility"},
                               {"Gas:Building", "NaturalGas:Building"},
                               {"Gas:HVAC", "NaturalGas:HVAC"},
                               {"Gas:Plant", "NaturalGas:Plant"},
                               {"FuelOil#1:Facility", "FuelOilNo1:Facility"},
                               {"FuelOil#2:Facility", "FuelOilNo2:Facility"}};

constexpr Change changes_9_4[] = {
    insert("Construction:InternalSource", 6),
    insert("ZoneHVAC:HybridUnitaryHVAC", 15, 3),
    remove("ZoneHVAC:HybridUnitaryHVAC", 19, "number_of_operating_modes"),
    insert("ZoneHVAC:LowTemperatureRadiant:Electric", 10),
    words("Output:DebuggingData", 1, "report_debugging_data", flags_9_4),
    words("Output:DebuggingData", 2, "report_during_warmup", flags_9_4),
    words("EnergyManagementSystem:Actuator", 4, "actuated_component_control_type", controls_9_4),
    parts("EnergyManagementSystem:Sensor", 3, "output_variable_or_output_meter_name", outputs_9_4),
    words("EnergyManagementSystem:Sensor", 3, "output_variable_or_output_meter_name", meters_9_4),
    words("UtilityCost:Tariff", 2, "output_meter_name", meters_9_4),
    words("DemandManagerAssignmentList", 2, "meter_name", meters_9_4),
    words("Meter:Custom", 0, "", meters_9_4),
    words("Meter:CustomDecrement", 0, "", meters_9_4),
    parts("Output:Variable", 2, "variable_name", outputs_9_4),
    words("Output:Meter", 1, "key_name", meters_9_4),
    words("Output:Meter:MeterFileOnly", 1, "key_name", meters_9_4),
    rename("Curve:DoubleExponentialDecay", "coefficient3_c4", "coefficient4_c4"),
    rename("Curve:DoubleExponentialDecay", "coefficient3_c5", "coefficient5_c5"),
    rename("Meter:Custom", "fuel_type", "resource_type"),
    rename("Meter:CustomDecrement", "fuel_type", "resource_type"),
};

constexpr const char* whole_types_9_4[] = {"Output:Diagnostics", "PythonPlugin:SearchPaths", "PythonPlugin:Variables"};

}  // namespace

Step step_to_9_4() { return {"9.3", "9.4", changes_9_4, one_diagnostics, whole_types_9_4}; }

}  // namespace airside::tools::upgrade
