#include "tools/adopt/model/model_view.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "hal/text/input_error.hpp"

namespace airside::tools {

namespace {

using nlohmann::json;

[[noreturn]] void refuse_shape(const std::string& place, const json& found, const char* expected) {
  throw hal::InputError(place, std::string("a JSON ") + found.type_name(), expected,
                        "give an EnergyPlus model, as the engine's own --convert-only writes it");
}

}  // namespace

std::string ModelObject::text(const char* field) const {
  if (fields == nullptr) return {};
  const auto at = fields->find(field);
  return at != fields->end() && at->is_string() ? at->get<std::string>() : std::string();
}

std::vector<std::string> ModelObject::texts(const char* array, const char* key) const {
  std::vector<std::string> out;
  if (fields == nullptr) return out;
  const auto at = fields->find(array);
  if (at == fields->end() || !at->is_array()) return out;
  for (const json& element : *at) {
    if (!element.is_object()) continue;
    const auto text = element.find(key);
    if (text != element.end() && text->is_string()) out.push_back(text->get<std::string>());
  }
  return out;
}

std::string engine_upper(std::string text) {
  for (char& c : text) {
    if (c >= 'a' && c <= 'z') c = static_cast<char>(c - 'a' + 'A');
  }
  return text;
}

bool same_name(const std::string& a, const std::string& b) { return engine_upper(a) == engine_upper(b); }

ModelView::ModelView(const json& model, std::string place) : model_(model), place_(std::move(place)) {
  if (!model.is_object()) refuse_shape(place_, model, "a JSON object of EnergyPlus object types");
  for (const auto& [type, objects] : model.items()) {
    if (!objects.is_object()) refuse_shape(place_ + ": " + type, objects, "an object of named objects");
    auto& of_type = objects_[engine_upper(type)];
    for (const auto& [name, fields] : objects.items()) {
      if (!fields.is_object()) refuse_shape(place_ + ": " + type + " / " + name, fields, "an object of fields");
      if (!of_type.emplace(engine_upper(name), ModelObject{type, name, &fields}).second) {
        throw hal::InputError(place_ + ": " + type + " / " + name, "a second object of this name, but for upper case",
                              "each name once", "rename one of them");
      }
    }
  }
}

std::string ModelView::place_of(const ModelObject& object, const std::string& field) const {
  return place_ + ": " + object.type + " / " + object.name + (field.empty() ? "" : " / " + field);
}

ModelObject ModelView::find(const std::string& type, const std::string& name) const {
  const auto of_type = objects_.find(engine_upper(type));
  if (of_type == objects_.end()) return {};
  const auto object = of_type->second.find(engine_upper(name));
  return object == of_type->second.end() ? ModelObject{} : object->second;
}

ModelObject ModelView::need(const std::string& type, const ModelObject& by, const std::string& field,
                            const std::string& name) const {
  if (name.empty()) {
    throw hal::InputError(place_of(by, field), "nothing", "the name of an object " + type, "name it there");
  }
  if (ModelObject found = find(type, name)) return found;
  throw hal::InputError(place_of(by, field), "the name \"" + name + "\", which no object " + type + " has",
                        "the name of an object " + type, "add that object, or correct the name");
}

std::vector<ModelObject> ModelView::all(const std::string& type) const {
  std::vector<ModelObject> out;
  const auto of_type = objects_.find(engine_upper(type));
  if (of_type == objects_.end()) return out;
  for (const auto& [upper, object] : of_type->second) out.push_back(object);
  return out;
}

std::vector<ModelObject> ModelView::all_of(const std::string& prefix) const {
  std::vector<ModelObject> out;
  const std::string begin = engine_upper(prefix);
  for (auto type = objects_.lower_bound(begin); type != objects_.end() && type->first.starts_with(begin); ++type) {
    for (const auto& [upper, object] : type->second) out.push_back(object);
  }
  return out;
}

std::vector<std::string> ModelView::nodes(const std::string& node_or_list) const {
  if (node_or_list.empty()) return {};
  const ModelObject list = find("NodeList", node_or_list);
  return list ? list.texts("nodes", "node_name") : std::vector<std::string>{node_or_list};
}

std::string ModelView::free_name(const std::string& type, const std::string& base) const {
  std::string name = base;
  for (int n = 2; find(type, name); ++n) name = fmt::format("{} {}", base, n);
  return name;
}

}  // namespace airside::tools
