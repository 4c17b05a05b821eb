// What EnergyPlus 9.5 changed in the input of 9.4.

#include "tools/adopt/upgrade/steps/steps.hpp"

namespace airside::tools::upgrade {

namespace {

constexpr Word mixing_9_5[] = {{"Yes", "AdjustMixingOnly"}, {"No", "None"}};
constexpr Word demands_9_5[] = {{"Power", "Demand"}};
constexpr Word window_9_5[] = {{"InteriorWindow", ""}};
constexpr Word surface_9_5[] = {{"IRTSurface", ""}};

constexpr Change changes_9_5[] = {
    refuse_if("Construction:AirBoundary", 2, "solar_and_daylighting_method", window_9_5,
              "air boundaries always group their zones now"),
    refuse_if("Construction:AirBoundary", 3, "radiant_exchange_method", surface_9_5,
              "air boundaries always group their zones now"),
    remove("Construction:AirBoundary", 2, "solar_and_daylighting_method"),
    remove("Construction:AirBoundary", 2, "radiant_exchange_method"),
    words("ZoneAirMassFlowConservation", 1, "adjust_zone_mixing_and_return_for_air_mass_flow_balance", mixing_9_5),
    words("UtilityCost:Variable", 3, "variable_type", demands_9_5),
    refuse("Construction:InternalSource", "it is a construction and a ConstructionProperty:InternalHeatSource now"),
    refuse("Coil:Cooling:WaterToAirHeatPump:EquationFit", "its coefficients are curves of their own now"),
    refuse("Coil:Heating:WaterToAirHeatPump:EquationFit", "its coefficients are curves of their own now"),
    refuse("HeatPump:WaterToWater:EquationFit:Cooling", "its coefficients are curves of their own now"),
    refuse("HeatPump:WaterToWater:EquationFit:Heating", "its coefficients are curves of their own now"),
    refuse("ZoneHVAC:Baseboard:RadiantConvective:Water", "its design values are an object of their own now"),
    refuse("ZoneHVAC:Baseboard:RadiantConvective:Steam", "its design values are an object of their own now"),
    refuse("ZoneHVAC:LowTemperatureRadiant:VariableFlow", "its design values are an object of their own now"),
    refuse("ZoneHVAC:LowTemperatureRadiant:ConstantFlow", "its design values are an object of their own now"),
    rename("ZoneAirMassFlowConservation", "adjust_zone_mixing_for_zone_air_mass_flow_balance",
           "adjust_zone_mixing_and_return_for_air_mass_flow_balance"),
};

}  // namespace

Step step_to_9_5() { return {"9.4", "9.5", changes_9_5}; }

}  // namespace airside::tools::upgrade
