#include "tools/adopt/loop/setpoint_patch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <set>

#include "hal/text/input_error.hpp"

namespace airside::tools {

namespace {

using nlohmann::json;

constexpr const char* scheduled = "SetpointManager:Scheduled";
constexpr const char* mixed_air = "SetpointManager:MixedAir";
constexpr const char* node_field = "setpoint_node_or_nodelist_name";

/// One manager with the nodes that it sets.
struct Manager {
  ModelObject object;
  std::vector<std::string> nodes;
};

bool sets_temperature(const ModelObject& manager) {
  const std::string variable = engine_upper(manager.text("control_variable"));
  if (manager.type.find("Humidity") != std::string::npos) return false;
  return variable.empty() || variable.find("TEMPERATURE") != std::string::npos;
}

std::vector<Manager> temperature_managers(const ModelView& model) {
  std::vector<Manager> out;
  for (const ModelObject& object : model.all_of("SetpointManager:")) {
    if (sets_temperature(object)) out.push_back({object, model.nodes(object.text(node_field))});
  }
  return out;
}

/// Where the air is cooled or heated in order to reach the supply setpoint: the mixed air (economiser), and every
/// outlet from the cooling coil on. A preheating coil upstream of it keeps its own setpoint.
std::set<std::string> following_nodes(const AirLoop& loop) {
  std::set<std::string> nodes;
  if (!loop.mixed_air_node.empty()) nodes.insert(engine_upper(loop.mixed_air_node));
  const auto cools = [](const LoopComponent& c) {
    return c.type.starts_with("Coil:Cooling") || c.type.starts_with("CoilSystem:Cooling") ||
           c.type.starts_with("AirLoopHVAC:Unitary");
  };
  const auto first = std::find_if(loop.components.begin(), loop.components.end(), cools);
  const bool cooled = first != loop.components.end();
  for (auto c = cooled ? first : loop.components.begin(); c != loop.components.end(); ++c)
    nodes.insert(engine_upper(c->outlet));
  for (const std::string& node : loop.unit.coil_outlets) nodes.insert(engine_upper(node));
  nodes.erase(engine_upper(loop.supply_outlet));
  return nodes;
}

bool has(const std::vector<std::string>& nodes, const std::string& node) {
  return std::any_of(nodes.begin(), nodes.end(), [&](const std::string& n) { return same_name(n, node); });
}

class PatchMaker {
 public:
  PatchMaker(const ModelView& model, const AirLoop& loop) : model_(model), loop_(loop) {}

  SetpointPatch make(double setpoint_degc) {
    const auto managers = temperature_managers(model_);
    refuse_without_setpoint(managers);
    out_.schedule = model_.free_name("Schedule:Constant", "airside supply setpoint");
    out_.patch["Schedule:Constant"][out_.schedule] = {{"hourly_value", setpoint_degc}};
    const auto following = following_nodes(loop_);
    std::set<std::string> orphans;  // nodes whose manager went
    for (const Manager& m : managers) take_over(m, following, orphans);
    add_scheduled(loop_.supply_outlet, "airside supply setpoint manager");
    for (const std::string& node : orphans) follow(node);
    switch_unit();
    drop_empty_types();
    return std::move(out_);
  }

 private:
  void refuse_without_setpoint(const std::vector<Manager>& managers) const {
    const std::string& type = loop_.unit.type;
    const std::string place = type.empty() ? model_.place() + ": AirLoopHVAC / " + loop_.name
                                           : model_.place() + ": " + type + " / " + loop_.unit.name;
    if (type == "AirLoopHVAC:UnitarySystem") {
      if (loop_.unit.control_type != "SingleZoneVAV") return;
      throw hal::InputError(place + " / control_type", "SingleZoneVAV: fan speed and coils follow the zone's load",
                            "Load, which can be switched, or SetPoint", "choose another loop");
    }
    if (!type.empty()) {
      throw hal::InputError(place, "a packaged unit that is controlled by the zone's load, without a setpoint",
                            "coils that follow a supply-air setpoint, or an AirLoopHVAC:UnitarySystem",
                            "replace it by an AirLoopHVAC:UnitarySystem of control_type SetPoint with the same coils "
                            "and fan, or choose another loop");
    }
    const auto following = following_nodes(loop_);
    for (const Manager& m : managers) {
      for (const std::string& node : m.nodes) {
        if (same_name(node, loop_.supply_outlet) || following.contains(engine_upper(node))) return;
      }
    }
    throw hal::InputError(place, "no setpoint manager at \"" + loop_.supply_outlet + "\" or at a coil of the loop",
                          "a loop whose coils follow a setpoint", "choose another loop, or add a setpoint manager");
  }

  /// Takes the loop's own nodes away from a manager; others that it sets stay with it.
  void take_over(const Manager& m, const std::set<std::string>& following, std::set<std::string>& orphans) {
    const bool at_outlet = has(m.nodes, loop_.supply_outlet);
    const bool follows =
        m.object.type == mixed_air && same_name(m.object.text("reference_setpoint_node_name"), loop_.supply_outlet);
    std::vector<std::string> kept;
    bool took = false;
    for (const std::string& node : m.nodes) {
      const bool outlet = same_name(node, loop_.supply_outlet);
      const bool ours = outlet || (!follows && following.contains(engine_upper(node)));
      if (ours && !outlet) orphans.insert(node);
      if (!ours) kept.push_back(node);
      took = took || ours;
    }
    if (!took) return;
    out_.knew_the_load = out_.knew_the_load || (at_outlet && m.object.type.starts_with("SetpointManager:SingleZone:"));
    out_.notes.push_back(fmt::format(
        "{} \"{}\" {}: replaced", m.object.type, m.object.name,
        at_outlet ? "at the supply outlet" : "at a node whose own rule would compete with the supply setpoint"));
    if (kept.empty()) {
      out_.patch[m.object.type][m.object.name] = nullptr;
      removed_[m.object.type].insert(engine_upper(m.object.name));
      return;
    }
    const std::string list = free_list("airside nodes of " + m.object.name);
    json nodes = json::array();
    for (const std::string& node : kept) nodes.push_back({{"node_name", node}});
    out_.patch["NodeList"][list] = {{"nodes", nodes}};
    out_.patch[m.object.type][m.object.name] = {{node_field, list}};
    out_.notes.push_back(fmt::format("it goes on at {} other nodes", kept.size()));
  }

  std::string free_list(const std::string& base) const {
    std::string name = model_.free_name("NodeList", base);
    while (out_.patch.contains("NodeList") && out_.patch["NodeList"].contains(name)) name += " too";
    return name;
  }

  void add_scheduled(const std::string& node, const std::string& base) {
    std::string name = model_.free_name(scheduled, base);
    while (out_.patch.contains(scheduled) && out_.patch[scheduled].contains(name)) name += " too";
    out_.patch[scheduled][name] = {
        {"control_variable", "Temperature"}, {"schedule_name", out_.schedule}, {node_field, node}};
  }

  /// The supply setpoint at another node of the loop, less the heat of a fan that comes after.
  void follow(const std::string& node) {
    const bool fan_behind = !loop_.blow_through || same_name(node, loop_.mixed_air_node);
    if (!fan_behind || loop_.fan.inlet.empty() || loop_.fan.outlet.empty()) {
      add_scheduled(node, "airside setpoint at " + node);
      return;
    }
    const std::string name = model_.free_name(mixed_air, "airside setpoint at " + node);
    out_.patch[mixed_air][name] = {{"control_variable", "Temperature"},
                                   {"reference_setpoint_node_name", loop_.supply_outlet},
                                   {"fan_inlet_node_name", loop_.fan.inlet},
                                   {"fan_outlet_node_name", loop_.fan.outlet},
                                   {node_field, node}};
  }

  /// Under setpoint control the unit's fan must run throughout; when it may rest is left to the availability managers.
  void switch_unit() {
    if (loop_.unit.type != "AirLoopHVAC:UnitarySystem" || same_name(loop_.unit.control_type, "SetPoint")) return;
    out_.unit_switched = true;
    const std::string running = model_.free_name("Schedule:Constant", "airside fan throughout");
    out_.patch["Schedule:Constant"][running] = {{"hourly_value", 1}};
    out_.patch[loop_.unit.type][loop_.unit.name] = {{"control_type", "SetPoint"},
                                                    {"supply_air_fan_operating_mode_schedule_name", running}};
    out_.notes.push_back("AirLoopHVAC:UnitarySystem \"" + loop_.unit.name +
                         "\": control_type Load became SetPoint, so that its coils follow the supply setpoint, and its "
                         "fan runs whenever the unit is available");
    for (const LoopComponent& c : loop_.components) {
      if (c.type == loop_.unit.type && !same_name(c.outlet, loop_.supply_outlet))
        add_scheduled(c.outlet, "airside setpoint at " + c.outlet);
    }
  }

  /// A type whose last object went goes as a whole.
  void drop_empty_types() {
    for (const auto& [type, names] : removed_) {
      if (names.size() == model_.all(type).size() && out_.patch[type].size() == names.size())
        out_.patch[type] = nullptr;
    }
  }

  const ModelView& model_;
  const AirLoop& loop_;
  SetpointPatch out_;
  std::map<std::string, std::set<std::string>> removed_;  ///< type, upper-case names
};

}  // namespace

SetpointPatch setpoint_patch(const ModelView& model, const AirLoop& loop, double setpoint_degc) {
  return PatchMaker(model, loop).make(setpoint_degc);
}

}  // namespace airside::tools
