#include "tools/adopt/loop/zone_side.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "hal/text/input_error.hpp"

namespace airside::tools {

namespace {

/// What the adoption knows of a type of terminal.
struct TerminalRule {
  const char* type;
  TerminalKind kind;
  bool damper;
};
constexpr TerminalRule terminal_rules[] = {
    {"AirTerminal:SingleDuct:ConstantVolume:NoReheat", TerminalKind::fixed, false},
    {"AirTerminal:SingleDuct:Uncontrolled", TerminalKind::fixed, false},
    {"AirTerminal:SingleDuct:ConstantVolume:Reheat", TerminalKind::reheat, false},
    {"AirTerminal:SingleDuct:ConstantVolume:FourPipeInduction", TerminalKind::reheat, false},
    {"AirTerminal:SingleDuct:ConstantVolume:FourPipeBeam", TerminalKind::reheat, false},
    {"AirTerminal:SingleDuct:ConstantVolume:CooledBeam", TerminalKind::fixed, false},
    {"AirTerminal:SingleDuct:Mixer", TerminalKind::fixed, false},
    {"AirTerminal:SingleDuct:VAV:NoReheat", TerminalKind::modulating, true},
    {"AirTerminal:SingleDuct:VAV:HeatAndCool:NoReheat", TerminalKind::modulating, true},
    {"AirTerminal:SingleDuct:VAV:Reheat", TerminalKind::reheat, true},
    {"AirTerminal:SingleDuct:VAV:HeatAndCool:Reheat", TerminalKind::reheat, true},
    {"AirTerminal:SingleDuct:VAV:Reheat:VariableSpeedFan", TerminalKind::reheat, false},
    {"AirTerminal:SingleDuct:ParallelPIU:Reheat", TerminalKind::reheat, false},
    {"AirTerminal:SingleDuct:SeriesPIU:Reheat", TerminalKind::reheat, false},
};

struct Splitter {
  ModelObject object;
  std::string inlet;
  std::vector<std::string> outlets;
};

/// Splitters and supply plenums of the path that begins at the loop's demand inlet.
std::vector<Splitter> splitters_of(const ModelView& model, const ModelObject& object, AirLoop& loop) {
  ModelObject path;
  for (const ModelObject& p : model.all("AirLoopHVAC:SupplyPath")) {
    if (same_name(p.text("supply_air_path_inlet_node_name"), loop.demand_inlet)) path = p;
  }
  if (!path) {
    throw hal::InputError(model.place_of(object, "demand_side_inlet_node_names"),
                          "the node \"" + loop.demand_inlet + "\", at which no AirLoopHVAC:SupplyPath begins",
                          "the inlet of a supply path", "add the path, or correct the node");
  }
  std::vector<Splitter> out;
  const auto types = path.texts("components", "component_object_type");
  const auto names = path.texts("components", "component_name");
  for (std::size_t i = 0; i < types.size() && i < names.size(); ++i) {
    const ModelObject part = model.need(types[i], path, "components", names[i]);
    out.push_back({part, part.text("inlet_node_name"), part.texts("nodes", "outlet_node_name")});
    if (part.type == "AirLoopHVAC:SupplyPlenum")
      loop.notes.push_back("supply plenum \"" + part.text("zone_name") + "\": a zone of its own, no room");
  }
  if (out.empty()) {
    throw hal::InputError(model.place_of(path, "components"), "no zone splitter", "the splitter of the loop",
                          "name it there");
  }
  return out;
}

/// The nodes at which the supply path ends: the terminals' inlets, in the path's order.
std::vector<std::string> ends_of_path(const ModelView& model, const std::vector<Splitter>& splitters,
                                      const std::string& inlet) {
  std::vector<std::string> ends, open = {inlet};
  std::set<std::string> passed;
  while (!open.empty()) {
    const std::string node = open.back();
    open.pop_back();
    const auto next =
        std::find_if(splitters.begin(), splitters.end(), [&](const Splitter& s) { return same_name(s.inlet, node); });
    if (next == splitters.end()) {
      ends.push_back(node);
      continue;
    }
    if (!passed.insert(engine_upper(node)).second) {
      throw hal::InputError(model.place_of(next->object), "a way from the node \"" + node + "\" back to itself",
                            "a supply path that ends at terminals", "correct its inlet and outlet nodes");
    }
    for (auto outlet = next->outlets.rbegin(); outlet != next->outlets.rend(); ++outlet) open.push_back(*outlet);
  }
  if (ends.size() == 1 && same_name(ends.front(), inlet)) {
    throw hal::InputError(model.place_of(splitters.front().object, "inlet_node_name"),
                          "the node \"" + splitters.front().inlet + "\"",
                          "the inlet of the supply path, \"" + inlet + "\"", "correct the node");
  }
  return ends;
}

/// The terminal that takes its air from `node`.
ModelObject terminal_at(const ModelView& model, const std::string& node) {
  for (const ModelObject& terminal : model.all_of("AirTerminal:")) {
    for (const auto& [field, value] : terminal.fields->items()) {
      if (field.find("inlet_node") == std::string::npos || !value.is_string()) continue;
      if (same_name(value.get<std::string>(), node)) return terminal;
    }
  }
  return {};
}

/// The zone whose equipment list has this object.
std::string zone_with(const ModelView& model, const std::string& type, const std::string& name) {
  for (const ModelObject& list : model.all("ZoneHVAC:EquipmentList")) {
    const auto types = list.texts("equipment", "zone_equipment_object_type");
    const auto names = list.texts("equipment", "zone_equipment_name");
    for (std::size_t i = 0; i < types.size() && i < names.size(); ++i) {
      if (!same_name(types[i], type) || !same_name(names[i], name)) continue;
      for (const ModelObject& zone : model.all("ZoneHVAC:EquipmentConnections")) {
        if (same_name(zone.text("zone_conditioning_equipment_list_name"), list.name)) return zone.text("zone_name");
      }
    }
  }
  return {};
}

LoopTerminal terminal_of(const ModelView& model, const ModelObject& terminal) {
  const auto rule = std::find_if(std::begin(terminal_rules), std::end(terminal_rules),
                                 [&](const TerminalRule& r) { return terminal.type == r.type; });
  if (rule == std::end(terminal_rules)) {
    throw hal::InputError(model.place_of(terminal), "a terminal of a kind that is not known here",
                          "a single-duct terminal: constant volume, VAV, powered induction unit or mixer",
                          "choose another air loop");
  }
  LoopTerminal out{terminal.type, terminal.name, {}, rule->kind, rule->damper};
  for (const ModelObject& unit : model.all("ZoneHVAC:AirDistributionUnit")) {
    if (!same_name(unit.text("air_terminal_name"), terminal.name) ||
        !same_name(unit.text("air_terminal_object_type"), terminal.type)) {
      continue;
    }
    out.zone = zone_with(model, unit.type, unit.name);
    if (out.zone.empty()) {
      throw hal::InputError(model.place_of(unit), "no zone whose equipment list has it",
                            "a ZoneHVAC:EquipmentList with this unit, and the zone's EquipmentConnections",
                            "add it to the list of its zone");
    }
    const ModelObject zone = model.find("Zone", out.zone);
    if (!zone) {
      throw hal::InputError(model.place() + ": ZoneHVAC:EquipmentConnections", "the zone \"" + out.zone + "\"",
                            "a Zone of the model", "add that zone, or correct the name");
    }
    out.zone = zone.name;
    return out;
  }
  throw hal::InputError(model.place_of(terminal), "no ZoneHVAC:AirDistributionUnit that names it",
                        "the unit by which the terminal belongs to a zone", "add it, or correct its air_terminal_name");
}

/// Every zone that a thermostat controls, in upper case.
std::set<std::string> thermostat_zones(const ModelView& model) {
  std::set<std::string> zones;
  for (const ModelObject& thermostat : model.all("ZoneControl:Thermostat")) {
    const std::string name = thermostat.text("zone_or_zonelist_name");
    const ModelObject list = model.find("ZoneList", name);
    if (!list) zones.insert(engine_upper(name));
    for (const std::string& zone : list.texts("zones", "zone_name")) zones.insert(engine_upper(zone));
  }
  return zones;
}

/// Fan coils and other equipment of the loop's zones.
void note_zone_equipment(const ModelView& model, AirLoop& loop) {
  std::map<std::string, int> others;
  for (const LoopTerminal& t : loop.terminals) {
    for (const ModelObject& zone : model.all("ZoneHVAC:EquipmentConnections")) {
      if (!same_name(zone.text("zone_name"), t.zone)) continue;
      const ModelObject list = model.find("ZoneHVAC:EquipmentList", zone.text("zone_conditioning_equipment_list_name"));
      bool fan_coil = false;
      for (const std::string& type : list.texts("equipment", "zone_equipment_object_type")) {
        if (same_name(type, "ZoneHVAC:FourPipeFanCoil")) fan_coil = true;
        if (!same_name(type, "ZoneHVAC:AirDistributionUnit")) ++others[type];
      }
      if (fan_coil) loop.fcu_zones.push_back(t.zone);
    }
  }
  for (const auto& [type, count] : others)
    loop.notes.push_back(fmt::format("the zones also have {} of {}, which follow their own controls", count, type));
}

void note_return_side(const ModelView& model, const ModelObject& object, AirLoop& loop) {
  for (const ModelObject& path : model.all("AirLoopHVAC:ReturnPath")) {
    if (!same_name(path.text("return_air_path_outlet_node_name"), object.text("demand_side_outlet_node_name")))
      continue;
    const auto types = path.texts("components", "component_object_type");
    const auto names = path.texts("components", "component_name");
    for (std::size_t i = 0; i < types.size() && i < names.size(); ++i) {
      const ModelObject part = model.need(types[i], path, "components", names[i]);
      if (part.type == "AirLoopHVAC:ReturnPlenum")
        loop.notes.push_back("return plenum \"" + part.text("zone_name") + "\": a zone of its own, no room");
    }
  }
}

}  // namespace

void walk_zone_side(const ModelView& model, const ModelObject& object, AirLoop& loop) {
  const auto splitters = splitters_of(model, object, loop);
  const auto ends = ends_of_path(model, splitters, loop.demand_inlet);
  const auto thermostats = thermostat_zones(model);
  std::set<std::string> zones;
  for (const std::string& node : ends) {
    const ModelObject terminal = terminal_at(model, node);
    if (!terminal) {
      throw hal::InputError(model.place_of(object),
                            "the node \"" + node +
                                "\" of its supply path, which no terminal "
                                "takes air from",
                            "an AirTerminal with this inlet node", "add the terminal, or correct the node");
    }
    LoopTerminal t = terminal_of(model, terminal);
    if (!zones.insert(engine_upper(t.zone)).second) {
      loop.notes.push_back("the zone \"" + t.zone + "\" has a second terminal, \"" + t.name +
                           "\": not a box of the site");
      continue;
    }
    t.thermostat = thermostats.contains(engine_upper(t.zone));
    loop.terminals.push_back(std::move(t));
  }
  if (loop.terminals.empty()) {
    throw hal::InputError(model.place_of(object), "no zone on this loop", "at least one zone with a terminal",
                          "choose another loop, or give its splitter outlets");
  }
  if (loop.terminals.size() > max_terminals) {
    throw hal::InputError(model.place_of(object), fmt::format("{} terminals", loop.terminals.size()),
                          fmt::format("at most {} boxes, as many as a site can have", max_terminals),
                          "choose a smaller air loop, or divide this one");
  }
  note_zone_equipment(model, loop);
  note_return_side(model, object, loop);
}

}  // namespace airside::tools
