#include "tools/adopt/loop/loop_meters.hpp"

#include <algorithm>
#include <utility>

namespace airside::tools {

namespace {

using nlohmann::json;

/// A meter, and what it counts.
class MeterParts {
 public:
  void add(const std::string& key, const char* variable) {
    parts_.push_back({{"key_name", key}, {"output_variable_or_meter_name", variable}});
  }
  void write(json& patch, const char* name, const char* fuel) const {
    if (!parts_.empty()) patch["Meter:Custom"][name] = {{"resource_type", fuel}, {"variable_details", parts_}};
  }

 private:
  json parts_ = json::array();
};

using TypeAndName = std::pair<std::string, std::string>;

/// What outdoor air passes before it meets return air: preheat coils, fans.
std::vector<TypeAndName> outdoor_air_equipment(const ModelView& model, const AirLoop& loop) {
  std::vector<TypeAndName> parts;
  for (const LoopComponent& c : loop.components) {
    if (c.type != "AirLoopHVAC:OutdoorAirSystem") continue;
    const ModelObject list = model.find("AirLoopHVAC:OutdoorAirSystem:EquipmentList",
                                        model.find(c.type, c.name).text("outdoor_air_equipment_list_name"));
    for (int n = 1; list && n <= 9; ++n) {
      const std::string base = "component_" + std::to_string(n);
      const std::string type = list.text((base + "_object_type").c_str());
      if (!type.empty()) parts.emplace_back(type, list.text((base + "_name").c_str()));
    }
  }
  return parts;
}

/// The coils of the loop: those on its branches, in its coil systems and packaged unit, and those of its terminals;
/// with `more` parts those among them too.
class Coils {
 public:
  Coils(const ModelView& model, const AirLoop& loop, const std::vector<TypeAndName>& more = {}) : model_(model) {
    for (const auto& [type, name] : more) add(type, name);
    for (const LoopComponent& c : loop.components) add(c.type, c.name);
    for (const LoopTerminal& t : loop.terminals) {
      const ModelObject terminal = model.find(t.type, t.name);
      add(terminal.text("reheat_coil_object_type"), terminal.text("reheat_coil_name"));
    }
  }
  const std::vector<TypeAndName>& list() const { return list_; }

 private:
  void add(const std::string& type, const std::string& name) {
    if (type.starts_with("Coil:")) {
      list_.emplace_back(type, name);
      return;
    }
    const ModelObject holder = model_.find(type, name);
    for (const char* coil : {"cooling_coil", "heating_coil", "reheat_coil", "supplemental_heating_coil"}) {
      const std::string base = coil;
      const std::string of_type = holder.text((base + "_object_type").c_str());
      if (!of_type.empty()) add(of_type, holder.text((base + "_name").c_str()));
    }
  }

  const ModelView& model_;
  std::vector<TypeAndName> list_;
};

/// A number that the model has, or that its sizing found; 0 where neither is there.
double number_of(const ModelObject& object, const char* field, const json& sizes) {
  if (!object) return 0;
  const auto own = object.fields->find(field);
  if (own != object.fields->end() && own->is_number()) return own->get<double>();
  const auto type = sizes.find(object.type);
  if (type == sizes.end() || !type->is_object()) return 0;
  const auto sized = type->find(object.name);
  if (sized == type->end() || !sized->is_object()) return 0;
  const auto value = sized->find(field);
  return value != sized->end() && value->is_number() ? value->get<double>() : 0;
}

/// Other fuels have no meter among a site's powers.
bool burns_gas(const ModelObject& coil) {
  const std::string fuel = coil.text("fuel_type");
  return fuel.empty() || same_name(fuel, "NaturalGas");
}

}  // namespace

ModelObject outdoor_air_controller(const ModelView& model, const AirLoop& loop) {
  for (const LoopComponent& c : loop.components) {
    if (c.type != "AirLoopHVAC:OutdoorAirSystem") continue;
    const ModelObject list =
        model.find("AirLoopHVAC:ControllerList", model.find(c.type, c.name).text("controller_list_name"));
    for (int n = 1; list && n <= 8; ++n) {
      const std::string base = "controller_" + std::to_string(n);
      if (list.text((base + "_object_type").c_str()) == "Controller:OutdoorAir")
        return model.find("Controller:OutdoorAir", list.text((base + "_name").c_str()));
    }
  }
  return {};
}

std::vector<ModelObject> loop_coils(const ModelView& model, const AirLoop& loop) {
  std::vector<ModelObject> coils;
  const Coils known(model, loop);
  for (const auto& [type, name] : known.list()) {
    if (const ModelObject coil = model.find(type, name)) coils.push_back(coil);
  }
  return coils;
}

namespace {

/// Each once: on the branches, before the mixing of outdoor air, in packaged units and in terminals.
std::vector<std::string> loop_fans(const ModelView& model, const AirLoop& loop,
                                   const std::vector<TypeAndName>& outdoor_air) {
  std::vector<std::string> names;
  const auto add = [&](const std::string& name) {
    const auto same = [&](const std::string& known) { return same_name(known, name); };
    if (!name.empty() && std::none_of(names.begin(), names.end(), same)) names.push_back(name);
  };
  const auto add_of = [&](const std::string& type, const std::string& name) {
    if (type.starts_with("Fan:")) return add(name);
    const ModelObject holder = model.find(type, name);
    for (const char* field : {"supply_fan_name", "supply_air_fan_name", "fan_name"}) add(holder.text(field));
  };
  for (const auto& [type, name] : outdoor_air) add_of(type, name);
  for (const LoopComponent& c : loop.components) add_of(c.type, c.name);
  for (const LoopTerminal& t : loop.terminals) add_of(t.type, t.name);
  add(loop.fan.name);
  return names;
}

}  // namespace

LoopMeters loop_meters(const ModelView& model, const AirLoop& loop) {
  MeterParts fans, cooling, heating, gas;
  LoopMeters out;
  const std::vector<TypeAndName> outdoor_air = outdoor_air_equipment(model, loop);
  for (const std::string& name : loop_fans(model, loop, outdoor_air)) {
    fans.add(name, "Fan Electricity Energy");
    out.fans = true;
  }
  int cooled_by_water = 0, heated_by_water = 0, cools = 0, heats = 0;
  const Coils coils(model, loop, outdoor_air);
  for (const auto& [type, name] : coils.list()) {
    if (type.starts_with("Coil:Cooling:DX")) {
      cooling.add(name, "Cooling Coil Electricity Energy");
      ++cools;
    } else if (type.starts_with("Coil:Cooling:")) {
      ++cooled_by_water;
    } else if (type == "Coil:Heating:Electric") {
      heating.add(name, "Heating Coil Electricity Energy");
      ++heats;
    } else if (type == "Coil:Heating:Fuel" && burns_gas(model.find(type, name))) {
      gas.add(name, "Heating Coil NaturalGas Energy");
      ++heats;
    } else if (type.starts_with("Coil:Heating:")) {
      ++heated_by_water;
    }
  }
  out.cooling = cools > 0 && cooled_by_water == 0;
  out.heating = heats > 0 && heated_by_water == 0;
  if (out.fans) fans.write(out.patch, loop_fans_meter, "Electricity");
  if (out.cooling) cooling.write(out.patch, loop_cooling_meter, "Electricity");
  if (out.heating) {
    heating.write(out.patch, loop_heating_meter, "Electricity");
    gas.write(out.patch, loop_gas_meter, "NaturalGas");
  }
  return out;
}

double least_outdoor_share(const ModelView& model, const AirLoop& loop, const json& sizes) {
  const double least = number_of(outdoor_air_controller(model, loop), "minimum_outdoor_air_flow_rate", sizes);
  const double design = number_of(model.find("AirLoopHVAC", loop.name), "design_supply_air_flow_rate", sizes);
  return design > 0 ? std::clamp(least / design, 0.0, 1.0) : 0.0;
}

}  // namespace airside::tools
