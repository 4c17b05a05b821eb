#include "sim/energyplus/differing/other_objects.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "sim/energyplus/differing/other_numbers.hpp"

namespace airside::sim {

namespace {

using Json = nlohmann::json;

bool newly_made(const Json& nominal, const std::string& type, const std::string& name) {
  return !nominal.contains(type) || !nominal[type].contains(name);
}

/// What the built object's number is over the nominal one's; 1 where either is missing.
double ratio_of(const Json& nominal, const std::string& type, const std::string& name, const char* field,
                const Json& object) {
  if (newly_made(nominal, type, name)) return 1;
  const Json& before = nominal[type][name];
  if (!before.contains(field) || !before[field].is_number() || !object.contains(field) || !object[field].is_number())
    return 1;
  const double x = before[field].get<double>();
  return x != 0 ? object[field].get<double>() / x : 1;
}

/// Flow through a leak, with its wind part alone if `wind`: Q = area/1000 sqrt(Cs dT + Cw V^2).  m3/s, cm2.
Json leakage_area(const std::string& zone, double area_cm2, double stack, double wind) {
  return {{"zone_or_space_name", zone},
          {"schedule_name", "Always On"},
          {"effective_air_leakage_area", area_cm2},
          {"stack_coefficient", stack},
          {"wind_coefficient", wind}};
}

/// Of the twin's zones.  m3.
double volume_of(const std::string& zone) { return zone.starts_with("Interior") ? 180 : 90; }

void other_leaks(Json& model, const Json& nominal, Lots& lots) {
  const char* type = "ZoneInfiltration:DesignFlowRate";
  const double stack = 0.000145 * lots.uniform(0.7, 1.4), wind = 0.000174 * lots.uniform(0.7, 1.4);
  const double typical = std::sqrt(stack * 4 + wind * 9);  // at 4 K and 3 m/s
  if (!model.contains(type)) return;
  const Json objects = model[type];
  for (const auto& [name, object] : objects.items()) {
    const std::string zone = object.value("zone_or_zonelist_or_space_or_spacelist_name", std::string());
    const double ach = object.value("air_changes_per_hour", 0.0), volume = volume_of(zone);
    const double before = newly_made(nominal, type, name) ? 0 : nominal[type][name].value("air_changes_per_hour", 0.0);
    const bool windy = object.value("velocity_term_coefficient", 0.0) != 0;
    Json& areas = model["ZoneInfiltration:EffectiveLeakageArea"];
    if (windy && ach > 0) {
      constexpr double coefficient = 0.0002;
      const double flow = ach * volume / 3600 * object.value("velocity_term_coefficient", 0.0);
      areas[name] = leakage_area(zone, 1000 * flow / std::sqrt(coefficient), 1e-12, coefficient);
      model[type].erase(name);
      continue;
    }
    const bool facade = zone.starts_with("Perimeter");
    if (before > 0 && facade) {
      const double kept = std::min(before, ach);
      areas[name] = leakage_area(zone, std::max(0.01, 1000 * kept * volume / 3600 / typical), stack, wind);
      model[type].erase(name);
    } else if (before > 0) {
      model[type][name]["air_changes_per_hour"] = std::min(before, ach);
    }
    if (ach <= before) continue;
    Json more = {{"ventilation_type", "Natural"}, {"air_changes_per_hour", ach - before}};
    for (const char* field :
         {"zone_or_zonelist_or_space_or_spacelist_name", "schedule_name", "design_flow_rate_calculation_method",
          "constant_term_coefficient", "temperature_term_coefficient"}) {
      if (object.contains(field)) more[field] = object[field];
    }
    model["ZoneVentilation:DesignFlowRate"][name + " Opening"] = more;
    if (before == 0) model[type].erase(name);
  }
}

/// Both ways of a pair become one object, which mixes both ways.
void other_mixing(Json& model) {
  if (!model.contains("ZoneMixing")) return;
  std::map<std::pair<std::string, std::string>, double> flow;
  for (const auto& [name, object] : model["ZoneMixing"].items()) {
    const std::string a = object.value("zone_or_space_name", std::string());
    const std::string b = object.value("source_zone_or_space_name", std::string());
    flow[std::minmax(a, b)] += object.value("design_flow_rate", 0.0) / 2;
  }
  model.erase("ZoneMixing");
  for (const auto& [zones, m3_s] : flow) {
    model["ZoneCrossMixing"][zones.first + " With " + zones.second] = {
        {"zone_or_space_name", zones.first}, {"source_zone_or_space_name", zones.second},
        {"schedule_name", "Always On"},      {"design_flow_rate_calculation_method", "Flow/Zone"},
        {"design_flow_rate", m3_s},          {"delta_temperature", 0.0}};
  }
}

/// Heat that was added comes from the other kind of equipment, with another share of radiation.
void other_equipment(Json& model, const Json& nominal, Lots& lots) {
  const char *other = "OtherEquipment", *electric = "ElectricEquipment";
  const Json others = model.value(other, Json::object()), electrics = model.value(electric, Json::object());
  const double radiant = lots.uniform(0.2, 0.5);
  const auto move = [&](const char* from, const char* to, const std::string& name, Json object, const char* read,
                        const char* write) {
    const double watts = object.value(read, object.value("design_level", -1.0));
    if (!newly_made(nominal, from, name) || watts < 0) return;
    if (object.contains(read)) {
      object[write] = watts;
      object.erase(read);
    }
    object.erase("fuel_type");
    if (object.contains("fraction_radiant")) object["fraction_radiant"] = radiant;
    model[to][name + " Instead"] = object;
    model[from].erase(name);
  };
  for (const auto& [name, object] : others.items())
    move(other, electric, name, object, "power_per_floor_area", "watts_per_floor_area");
  for (const auto& [name, object] : electrics.items())
    move(electric, other, name, object, "watts_per_floor_area", "power_per_floor_area");
}

void other_building(Json& model, const Json& nominal, Lots& lots) {
  if (model.contains("Material") && model["Material"].contains("Insulation")) {
    Json& insulation = model["Material"]["Insulation"];
    const double conductivity = ratio_of(nominal, "Material", "Insulation", "conductivity", insulation);
    scale_field(insulation, "conductivity", 1 / conductivity);
    scale_field(insulation, "thickness", 1 / conductivity);
  }
  double furniture = 1;
  each_object(model, "InternalMass", [&](const std::string& name, Json& o) {
    const double more = ratio_of(nominal, "InternalMass", name, "surface_area", o);
    scale_field(o, "surface_area", 1 / more);
    furniture = more;
  });
  if (model.contains("Material") && model["Material"].contains("Furniture"))
    scale_field(model["Material"]["Furniture"], "density", furniture);
  each_object(model, "Chiller:Electric:EIR", [&](const std::string& name, Json& o) {
    const double cop = ratio_of(nominal, "Chiller:Electric:EIR", name, "reference_cop", o);
    scale_field(o, "reference_cop", 1 / cop);
    const std::string curve =
        o.value("electric_input_to_cooling_output_ratio_function_of_temperature_curve_name", std::string());
    for (auto& [field, value] : model["Curve:Biquadratic"][curve].items()) {
      if (field.starts_with("coefficient")) value = value.template get<double>() / cop;
    }
  });
  each_object(model, "Fan:VariableVolume", [&](const std::string& name, Json& o) {
    const double pressure = ratio_of(nominal, "Fan:VariableVolume", name, "pressure_rise", o);
    if (pressure <= 1) return;
    scale_field(o, "pressure_rise", 1 / pressure);
    scale_field(o, "fan_total_efficiency", 1 / pressure);
  });
  each_object(model, "FenestrationSurface:Detailed", [&](const std::string& name, Json&) {
    model["Shading:Overhang:Projection"][name + " Eaves"] = {
        {"window_or_door_name", name},
        {"height_above_window_or_door", 0.2},
        {"tilt_angle_from_window_door", 90},
        {"left_extension_from_window_door_width", 0.2},
        {"right_extension_from_window_door_width", 0.2},
        {"depth_as_fraction_of_window_door_height", lots.uniform(0.1, 0.25)}};
  });
}

/// Boxes open less or more instead of being smaller or larger.
void other_boxes(Json& model, const Json& nominal, const ModelNames& names, RoomLoopOptions& loops) {
  const char* type = "AirTerminal:SingleDuct:VAV:NoReheat";
  for (std::size_t i = 0; i < names.interior_zones.size(); ++i) {
    const std::string name = names.interior_zones[i] + " VAV";
    if (!model.contains(type) || !model[type].contains(name)) continue;
    const double more = ratio_of(nominal, type, name, "maximum_air_flow_rate", model[type][name]);
    if (loops.dampers[i] * more > 1) continue;
    scale_field(model[type][name], "maximum_air_flow_rate", 1 / more);
    loops.dampers[i] *= more;
  }
}

std::string placed_name(std::string pattern, std::size_t place) {
  const auto mark = pattern.find('#');
  if (mark != std::string::npos) pattern.replace(mark, 1, std::to_string(place + 1));
  return pattern;
}

/// Dampers that open with the room's temperature, as a program of the engine: the plant's own loops only know fixed
/// ones, and it runs after them.
void modulate(Json& model, const ModelNames& names, const RoomLoopOptions& loops, double per_k) {
  const std::string ems = "EnergyManagementSystem:";
  Json lines = Json::array();
  const auto say = [&lines](const std::string& line) { lines.push_back({{"program_line", line}}); };
  for (std::size_t i = 0; i < names.interior_zones.size(); ++i) {
    const std::string temp = fmt::format("Built_Temp_{}", i + 1), damper = fmt::format("Built_Damper_{}", i + 1);
    const std::string schedule = placed_name(names.vav_damper_schedule, i);
    if (!model["Schedule:Constant"].contains(schedule)) continue;
    model[ems + "Sensor"][temp] = {{"output_variable_or_output_meter_index_key_name", names.interior_zones[i]},
                                   {"output_variable_or_output_meter_name", "Zone Mean Air Temperature"}};
    model[ems + "Actuator"][damper] = {{"actuated_component_unique_name", schedule},
                                       {"actuated_component_type", "Schedule:Constant"},
                                       {"actuated_component_control_type", "Schedule Value"}};
    const double usual = loops.dampers[i];
    say(fmt::format("SET Built_X = {:.6f} + {:.6f} * ({} - 25.25)", usual, per_k, temp));
    say(fmt::format("SET Built_X = @Max Built_X {:.6f}", 0.1 * usual));
    say(fmt::format("SET {} = @Min Built_X 1.0", damper));
  }
  model[ems + "Program"]["Built_Dampers"] = {{"lines", std::move(lines)}};
  model[ems + "ProgramCallingManager"]["Built Dampers"] = {
      {"energyplus_model_calling_point", "BeginZoneTimestepBeforeInitHeatBalance"},
      {"programs", Json::array({Json{{"program_name", "Built_Dampers"}}})}};
}

}  // namespace

Json other_objects(Json model, const Json& nominal, const ModelNames& names, RoomLoopOptions& loops,
                   const OtherObjects& how) {
  Lots lots(how.seed ^ 0x0B7EC75, draw_built);
  other_leaks(model, nominal, lots);
  other_mixing(model);
  other_equipment(model, nominal, lots);
  other_building(model, nominal, lots);
  other_boxes(model, nominal, names, loops);
  if (how.modulation_per_k > 0) modulate(model, names, loops, how.modulation_per_k);
  return model;
}

}  // namespace airside::sim
