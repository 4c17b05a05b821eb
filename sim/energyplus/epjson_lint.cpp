#include "sim/energyplus/epjson_lint.hpp"

#include <algorithm>
#include <cctype>
#include <map>
#include <mutex>
#include <numeric>
#include <utility>

#include "sim/json/json_file.hpp"
#include "sim/json/json_members.hpp"

namespace airside::sim {
namespace {

using nlohmann::json;

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(),
                 [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

/// Levenshtein distance, letters compared without case.
std::size_t distance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = std::exchange(row[0], i);
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] == b[j - 1] ? 0 : 1);
      diagonal = std::exchange(row[j], std::min({replaced, row[j] + 1, row[j - 1] + 1}));
    }
  }
  return row[b.size()];
}

/// "write 'X'" for the nearest known name, or the given advice when none is near.
std::string nearest(const std::string& found, const std::vector<std::string>& known, const std::string& otherwise) {
  std::string best;
  std::size_t least = std::max<std::size_t>(2, found.size() / 3) + 1;
  for (const auto& name : known) {
    const std::size_t d = distance(upper(found), upper(name));
    if (d < least) {
      least = d;
      best = name;
    }
  }
  return best.empty() ? otherwise : "write '" + best + "'";
}

std::vector<std::string> keys_of(const json& object) {
  std::vector<std::string> keys;
  for (const auto& [key, value] : object.items()) keys.push_back(key);
  return keys;
}

std::string shown(const json& value) {
  std::string text = value.dump(-1, ' ', false, json::error_handler_t::replace);
  return text.size() > 60 ? text.substr(0, 57) + "..." : text;
}

/// The engine's schema, 10 MB of 850 object types. A model has some sixty: the others are never parsed.
class EngineSchema {
 public:
  explicit EngineSchema(const std::filesystem::path& file) : place_(file.string()), text_(json_text(file)) {
    for (const JsonMember& part : json_members(text_, place_)) {
      if (part.key != "properties") continue;
      for (const JsonMember& type : json_members(part.value, place_)) {
        const std::string name(type.key);
        types_.emplace(name, type.value);
        gather_lists(name, type.value);
      }
    }
    if (types_.empty())
      throw hal::InputError(place_ + ": properties", "no object types", "the engine's schema", "install it again");
  }

  bool has(const std::string& type) const { return types_.contains(type); }
  const json& at(const std::string& type) const {
    const std::lock_guard lock(guard_);
    auto found = parsed_.find(type);
    if (found == parsed_.end())
      found = parsed_.emplace(type, parse_json(std::string(types_.at(type)), place_ + ": " + type)).first;
    return found->second;
  }
  std::vector<std::string> names() const {
    std::vector<std::string> all;
    for (const auto& [type, text] : types_) all.push_back(type);
    return all;
  }
  /// Every list that objects of some type stand in by their name, such as ZoneNames.
  const std::vector<std::string>& name_lists() const { return lists_; }

 private:
  void gather_lists(const std::string& type, std::string_view text) {
    for (const JsonMember& member : json_members(text, place_ + ": " + type)) {
      if (member.key != "name") continue;
      const json name = parse_json(std::string(member.value), place_ + ": " + type + " / name");
      if (!name.contains("reference")) continue;
      for (const auto& list : name["reference"]) lists_.push_back(list);
    }
  }

  std::string place_, text_;
  std::map<std::string, std::string_view> types_;
  std::vector<std::string> lists_;
  mutable std::mutex guard_;
  mutable std::map<std::string, json> parsed_;
};

class Linter {
 public:
  Linter(const EngineSchema& schema, const LintTarget& target) : types_(schema), target_(target) {}

  std::vector<hal::InputError> run(const json& model) {
    if (!model.is_object()) {
      complain("", model.type_name(), "a JSON object of object types", "start with { and an object type");
      return std::move(complaints_);
    }
    if (whole()) gather_names(model);
    for (const auto& [type, objects] : model.items()) check_type(type, objects);
    if (whole()) {
      for (const char* type : {"Building", "GlobalGeometryRules", "Version", "RunPeriod", "Timestep"}) {
        if (!model.contains(type)) complain(type, "no such object", "one", "add it: the model cannot run");
      }
    }
    return std::move(complaints_);
  }

 private:
  bool whole() const { return target_.scope == LintScope::whole; }

  void complain(const std::string& where, const std::string& found, const std::string& expected,
                const std::string& remedy) {
    complaints_.emplace_back(target_.place + (where.empty() ? "" : ": " + where), found, expected, remedy);
  }

  static const json& object_schema(const json& type) { return type.at("patternProperties").begin().value(); }

  /// Which names each list of the schema (ScheduleNames, ZoneNames ...) holds in this model.
  void gather_names(const json& model) {
    for (const std::string& list : types_.name_lists()) known_lists_.try_emplace(list);
    for (const auto& [type, objects] : model.items()) {
      if (!types_.has(type) || !objects.is_object()) continue;
      const json& description = types_.at(type);
      for (const auto& [name, fields] : objects.items()) {
        if (description.contains("name") && description["name"].contains("reference")) {
          for (const auto& list : description["name"]["reference"]) known_lists_[list].emplace(upper(name), name);
        }
        gather_field_names(object_schema(description), fields);
      }
    }
  }

  void gather_field_names(const json& schema, const json& fields) {
    if (!fields.is_object() || !schema.contains("properties")) return;
    for (const auto& [field, description] : schema["properties"].items()) {
      if (!description.contains("reference") || !fields.contains(field) || !fields[field].is_string()) continue;
      for (const auto& list : description["reference"]) known_lists_[list].emplace(upper(fields[field]), fields[field]);
    }
  }

  void check_type(const std::string& type, const json& objects) {
    if (!types_.has(type)) {
      complain(type, "an object type that EnergyPlus does not know", "an object type of Energy+.schema.epJSON",
               nearest(type, types_.names(), "see the engine's schema for the types"));
      return;
    }
    if (objects.is_null() && !whole()) return;
    if (!objects.is_object()) {
      complain(type, shown(objects), "named objects, { \"NAME\": { fields } }", "wrap the fields in a name");
      return;
    }
    for (const auto& [name, fields] : objects.items()) {
      if (fields.is_null() && !whole()) continue;
      check_fields(type + " / " + name, object_schema(types_.at(type)), fields);
    }
  }

  void check_fields(const std::string& where, const json& schema, const json& fields) {
    if (!fields.is_object()) {
      complain(where, shown(fields), "an object of fields", "write { \"field\": value }");
      return;
    }
    static const json none = json::object();
    const json& known = schema.contains("properties") ? schema["properties"] : none;
    for (const auto& [field, value] : fields.items()) {
      if (field.starts_with("idf_")) continue;  // marks that the engine's converter leaves
      if (!known.contains(field)) {
        complain(where + " / " + field, "a field that EnergyPlus does not know and would silently ignore",
                 "a field of that object", nearest(field, keys_of(known), "remove it, or see the schema"));
        continue;
      }
      if (value.is_null() && !whole()) continue;
      check_value(where + " / " + field, known[field], value);
    }
    if (!whole() || !schema.contains("required")) return;
    for (const auto& field : schema["required"]) {
      if (!fields.contains(field)) {
        complain(where, "no field '" + field.get<std::string>() + "'", "it, since the object requires it",
                 "add the field");
      }
    }
  }

  void check_value(const std::string& where, const json& schema, const json& value) {
    if (schema.contains("anyOf")) {
      // Numbers with choices such as Autosize: the branch of the value's own kind tells most.
      const json* near = nullptr;
      for (const auto& option : schema["anyOf"]) {
        if (of_type(option, value)) near = &option;
        if (fits(option, value)) return;
      }
      if (near != nullptr) {
        check_plain(where, *near, value);
      } else {
        complain(where, shown(value), describe(schema), "correct the value");
      }
      return;
    }
    if (schema.value("type", "") == "array" && value.is_array()) {
      for (std::size_t i = 0; i < value.size(); ++i)
        check_fields(where + "[" + std::to_string(i) + "]", schema["items"], value[i]);
      return;
    }
    check_plain(where, schema, value);
    check_reference(where, schema, value);
  }

  void check_plain(const std::string& where, const json& schema, const json& value) {
    if (fits(schema, value)) return;
    std::string remedy = "correct the value";
    if (schema.contains("enum") && value.is_string()) {
      std::vector<std::string> choices;
      for (const auto& choice : schema["enum"]) {
        if (choice.is_string() && !choice.get<std::string>().empty()) choices.push_back(choice);
      }
      remedy = nearest(value, choices, "choose one of them");
    }
    complain(where, shown(value), describe(schema), remedy);
  }

  void check_reference(const std::string& where, const json& schema, const json& value) {
    if (!whole() || !value.is_string() || value.get<std::string>().empty() || !schema.contains("object_list")) return;
    std::vector<std::string> candidates;
    for (const auto& list : schema["object_list"]) {
      const auto names = known_lists_.find(list);
      if (names == known_lists_.end()) return;  // a list of object types, not of this model's names
      if (names->second.contains(upper(value))) return;
      for (const auto& [key, name] : names->second) candidates.push_back(name);
    }
    complain(where, "the name " + shown(value) + ", which no object has",
             "the name of an object (" + schema["object_list"].front().get<std::string>() + ")",
             nearest(value, candidates, "add that object or correct the name"));
  }

  static bool of_type(const json& schema, const json& value) {
    const std::string type = schema.value("type", "");
    if (type == "number") return value.is_number();
    if (type == "integer")
      return value.is_number_integer() || (value.is_number() && value == value.get<std::int64_t>());
    if (type == "string") return value.is_string();
    if (type == "array") return value.is_array();
    return true;
  }

  static bool fits(const json& schema, const json& value) {
    if (!of_type(schema, value)) return false;
    if (schema.contains("enum")) {
      const auto same = [&value](const json& choice) {
        return choice == value || (choice.is_string() && value.is_string() &&
                                   upper(choice.get<std::string>()) == upper(value.get<std::string>()));
      };
      if (std::none_of(schema["enum"].begin(), schema["enum"].end(), same)) return false;
    }
    if (!value.is_number()) return true;
    const double number = value.get<double>();
    if (schema.contains("minimum") && number < schema["minimum"].get<double>()) return false;
    if (schema.contains("maximum") && number > schema["maximum"].get<double>()) return false;
    if (schema.contains("exclusiveMinimum") && number <= schema["exclusiveMinimum"].get<double>()) return false;
    if (schema.contains("exclusiveMaximum") && number >= schema["exclusiveMaximum"].get<double>()) return false;
    return true;
  }

  static std::string describe(const json& schema) {
    if (schema.contains("anyOf")) {
      std::string text;
      for (const auto& option : schema["anyOf"]) text += (text.empty() ? "" : ", or ") + describe(option);
      return text;
    }
    if (schema.contains("enum")) {
      std::string text = "one of ";
      for (const auto& choice : schema["enum"]) {
        if (choice != "")
          text += (text.size() > 7 ? ", " : "") + (choice.is_string() ? choice.get<std::string>() : choice.dump());
      }
      return text;
    }
    const std::string type = schema.value("type", "value");
    std::string text = (type == "integer" || type == "array" ? "an " : "a ") + type;
    if (schema.contains("minimum")) text += " of at least " + schema["minimum"].dump();
    if (schema.contains("exclusiveMinimum")) text += " above " + schema["exclusiveMinimum"].dump();
    if (schema.contains("maximum")) text += " of at most " + schema["maximum"].dump();
    if (schema.contains("exclusiveMaximum")) text += " below " + schema["exclusiveMaximum"].dump();
    return text;
  }

  const EngineSchema& types_;
  const LintTarget& target_;
  std::vector<hal::InputError> complaints_;
  std::map<std::string, std::map<std::string, std::string>> known_lists_;  // list: upper case to name
};

/// Each is read once.
const EngineSchema& schema_of(const std::filesystem::path& file) {
  static std::mutex guard;
  static std::map<std::filesystem::path, EngineSchema> read;
  const std::lock_guard lock(guard);
  auto found = read.find(file);
  if (found == read.end()) found = read.try_emplace(file, file).first;
  return found->second;
}

}  // namespace

std::vector<hal::InputError> epjson_complaints(const json& model, const std::filesystem::path& schema,
                                               const LintTarget& target) {
  return Linter(schema_of(schema), target).run(model);
}

void lint_epjson(const json& model, const std::filesystem::path& schema, const LintTarget& target) {
  const auto complaints = epjson_complaints(model, schema, target);
  if (complaints.empty()) return;
  const hal::InputError& first = complaints.front();
  const std::size_t others = complaints.size() - 1;
  throw hal::InputError(first.place(), first.found(), first.expected(),
                        first.remedy() + (others == 0 ? "" : "; and " + std::to_string(others) + " more like it"));
}

}  // namespace airside::sim
