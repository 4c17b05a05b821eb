#include "sim/energyplus/differing/other_numbers.hpp"

#include <algorithm>

namespace airside::sim {

void scale_field(nlohmann::json& object, const char* field, double factor) {
  if (object.contains(field) && object[field].is_number()) object[field] = object[field].get<double>() * factor;
}

void perturb_numbers(nlohmann::json& model, std::uint64_t seed) {
  Lots lots(seed, draw_built);
  const double glass_u = lots.factor(0.2), insulation = lots.factor(0.2), capacity = lots.factor(0.2);
  const double furniture = lots.factor(0.2), all_gain = lots.factor(0.12), all_flow = lots.factor(0.1);
  const double leak = lots.factor(0.2), all_sun = lots.factor(0.15), all_mixing = lots.factor(0.2);
  each_object(model, "WindowMaterial:SimpleGlazingSystem", [&](const auto&, nlohmann::json& glass) {
    scale_field(glass, "u_factor", glass_u);
    scale_field(glass, "solar_heat_gain_coefficient", all_sun * lots.factor(0.08));
  });
  if (model.contains("Material")) scale_field(model["Material"]["Insulation"], "thickness", insulation);
  each_object(model, "ZoneCapacitanceMultiplier:ResearchSpecial",
              [&](const auto&, nlohmann::json& o) { scale_field(o, "temperature_capacity_multiplier", capacity); });
  each_object(model, "InternalMass",
              [&](const auto&, nlohmann::json& o) { scale_field(o, "surface_area", furniture * lots.factor(0.1)); });
  for (const char* type : {"ElectricEquipment", "Lights"}) {
    each_object(model, type, [&](const auto&, nlohmann::json& o) {
      scale_field(o, "watts_per_floor_area", all_gain * lots.factor(0.08));
      o["fraction_radiant"] = lots.uniform(0.15, 0.45);
    });
  }
  each_object(model, "AirTerminal:SingleDuct:VAV:NoReheat", [&](const auto&, nlohmann::json& o) {
    scale_field(o, "maximum_air_flow_rate", all_flow * lots.factor(0.08));
  });
  each_object(model, "ZoneHVAC:FourPipeFanCoil", [&](const auto&, nlohmann::json& o) {
    scale_field(o, "maximum_cold_water_flow_rate", lots.factor(0.15));
  });
  each_object(model, "ZoneInfiltration:DesignFlowRate", [&](const auto&, nlohmann::json& o) {
    scale_field(o, "air_changes_per_hour", leak * lots.factor(0.15));
  });
  each_object(model, "ZoneMixing",
              [&](const auto&, nlohmann::json& o) { scale_field(o, "design_flow_rate", all_mixing); });
  each_object(model, "Chiller:Electric:EIR",
              [&](const auto&, nlohmann::json& o) { scale_field(o, "reference_cop", lots.factor(0.08)); });
  each_object(model, "Fan:VariableVolume",
              [&](const auto&, nlohmann::json& o) { scale_field(o, "pressure_rise", lots.factor(0.08)); });
  if (model.contains("Schedule:Constant") && model["Schedule:Constant"].contains("MAU Setpoint")) {
    nlohmann::json& value = model["Schedule:Constant"]["MAU Setpoint"]["hourly_value"];
    value = value.get<double>() + lots.shift(0.4);
  }
}

WeatherChange perturb_loops(RoomLoopOptions& loops, std::uint64_t seed) {
  Lots lots(seed ^ 0x10095, draw_built);
  for (double& damper : loops.dampers) damper = std::min(1.0, damper * lots.factor(0.06));
  loops.supply_lag_s *= lots.uniform(1.1, 1.8);
  loops.supply_bias_k += lots.shift(0.4);
  loops.occupancy_scale *= lots.factor(0.1);
  loops.occupancy_shift_min += lots.shift(20);
  loops.fcu_setpoint_degc += lots.shift(0.3);
  WeatherChange change;
  change.dry_bulb_offset_k = lots.shift(0.5);
  change.solar_factor = lots.factor(0.06);
  return change;
}

double modulation_of(std::uint64_t seed) { return Lots(seed ^ 0x4D0D, draw_built).uniform(0.02, 0.06); }

}  // namespace airside::sim
