#include "tools/gap/any_model/model_graph.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "hal/text/input_error.hpp"
#include "sim/effects/effect_text.hpp"
#include "tools/adopt/loop/loop_meters.hpp"

namespace airside::tools::gap {

namespace {

using nlohmann::json;
using sim::effect_text::matches;

/// Fields by which objects say in which zone they are.
constexpr const char* zone_fields[] = {"zone_or_zonelist_or_space_or_spacelist_name", "zone_or_zonelist_name",
                                       "zone_name"};

double number(const json& fields, const char* field) {
  const auto found = fields.find(field);
  return found != fields.end() && found->is_number() ? found->get<double>() : 0.0;
}

/// Of a list of vertices, by Newell's rule: no length, east, north and up; counterclockwise seen from outside.
std::array<double, 3> normal_of(const std::vector<std::array<double, 3>>& vertices) {
  std::array<double, 3> n{};
  for (std::size_t i = 0; i < vertices.size(); ++i) {
    const auto &a = vertices[i], &b = vertices[(i + 1) % vertices.size()];
    n[0] += (a[1] - b[1]) * (a[2] + b[2]);
    n[1] += (a[2] - b[2]) * (a[0] + b[0]);
    n[2] += (a[0] - b[0]) * (a[1] + b[1]);
  }
  return n;
}

std::vector<std::array<double, 3>> vertices_of(const json& fields) {
  std::vector<std::array<double, 3>> vertices;
  const auto list = fields.find("vertices");
  if (list == fields.end() || !list->is_array()) return vertices;
  for (const json& v : *list)
    vertices.push_back(
        {number(v, "vertex_x_coordinate"), number(v, "vertex_y_coordinate"), number(v, "vertex_z_coordinate")});
  return vertices;
}

/// The façade of a wall: its outward normal, turned by what the zone and the building are turned; -1 for roofs.
int facade_of(const ModelView& view, const ModelObject& wall, const std::string& zone) {
  constexpr double steep = 0.5;  // of the normal that may point up: 30 degrees from upright
  double azimuth_deg = 0;
  const auto given = wall.fields->find("azimuth_angle");
  if (given != wall.fields->end() && given->is_number()) {
    azimuth_deg = given->get<double>();
  } else {
    const auto n = normal_of(vertices_of(*wall.fields));
    const double length = std::hypot(n[0], n[1], n[2]);
    if (!(length > 0) || std::abs(n[2]) > steep * length) return -1;
    azimuth_deg = std::atan2(n[0], n[1]) * 180 / std::numbers::pi;
  }
  std::string system, entry;
  for (const ModelObject& rules : view.all("GlobalGeometryRules")) {
    system = rules.text("coordinate_system");
    entry = rules.text("vertex_entry_direction");
  }
  if (same_name(entry, "Clockwise") && given == wall.fields->end()) azimuth_deg += 180;
  if (!same_name(system, "World") && !same_name(system, "Absolute")) {
    for (const ModelObject& building : view.all("Building")) azimuth_deg += number(*building.fields, "north_axis");
    if (const ModelObject of = view.find("Zone", zone))
      azimuth_deg += number(*of.fields, "direction_of_relative_north");
  }
  constexpr long count = sim::facades;
  return static_cast<int>((std::lround(azimuth_deg / 90) % count + count) % count);
}

bool is_window(const ModelObject& surface) {
  const std::string kind = surface.text("surface_type");
  return surface.type == "Window" || (surface.type == "FenestrationSurface:Detailed" &&
                                      (same_name(kind, "Window") || same_name(kind, "GlassDoor")));
}

}  // namespace

ModelGraph::ModelGraph(const json& model, const sim::OwnNames& names) : view_(model, "model"), index_(model) {
  for (const auto* list : {&names.zones, &names.fcu_zones}) {
    for (const std::string& zone : *list) {
      const ModelObject known = view_.find("Zone", zone);
      zones_.push_back(known ? known.name : zone);
    }
  }
  for (const ModelObject& object : view_.all("AirLoopHVAC")) {
    if (!may_be_wanted(object, names)) continue;
    try {
      AirLoop loop = walk_air_loop(view_, object.name);
      if (is_wanted(loop, names)) loops_.push_back(std::move(loop));
    } catch (const hal::InputError&) {
      continue;  // its equipment is not applicable then
    }
  }
}

bool ModelGraph::may_be_wanted(const ModelObject& loop, const sim::OwnNames& names) const {
  if (!names.air_loops.empty()) {
    return std::any_of(names.air_loops.begin(), names.air_loops.end(),
                       [&](const std::string& name) { return same_name(loop.name, name); });
  }
  const auto nodes = view_.nodes(loop.text("supply_side_outlet_node_names"));
  return names.every_air_loop || std::any_of(nodes.begin(), nodes.end(), [&](const std::string& node) {
           return same_name(node, names.supply_air_node);
         });
}

bool ModelGraph::is_wanted(const AirLoop& loop, const sim::OwnNames& names) const {
  return !names.every_air_loop ||
         std::any_of(loop.terminals.begin(), loop.terminals.end(), [this](const LoopTerminal& terminal) {
           return std::any_of(zones_.begin(), zones_.end(),
                              [&](const std::string& zone) { return same_name(zone, terminal.zone); });
         });
}

std::vector<ModelObject> ModelGraph::all(const std::string& type) const {
  std::vector<ModelObject> found;
  for (const auto& [known, objects] : view_.content().items()) {
    if (!matches(type, known)) continue;
    for (const auto& [name, fields] : objects.items()) found.push_back({known, name, &fields});
  }
  return found;
}

std::vector<ModelObject> ModelGraph::in_zones(const std::string& type, const std::vector<std::string>& zones,
                                              bool alone) const {
  std::set<std::string> wanted;
  for (const std::string& zone : zones) wanted.insert(engine_upper(zone));
  std::vector<ModelObject> found;
  for (const ModelObject& object : all(type)) {
    std::set<std::string> there;
    for (const char* field : zone_fields) {
      if (there.empty()) there = index_.zones_behind(object.text(field));
    }
    const auto inside =
        std::count_if(there.begin(), there.end(), [&](const auto& zone) { return wanted.contains(zone); });
    if (inside > 0 && (!alone || inside == std::ssize(there))) found.push_back(object);
  }
  return found;
}

std::vector<ModelObject> ModelGraph::terminals_of(const std::string& type,
                                                  const std::vector<std::string>& zones) const {
  std::vector<ModelObject> found;
  for (const AirLoop& loop : loops_) {
    for (const LoopTerminal& t : loop.terminals) {
      const bool here =
          std::any_of(zones.begin(), zones.end(), [&](const std::string& zone) { return same_name(zone, t.zone); });
      if (!here || !matches(type, t.type)) continue;
      if (const ModelObject object = view_.find(t.type, t.name)) found.push_back(object);
    }
  }
  return found;
}

std::vector<ModelObject> ModelGraph::equipment() const {
  std::vector<ModelObject> parts;
  for (const AirLoop& loop : loops_) {
    if (const ModelObject fan = view_.find(loop.fan.type, loop.fan.name)) parts.push_back(fan);
    for (ModelObject& coil : loop_coils(view_, loop)) parts.push_back(std::move(coil));
    if (ModelObject controller = outdoor_air_controller(view_, loop)) parts.push_back(std::move(controller));
  }
  return parts;
}

std::vector<ModelObject> ModelGraph::on_air_loop(const std::string& type) const {
  std::vector<ModelObject> parts = equipment();
  std::erase_if(parts, [&](const ModelObject& part) { return !matches(type, part.type); });
  return parts;
}

std::vector<OuterSurface> ModelGraph::outer_surfaces(const std::vector<std::string>& zones) const {
  std::vector<OuterSurface> found;
  for (const char* type :
       {"BuildingSurface:Detailed", "Wall:Detailed", "RoofCeiling:Detailed", "Wall:Exterior", "Roof"}) {
    for (const ModelObject& wall : view_.all(type)) {
      std::string zone = wall.text("zone_name");
      if (zone.empty()) zone = view_.find("Space", wall.text("space_name")).text("zone_name");
      const bool here =
          std::any_of(zones.begin(), zones.end(), [&](const std::string& wanted) { return same_name(zone, wanted); });
      const std::string beyond = wall.text("outside_boundary_condition");
      if (!here || !(beyond.empty() || same_name(beyond, "Outdoors"))) continue;
      const OuterSurface surface{wall, engine_upper(zone), wall.text("construction_name"), false,
                                 facade_of(view_, wall, zone)};
      for (const char* glazed : {"FenestrationSurface:Detailed", "Window"}) {
        for (const ModelObject& window : view_.all(glazed)) {
          if (!is_window(window) || !same_name(window.text("building_surface_name"), wall.name)) continue;
          found.push_back({window, surface.zone, window.text("construction_name"), true, surface.facade});
        }
      }
      found.push_back(surface);
    }
  }
  return found;
}

double ModelGraph::floor_area_m2(const std::string& zone) const {
  const ModelObject object = view_.find("Zone", zone);
  if (object && number(*object.fields, "floor_area") > 0) return number(*object.fields, "floor_area");
  double area = 0;
  for (const char* type : {"BuildingSurface:Detailed", "Floor:Detailed"}) {
    for (const ModelObject& floor : in_zones(type, {zone}, true)) {
      const std::string kind = floor.text("surface_type");
      if (!kind.empty() && !same_name(kind, "Floor")) continue;
      const auto n = normal_of(vertices_of(*floor.fields));
      area += std::hypot(n[0], n[1], n[2]) / 2;
    }
  }
  return area;
}

std::vector<ModelObject> ModelGraph::layers_of(const std::string& construction) const {
  std::vector<ModelObject> layers;
  const ModelObject object = view_.find("Construction", construction);
  for (int n = 1; object && n <= 10; ++n) {
    const std::string field = n == 1 ? "outside_layer" : "layer_" + std::to_string(n);
    const std::string name = object.text(field.c_str());
    if (name.empty()) break;
    for (const char* begin : {"Material", "WindowMaterial:"}) {
      for (const ModelObject& material : view_.all_of(begin)) {
        if (same_name(material.name, name)) layers.push_back(material);
      }
    }
  }
  return layers;
}

std::array<bool, sim::facades> ModelGraph::has_facade() const {
  std::array<bool, sim::facades> has{};
  for (const OuterSurface& surface : outer_surfaces(zones_)) {
    if (surface.window && surface.facade >= 0) has[static_cast<std::size_t>(surface.facade)] = true;
  }
  return has;
}

}  // namespace airside::tools::gap
