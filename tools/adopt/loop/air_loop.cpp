#include "tools/adopt/loop/air_loop.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <set>

#include "hal/text/input_error.hpp"
#include "tools/adopt/loop/zone_side.hpp"

namespace airside::tools {

namespace {

/// Fields under which a unit names its supply fan: type and name.
constexpr std::pair<const char*, const char*> fan_fields[] = {
    {"supply_fan_object_type", "supply_fan_name"},
    {"supply_air_fan_object_type", "supply_air_fan_name"},
};

std::string names_of(const std::vector<ModelObject>& loops) {
  std::string text;
  for (const ModelObject& loop : loops) text += (text.empty() ? "\"" : ", \"") + loop.name + "\"";
  return text;
}

bool is_fan(const std::string& type) { return type.starts_with("Fan:") && type != "Fan:ZoneExhaust"; }

bool is_unit(const std::string& type) { return type.starts_with("AirLoopHVAC:Unitary"); }

std::vector<LoopComponent> components_of(const ModelView& model, const ModelObject& loop) {
  const ModelObject list = model.need("BranchList", loop, "branch_list_name", loop.text("branch_list_name"));
  std::vector<LoopComponent> out;
  for (const std::string& name : list.texts("branches", "branch_name")) {
    const ModelObject branch = model.need("Branch", list, "branches", name);
    const auto types = branch.texts("components", "component_object_type");
    const auto names = branch.texts("components", "component_name");
    const auto inlets = branch.texts("components", "component_inlet_node_name");
    const auto outlets = branch.texts("components", "component_outlet_node_name");
    if (types.empty() || types.size() != names.size() || types.size() != inlets.size() ||
        types.size() != outlets.size()) {
      throw hal::InputError(model.place_of(branch, "components"), "components without type, name or nodes",
                            "type, name, inlet and outlet node of each", "complete them");
    }
    for (std::size_t i = 0; i < types.size(); ++i) {
      const ModelObject part = model.need(types[i], branch, "components", names[i]);
      out.push_back({part.type, part.name, inlets[i], outlets[i]});
    }
  }
  if (out.empty()) {
    throw hal::InputError(model.place_of(list, "branches"), "no equipment on the supply side",
                          "an air handling unit: outdoor air, coils, fan", "name its branch there");
  }
  return out;
}

/// Each component's outlet leads on, and none is passed twice.
void check_order(const ModelView& model, const ModelObject& loop, const AirLoop& found) {
  std::set<std::string> passed;
  for (const LoopComponent& c : found.components) {
    if (passed.insert(engine_upper(c.outlet)).second && !same_name(c.inlet, c.outlet)) continue;
    throw hal::InputError(model.place_of(loop, "branch_list_name"),
                          "the node \"" + c.outlet + "\", which the air of this loop passes twice",
                          "equipment one behind the other", "correct the nodes of " + c.type + " / " + c.name);
  }
  if (passed.contains(engine_upper(found.supply_outlet))) return;
  throw hal::InputError(model.place_of(loop, "supply_side_outlet_node_names"),
                        "the node \"" + found.supply_outlet + "\", which no equipment of its branches leads to",
                        "the outlet of the last equipment, \"" + found.components.back().outlet + "\"",
                        "name that node, or correct the branch");
}

/// Nodes behind the unit's coils: managers may set them.
std::vector<std::string> coil_outlets(const ModelView& model, const ModelObject& unit) {
  std::vector<std::string> out;
  for (const char* coil : {"cooling_coil", "heating_coil"}) {
    const std::string type = unit.text((std::string(coil) + "_object_type").c_str());
    const std::string name = unit.text((std::string(coil) + "_name").c_str());
    const ModelObject object = model.find(type, name);
    if (!object) continue;
    for (const char* field : {"air_outlet_node_name", "dx_cooling_coil_system_outlet_node_name"}) {
      if (!object.text(field).empty()) out.push_back(object.text(field));
    }
  }
  return out;
}

void find_unit(const ModelView& model, const LoopComponent& c, AirLoop& loop) {
  const ModelObject unit = model.find(c.type, c.name);
  loop.unit = {c.type, unit.name, unit.text("control_type"), coil_outlets(model, unit)};
  if (loop.unit.control_type.empty()) loop.unit.control_type = "Load";
  loop.blow_through = same_name(unit.text("fan_placement"), "BlowThrough");
  for (const auto& [type, name] : fan_fields) {
    const ModelObject fan = model.find(unit.text(type), unit.text(name));
    if (fan) loop.fan = {fan.type, fan.name, fan.text("air_inlet_node_name"), fan.text("air_outlet_node_name")};
  }
}

/// Fan and unit of the supply side.
void find_equipment(const ModelView& model, AirLoop& loop) {
  bool cooled = false;
  for (const LoopComponent& c : loop.components) {
    cooled = cooled || c.type.starts_with("Coil");
    if (is_fan(c.type)) {
      loop.fan = c;  // the last: a return fan comes before
      loop.blow_through = !cooled;
    }
    if (is_unit(c.type)) find_unit(model, c, loop);
  }
}

/// The outdoor-air system, if there is one: its mixer tells where outdoor and mixed air are.
void find_outdoor_air(const ModelView& model, AirLoop& loop) {
  for (const LoopComponent& c : loop.components) {
    if (c.type != "AirLoopHVAC:OutdoorAirSystem") continue;
    const ModelObject system = model.find(c.type, c.name);
    const ModelObject list =
        model.need("AirLoopHVAC:OutdoorAirSystem:EquipmentList", system, "outdoor_air_equipment_list_name",
                   system.text("outdoor_air_equipment_list_name"));
    loop.mixed_air_node = c.outlet;
    for (int n = 1; n <= 9; ++n) {
      const std::string type = list.text(fmt::format("component_{}_object_type", n).c_str());
      const std::string field = fmt::format("component_{}_name", n);
      if (type.empty()) continue;
      const ModelObject part = model.need(type, list, field, list.text(field.c_str()));
      if (part.type == "OutdoorAir:Mixer") {
        loop.outdoor_stream_node = part.text("outdoor_air_stream_node_name");
      } else if (part.type.starts_with("Coil") || part.type.starts_with("HeatExchanger")) {
        loop.outdoor_air_treated = true;
      }
    }
  }
  if (loop.outdoor_stream_node.empty()) loop.outdoor_air_treated = false;
}

}  // namespace

const char* text_of(TerminalKind kind) {
  switch (kind) {
    case TerminalKind::fixed: return "fixed";
    case TerminalKind::modulating: return "modulating";
    case TerminalKind::reheat: return "reheat";
  }
  return "";
}

TerminalKind AirLoop::kind() const {
  int counts[3] = {};
  for (const LoopTerminal& t : terminals) ++counts[static_cast<int>(t.kind)];
  return static_cast<TerminalKind>(std::max_element(counts, counts + 3) - counts);
}

std::string chosen_air_loop(const ModelView& model, const std::string& wanted) {
  const auto loops = model.all("AirLoopHVAC");
  const std::string place = model.place() + ": AirLoopHVAC";
  if (loops.empty()) {
    const bool own = !model.all_of("ZoneHVAC:").empty();
    throw hal::InputError(place, own ? "no air loop: the zones have units of their own" : "no air loop",
                          "a central air handling unit with a supply-air setpoint",
                          "adopt a model with an AirLoopHVAC; a model of ideal loads or room units has no supply air "
                          "to control");
  }
  if (wanted.empty()) {
    if (loops.size() == 1) return loops.front().name;
    throw hal::InputError(place, fmt::format("{} air loops: {}", loops.size(), names_of(loops)), "one to adopt",
                          "name it: --air-loop \"" + loops.front().name + "\"");
  }
  if (const ModelObject loop = model.find("AirLoopHVAC", wanted)) return loop.name;
  throw hal::InputError("--air-loop", "\"" + wanted + "\"", "an air loop of the model: " + names_of(loops),
                        "choose one of them");
}

AirLoop walk_air_loop(const ModelView& model, const std::string& name) {
  const ModelObject object = model.find("AirLoopHVAC", name);
  AirLoop loop;
  loop.name = object.name;
  const auto one_node = [&](const char* field, const char* what) {
    const auto nodes = model.nodes(object.text(field));
    if (nodes.size() == 1 && !nodes.front().empty()) return nodes.front();
    throw hal::InputError(model.place_of(object, field),
                          nodes.empty() || nodes.front().empty() ? "no node" : fmt::format("{} nodes", nodes.size()),
                          std::string("one ") + what,
                          nodes.size() > 1 ? "choose a single-duct loop: with two ducts one setpoint does not say what "
                                             "the rooms get"
                                           : "name the node there");
  };
  loop.supply_outlet = one_node("supply_side_outlet_node_names", "supply outlet");
  loop.demand_inlet = one_node("demand_side_inlet_node_names", "inlet of the zones' side");
  loop.components = components_of(model, object);
  check_order(model, object, loop);
  find_equipment(model, loop);
  find_outdoor_air(model, loop);
  walk_zone_side(model, object, loop);
  return loop;
}

}  // namespace airside::tools
