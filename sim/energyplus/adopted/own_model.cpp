#include "sim/energyplus/adopted/own_model.hpp"

#include <algorithm>
#include <set>

#include "hal/text/toml_section.hpp"

namespace airside::sim {
namespace {

constexpr std::size_t most_near_names = 5;
constexpr const char* own_names_remedy = "correct [twin.names] in the site file; names are compared without case";

/// "'Core ZN'; near it: 'Core_ZN'"
std::string lacking(const std::string& name, const std::vector<std::string>& known) {
  std::string text = "no '" + name + "'";
  const std::vector<std::string> near = hal::near_names(name, known, most_near_names);
  for (std::size_t i = 0; i < near.size(); ++i) text += (i == 0 ? "; near it: '" : ", '") + near[i] + "'";
  return text;
}

class Complaints {
 public:
  Complaints(const ModelIndex& index, const std::string& place) : index_(index), place_(place) {}

  void need(const char* type, const std::string& name, const std::string& key, const char* what) {
    if (name.empty() || index_.find(type, name).fields != nullptr) return;
    add(key, lacking(name, index_.names_of(type)), what);
  }
  void need_node(const std::string& name, const std::string& key) {
    if (name.empty() || index_.text(name)) return;
    add(key, lacking(name, index_.nodes()), "a node of the air loop, whose temperature is read");
  }
  void add(const std::string& key, std::string found, std::string expected) {
    list.emplace_back(place_ + ": " + key, std::move(found), std::move(expected), own_names_remedy);
  }

  std::vector<hal::InputError> list;

 private:
  const ModelIndex& index_;
  const std::string& place_;
};

void need_schedule(Complaints& out, const ModelIndex& index, const std::string& name) {
  const char* key = "supply_setpoint_schedule";
  const char* what = "a Schedule:Constant that holds the supply-air setpoint";
  if (index.find("Schedule:Constant", name).fields != nullptr) return;
  const ModelObject other = index.find("Schedule:", name);
  if (other.fields != nullptr) {
    out.add(key, "'" + name + "' as a " + other.type, what);
    return;
  }
  out.add(key, lacking(name, index.names_of("Schedule:Constant")), what);
}

/// The fan in a unit that stands in the zone, such as a fan coil; "" where it has none.
std::string fan_of_zone_unit(const ModelIndex& index, const std::string& zone) {
  for (const ModelObject& connections : index.of_type("ZoneHVAC:EquipmentConnections")) {
    const std::string of = connections.text("zone_name");
    if (engine_case(of.empty() ? connections.name : of) != engine_case(zone)) continue;
    const ModelObject list =
        index.find("ZoneHVAC:EquipmentList", connections.text("zone_conditioning_equipment_list_name"));
    if (list.fields == nullptr || !list.fields->contains("equipment")) continue;
    for (const auto& entry : list.fields->at("equipment")) {
      const ModelObject member{"", "", &entry};
      const ModelObject unit =
          index.find(member.text("zone_equipment_object_type"), member.text("zone_equipment_name"));
      for (const char* field : {"supply_air_fan_name", "fan_name"}) {
        if (!unit.text(field).empty()) return unit.text(field);
      }
    }
  }
  return {};
}

/// Schedules of the people in a zone.
std::set<std::string> people_of_zone(const ModelIndex& index, const std::string& zone) {
  std::set<std::string> schedules;
  for (const ModelObject& people : index.of_type("People")) {
    const std::string where = people.text("zone_or_zonelist_or_space_or_spacelist_name");
    const std::string schedule = people.text("number_of_people_schedule_name");
    if (!schedule.empty() && index.zones_behind(where).contains(engine_case(zone))) schedules.insert(schedule);
  }
  return schedules;
}

}  // namespace

std::vector<hal::InputError> missing_own_names(const nlohmann::json& model, const OwnNames& names,
                                               const std::string& place) {
  const ModelIndex index(model);
  Complaints out(index, place);
  need_schedule(out, index, names.supply_setpoint_schedule);
  out.need_node(names.supply_air_node, "supply_air_node");
  out.need_node(names.mau_outlet_node, "mau_outlet_node");
  const auto need_zone = [&](const std::string& zone, const char* key) {
    out.need("Zone", zone, key, "a Zone of the model");
    return index.object("Zone", zone);
  };
  for (const std::string& zone : names.zones) need_zone(zone, "zones");
  for (const std::string& terminal : names.terminals)
    out.need("AirTerminal:", terminal, "terminals", "an air terminal, whose damper is read");
  for (const std::string& zone : names.fcu_zones) {
    if (need_zone(zone, "fcu_zones") && fan_of_zone_unit(index, zone).empty())
      out.add("fcu_zones", "no unit with a fan in the zone '" + zone + "'", "a zone with a fan coil or its like");
  }
  out.need("Fan:", names.supply_fan, "supply_fan", "a fan, whose electricity says whether the AHU runs");
  for (const std::string& zone : names.occupancy) {
    if (need_zone(zone, "occupancy") && people_of_zone(index, zone).empty())
      out.add("occupancy", "no People with a schedule in the zone '" + zone + "'", "zones with people");
  }
  return std::move(out.list);
}

OwnParts own_parts(const nlohmann::json& model, const OwnNames& names) {
  const ModelIndex index(model);
  OwnParts parts;
  for (const std::string& zone : names.fcu_zones) parts.fcu_fans.push_back(fan_of_zone_unit(index, zone));
  std::set<std::string> schedules;
  for (const std::string& zone : names.occupancy) schedules.merge(people_of_zone(index, zone));
  parts.people_schedules.assign(schedules.begin(), schedules.end());
  return parts;
}

ModelObject find_command_schedule(const nlohmann::json& model, const std::string& name) {
  const ModelIndex index(model);
  for (const char* type : command_schedule_types) {
    const ModelObject found = index.find(type, name);
    if (found.fields != nullptr) return found;
  }
  return {};
}

void free_command_schedules(nlohmann::json& model, const OwnNames& names) {
  std::vector<std::string> schedules = names.commands;
  if (!names.supply_setpoint_schedule.empty()) schedules.push_back(names.supply_setpoint_schedule);
  for (const std::string& name : schedules) {
    const ModelObject known = find_command_schedule(model, name);
    if (known.fields == nullptr || known.type == "Schedule:Constant") continue;
    nlohmann::json constant = {{"hourly_value", 0}};
    if (const std::string limits = known.text("schedule_type_limits_name"); !limits.empty())
      constant["schedule_type_limits_name"] = limits;
    const std::string type = known.type, spelled = known.name;
    model[type].erase(spelled);
    if (model[type].empty()) model.erase(type);
    model["Schedule:Constant"][spelled] = std::move(constant);
  }
}

void prepare_own_model(nlohmann::json& model, const std::string& place) {
  std::vector<std::string> dropped = {"RunPeriodControl:DaylightSavingTime"};
  for (const auto& [type, objects] : model.items()) {
    if (type.starts_with("HVACTemplate:")) {
      throw hal::InputError(place, "objects of type " + type, "a model whose templates are expanded",
                            "run the engine's ExpandObjects on its IDF, or `airside adopt` on the model");
    }
    if (type.starts_with("Output:") || type == "OutputControl:Table:Style") dropped.push_back(type);
  }
  for (const std::string& type : dropped) model.erase(type);
  nlohmann::json control = nlohmann::json::object();
  if (model.contains("SimulationControl") && !model["SimulationControl"].empty())
    control = model["SimulationControl"].begin().value();
  control["run_simulation_for_sizing_periods"] = "No";
  control["run_simulation_for_weather_file_run_periods"] = "Yes";
  model["SimulationControl"] = {{"Simulation Control", control}};
}

}  // namespace airside::sim
