#include "sim/energyplus/adopted/model_index.hpp"

#include <algorithm>
#include <cctype>

namespace airside::sim {

std::string engine_case(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string ModelObject::text(const char* field) const {
  if (fields == nullptr || !fields->is_object()) return {};
  const auto found = fields->find(field);
  return found != fields->end() && found->is_string() ? found->get<std::string>() : std::string();
}

ModelIndex::ModelIndex(const nlohmann::json& model) : model_(model) {
  if (!model.is_object()) return;
  for (const auto& [type, objects] : model.items()) {
    if (!objects.is_object()) continue;
    for (const auto& [name, fields] : objects.items()) objects_.emplace(engine_case(type), engine_case(name));
  }
  gather_texts(model);
}

bool ModelIndex::object(const std::string& type, const std::string& name) const {
  return objects_.contains({engine_case(type), engine_case(name)});
}

std::vector<ModelObject> ModelIndex::of_type(std::string_view type) const {
  const std::string sought = engine_case(std::string(type));
  const bool begins = sought.empty() || sought.back() == ':';
  std::vector<ModelObject> found;
  if (!model_.is_object()) return found;
  for (const auto& [known, objects] : model_.items()) {
    if (!objects.is_object()) continue;
    const std::string candidate = engine_case(known);
    if (begins ? !candidate.starts_with(sought) : candidate != sought) continue;
    for (const auto& [name, fields] : objects.items()) found.push_back({known, name, &fields});
  }
  return found;
}

ModelObject ModelIndex::find(std::string_view type, const std::string& name) const {
  const std::string sought = engine_case(name);
  for (ModelObject& object : of_type(type)) {
    if (engine_case(object.name) == sought) return object;
  }
  return {};
}

std::vector<std::string> ModelIndex::names_of(std::string_view type) const {
  std::vector<std::string> names;
  for (ModelObject& object : of_type(type)) names.push_back(std::move(object.name));
  return names;
}

std::vector<std::string> ModelIndex::nodes() const {
  std::set<std::string> names;
  for (const ModelObject& object : of_type("")) {
    if (!object.fields->is_object()) continue;
    for (const auto& [field, value] : object.fields->items()) {
      if (value.is_string() && field.find("node") != std::string::npos) names.insert(value.get<std::string>());
    }
  }
  return {names.begin(), names.end()};
}

std::set<std::string> ModelIndex::zones_behind(const std::string& name) const {
  std::set<std::string> zones;
  const auto add_members = [&](const char* type, const char* list, const char* field, const auto& each) {
    const ModelObject members = find(type, name);
    if (members.fields == nullptr || !members.fields->contains(list)) return;
    for (const auto& entry : members.fields->at(list)) each(ModelObject{"", "", &entry}.text(field));
  };
  const auto zone_of_space = [&](const std::string& space) {
    const std::string zone = find("Space", space).text("zone_name");
    if (!zone.empty()) zones.insert(engine_case(zone));
  };
  if (object("Zone", name)) zones.insert(engine_case(name));
  if (object("Space", name)) zone_of_space(name);
  add_members("ZoneList", "zones", "zone_name", [&](const std::string& zone) { zones.insert(engine_case(zone)); });
  add_members("SpaceList", "spaces", "space_name", zone_of_space);
  return zones;
}

void ModelIndex::gather_texts(const nlohmann::json& value) {
  if (value.is_string()) texts_.insert(engine_case(value.get<std::string>()));
  if (!value.is_structured()) return;
  for (const auto& part : value) gather_texts(part);
}

}  // namespace airside::sim
