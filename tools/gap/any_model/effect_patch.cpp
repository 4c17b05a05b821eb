#include "tools/gap/any_model/effect_patch.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "sim/effects/effect_text.hpp"
#include "tools/gap/any_model/model_graph.hpp"
#include "tools/gap/any_model/schedule_shift.hpp"

namespace airside::tools::gap {

namespace {

using nlohmann::json;
using sim::By;
using sim::EffectChange;
using sim::EffectOp;
using sim::PlaceKind;
using sim::Select;
using sim::effect_text::matches;

bool is_number(const json& fields, const std::string& field) {
  const auto found = fields.find(field);
  return found != fields.end() && found->is_number();
}

/// Glass lets through, throws back and takes up no more than there is.
double most_transmitted(const json& fields) {
  constexpr double absorbs = 0.01;
  double most_back = 0;
  for (const char* side :
       {"front_side_solar_reflectance_at_normal_incidence", "back_side_solar_reflectance_at_normal_incidence"}) {
    if (is_number(fields, side)) most_back = std::max(most_back, fields.at(side).get<double>());
  }
  return 1 - absorbs - most_back;
}

double resistance_of(const ModelObject& layer) {
  if (is_number(*layer.fields, "thermal_resistance")) return layer.fields->at("thermal_resistance").get<double>();
  if (!is_number(*layer.fields, "thickness") || !is_number(*layer.fields, "conductivity")) return 0;
  return layer.fields->at("thickness").get<double>() / layer.fields->at("conductivity").get<double>();
}

/// One change on a model as others left it.
class Patcher {
 public:
  Patcher(const json& model, const sim::OwnNames& names, const EffectChange& change)
      : graph_(model, names), change_(change) {
    const auto place = static_cast<std::size_t>(change.at.place);
    switch (change.at.effect->place) {
      case PlaceKind::zone:
      case PlaceKind::vav: zones_ = {graph_.zones().at(place)}; break;
      case PlaceKind::fcu: zones_ = {graph_.zones().at(names.zones.size() + place)}; break;
      default: zones_ = graph_.zones();
    }
  }

  json patch() {
    for (const EffectOp& op : change_.at.effect->any_model) {
      if (op.on == EffectOp::On::selected) apply(op);
    }
    // A schedule or an object of its own is not what an effect is about.
    return touched_ ? std::move(patch_) : json::object();
  }

 private:
  bool at_one_zone() const { return change_.at.effect->place != PlaceKind::floor; }

  void apply(const EffectOp& op) {
    if (op.select == Select::windows || op.select == Select::walls) {
      change_layers(op);
      return;
    }
    std::vector<ModelObject> found;
    if (!op.fields.empty()) found = selected(op);
    std::vector<std::string> changed;
    for (const ModelObject& object : found) {
      if (change_fields(op, object)) changed.push_back(object.name);
    }
    if (op.object.is_null()) return;
    if (op.select == Select::model) {
      if (changed.empty()) add(op, "", !op.name.empty());
      return;
    }
    for (const std::string& zone : zones_) {
      const auto there = op.fields.empty() ? std::vector<ModelObject>{} : graph_.in_zones(op.type, {zone}, false);
      const bool known = std::any_of(there.begin(), there.end(), [&](const ModelObject& object) {
        return std::find(changed.begin(), changed.end(), object.name) != changed.end();
      });
      if (!known) add(op, zone, false);
    }
  }

  std::vector<ModelObject> selected(const EffectOp& op) const {
    switch (op.select) {
      case Select::zones: return graph_.in_zones(op.type, zones_, at_one_zone());
      case Select::terminals: return graph_.terminals_of(op.type, zones_);
      case Select::air_loop: return graph_.on_air_loop(op.type);
      case Select::model: return graph_.all(op.type);
      case Select::windows:
      case Select::walls: break;
    }
    return {};
  }

  static bool meant(const EffectOp& op, const std::string& field) {
    return std::any_of(op.fields.begin(), op.fields.end(),
                       [&](const std::string& pattern) { return matches(pattern, field); });
  }

  bool change_fields(const EffectOp& op, const ModelObject& object) {
    bool any = false;
    for (const auto& [field, value] : object.fields->items()) {
      if (!meant(op, field)) continue;
      if (op.by == By::shift) {
        any = shift_schedule(op, object, field) || any;
        continue;
      }
      if (!value.is_number()) continue;
      double x = sim::changed_number(op, value.get<double>(), change_.magnitude);
      if (field == "solar_transmittance_at_normal_incidence") x = std::min(x, most_transmitted(*object.fields));
      patch_[object.type][object.name][field] = x;
      any = touched_ = true;
    }
    return any;
  }

  /// The object follows a copy of its schedule: others may follow the same.
  bool shift_schedule(const EffectOp& op, const ModelObject& object, const std::string& field) {
    constexpr const char* compact = "Schedule:Compact";
    const ModelObject schedule = graph_.view().find(compact, object.text(field.c_str()));
    if (!schedule) return false;
    const double hours = op.offset + op.factor * change_.magnitude;
    const auto shifted = shifted_compact(*schedule.fields, static_cast<int>(std::lround(60 * hours)));
    if (!shifted) return false;
    const std::string name = schedule.name + (schedule.name.ends_with(" shifted") ? "" : " shifted");
    patch_[compact][name] = *shifted;
    patch_[object.type][object.name][field] = name;
    return touched_ = true;
  }

  /// `shared`: one of the name is as good as another, such as a schedule.
  void add(const EffectOp& op, const std::string& zone, bool shared) {
    const sim::EffectAt& at = change_.at;
    double m = std::clamp(op.offset + op.factor * change_.magnitude, op.lowest, op.highest);
    if (op.per_area) m *= graph_.floor_area_m2(zone);
    if (op.per_area && m == 0) return;
    std::string name = op.name;
    if (name.empty()) name = "airside " + at.id() + (zone.empty() ? "" : " " + zone);
    if (!shared) name = graph_.view().free_name(op.type, name);
    patch_[op.type][name] = sim::effect_text::filled(op.object, at, zone, m);
    touched_ = touched_ || !shared;
  }

  void change_layers(const EffectOp& op) {
    const bool windows = op.select == Select::windows;
    const bool at_facade = change_.at.effect->place == PlaceKind::facade;
    std::map<std::string, std::vector<OuterSurface>> by_construction;
    for (const OuterSurface& surface : graph_.outer_surfaces(zones_)) {
      if (surface.window != windows || (at_facade && surface.facade != change_.at.place)) continue;
      by_construction[surface.construction].push_back(surface);
    }
    for (const auto& [construction, surfaces] : by_construction) {
      const ModelObject layer = layer_of(op, construction);
      if (!layer || !change_fields(op, layer)) continue;
      if (at_facade) move_to_copies(layer, construction, surfaces);
    }
  }

  /// The outermost of its type, or of walls the one that insulates most.
  ModelObject layer_of(const EffectOp& op, const std::string& construction) const {
    const std::vector<ModelObject> layers = graph_.layers_of(construction);
    if (op.select == Select::windows) {
      const auto outermost =
          std::find_if(layers.begin(), layers.end(), [&](const auto& layer) { return matches(op.type, layer.type); });
      return outermost == layers.end() ? ModelObject{} : *outermost;
    }
    const auto most = std::max_element(
        layers.begin(), layers.end(), [](const auto& a, const auto& b) { return resistance_of(a) < resistance_of(b); });
    return most == layers.end() || !matches(op.type, most->type) ? ModelObject{} : *most;
  }

  /// What was changed of a layer becomes a copy of it, in a copy of the construction, for these windows alone.
  void move_to_copies(const ModelObject& layer, const std::string& construction,
                      const std::vector<OuterSurface>& surfaces) {
    const std::string mark = " " + sim::effect_text::facade_name(change_.at.place);
    if (construction.ends_with(mark)) return;  // an earlier change's own
    json copy = *layer.fields;
    copy.update(patch_[layer.type][layer.name]);
    patch_[layer.type].erase(layer.name);
    patch_[layer.type][layer.name + mark] = std::move(copy);
    const ModelObject of = graph_.view().find("Construction", construction);
    json layers = *of.fields;
    for (auto& [field, name] : layers.items()) {
      if (name.is_string() && same_name(name.get<std::string>(), layer.name)) name = layer.name + mark;
    }
    patch_["Construction"][of.name + mark] = std::move(layers);
    for (const OuterSurface& window : surfaces)
      patch_[window.object.type][window.object.name]["construction_name"] = of.name + mark;
  }

  ModelGraph graph_;
  const EffectChange& change_;
  std::vector<std::string> zones_;
  json patch_ = json::object();
  bool touched_ = false;
};

}  // namespace

json any_model_patch(const json& model, const sim::OwnNames& names, std::span<const EffectChange> changes) {
  json patch = json::object(), now;
  for (std::size_t i = 0; i < changes.size(); ++i) {
    if (changes[i].magnitude == changes[i].at.effect->null_value || changes[i].at.effect->any_model.empty()) continue;
    const json step = Patcher(now.is_null() ? model : now, names, changes[i]).patch();
    patch.merge_patch(step);
    if (i + 1 == changes.size()) break;
    if (now.is_null()) now = model;
    now.merge_patch(step);
  }
  return patch;
}

std::string why_not_applicable(const json& model, const sim::OwnNames& names, const sim::EffectAt& at) {
  const sim::Effect& effect = *at.effect;
  if (!effect.on_any_model) return "its file says nothing of models with other names";
  const bool beside =
      effect.any_model.empty() || std::any_of(effect.any_model.begin(), effect.any_model.end(),
                                              [](const auto& op) { return op.on == EffectOp::On::loop; });
  if (beside) return {};
  const EffectChange probe{at, effect.probe[0]};
  if (!any_model_patch(model, names, std::span(&probe, 1)).empty()) return {};
  std::string sought;
  for (const EffectOp& op : effect.any_model) sought += (sought.empty() ? "" : ", ") + op.type;
  return "the model has no such object there: " + sought;
}

}  // namespace airside::tools::gap
