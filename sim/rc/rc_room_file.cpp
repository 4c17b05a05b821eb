#include "sim/rc/rc_room_file.hpp"

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "hal/text/input_error.hpp"
#include "hal/text/toml_section.hpp"
#include "sim/json/json_file.hpp"

namespace airside::sim {
namespace {

using Json = nlohmann::json;
constexpr int deepest_base = 8;

RcRoom parse(const std::string& text, const std::string& place, const std::string& name, int depth);

std::string joined(const std::vector<std::string>& words) {
  std::string text;
  for (const std::string& word : words) text += (text.empty() ? "" : ", ") + word;
  return text;
}

// JSON object without duplicate keys: the parser would silently keep the last.
Json parse_object(const std::string& text, const std::string& place) {
  std::set<std::string> seen;
  const auto refuse_duplicates = [&](int depth, Json::parse_event_t event, Json& parsed) {
    refuse_deep_json(depth, place);
    if (event == Json::parse_event_t::key && depth == 1 && !seen.insert(parsed.get<std::string>()).second) {
      throw hal::InputError(place + ": " + parsed.get<std::string>(), "the field twice", "each field once",
                            "remove one of the two");
    }
    return true;
  };
  Json json;
  try {
    json = Json::parse(text, refuse_duplicates);
  } catch (const Json::out_of_range& error) {
    refuse_json_number(error, place);
  } catch (const Json::parse_error& error) {
    const auto upto = text.begin() + static_cast<std::ptrdiff_t>(std::min(error.byte, text.size()));
    const auto line = 1 + std::count(text.begin(), upto, '\n');
    throw hal::InputError(place + ":" + std::to_string(line), "text that is no JSON", "a JSON object",
                          "check commas, quotes and braces there");
  }
  if (!json.is_object()) {
    throw hal::InputError(place, json.type_name(), "a JSON object", "write { \"base\": \"rc\", ... }");
  }
  return json;
}

template <class T>
T whole_number(const Json& json, const char* key, T otherwise, const std::string& place) {
  const auto found = json.find(key);
  if (found == json.end()) return otherwise;
  if (!found->is_number_unsigned() || found->template get<std::uint64_t>() > 1000000000) {
    throw hal::InputError(place + ": " + key, found->dump(), "a whole number from 0 to 1000000000",
                          "write such a number, without quotes");
  }
  return found->template get<T>();
}

double number(const Json& json, const std::string& place, std::string_view field) {
  if (json.is_number()) return json.get<double>();
  throw hal::InputError(place + ": " + std::string(field), json.dump(), "a number", "write it without quotes");
}

void set_field(RcRoom& room, const RoomField& field, const Json& value, const std::string& place) {
  if (const auto* scalar = std::get_if<ScalarField>(&field.member)) {
    room.*(*scalar) = number(value, place, field.name);
    return;
  }
  auto& list = room.*std::get<ListField>(field.member);
  if (!value.is_array()) {
    std::fill(list.begin(), list.end(), number(value, place, field.name));
    return;
  }
  list.clear();  // check_room compares the count
  for (const Json& item : value) list.push_back(number(item, place, field.name));
}

RcRoom load(const std::string& name, const std::string& asked_by, int depth) {
  if (name == "rc") return make_room();
  for (const EmbeddedRoom& room : embedded_rooms()) {
    if (room.name == name) return parse(std::string(room.json), "room " + name, name, depth);
  }
  const char* generated =
      depth == 0 ? ", study-0 .. study-199, tuning-0 .. tuning-199, modulating-humid, -mild, -reheat or -duct" : "";
  throw hal::InputError(asked_by, "room \"" + name + "\"", "one of " + joined(room_names()) + generated,
                        "choose one of these or give the path of a .json file");
}

RcRoom base_of(const Json& json, const std::string& place, int depth) {
  std::string base = "rc";
  if (const auto found = json.find("base"); found != json.end()) {
    if (!found->is_string()) {
      throw hal::InputError(place + ": base", found->dump(), "the name of a room",
                            "use one of " + joined(room_names()));
    }
    base = found->get<std::string>();
  }
  if (depth >= deepest_base) {
    throw hal::InputError(place + ": base", "a chain of more than 8 bases", "a chain that ends at \"rc\"",
                          "see whether two files name each other");
  }
  const bool has_counts = json.contains("vavs") || json.contains("fcus") || json.contains("powers");
  if (!has_counts) return load(base, place + ": base", depth + 1);
  if (base != "rc") {
    throw hal::InputError(place + ": vavs, fcus, powers", "counts on base \"" + base + "\"",
                          "counts on base \"rc\" only", "derive the room from \"rc\"");
  }
  const int vavs = whole_number(json, "vavs", 5, place);
  const int fcus = whole_number(json, "fcus", 5, place);
  const int powers = whole_number(json, "powers", 2, place);
  try {
    return make_room(vavs, fcus, powers);
  } catch (const hal::InputError& error) {
    throw hal::InputError(place + ": vavs, fcus, powers", error.found(), error.expected(), error.remedy());
  }
}

RcRoom parse(const std::string& text, const std::string& place, const std::string& name, int depth) {
  const Json json = parse_object(text, place);
  RcRoom room = base_of(json, place, depth);
  if (json.contains("perturb_seed")) {
    room = perturbed_room(room, whole_number<std::uint64_t>(json, "perturb_seed", 0, place));
  }
  room.name = name;
  room.seed = whole_number<std::uint64_t>(json, "seed", room.seed, place);
  static const std::set<std::string_view> not_fields = {"base", "about",  "seed",        "vavs",
                                                        "fcus", "powers", "perturb_seed"};
  for (const auto& [key, value] : json.items()) {
    if (not_fields.contains(key)) continue;
    const RoomField* field = find_room_field(key);
    if (field == nullptr) {
      std::vector<std::string> names;
      for (const RoomField& known : room_fields()) names.emplace_back(known.name);
      const std::string near = hal::nearest_name(key, names);
      throw hal::InputError(place + ": " + key, "an unknown field", "a field of an RC room",
                            near.empty() ? "check the spelling; names end in their unit (see sim/rc/rc_room.hpp)"
                                         : "did you mean `" + near + "`?");
    }
    set_field(room, *field, value, place);
  }
  check_room(room, place);
  return room;
}

}  // namespace

std::vector<std::string> room_names() {
  std::vector<std::string> names = {"rc"};
  for (const EmbeddedRoom& room : embedded_rooms()) names.emplace_back(room.name);
  return names;
}

RcRoom load_room(const std::string& name_or_path) {
  if (!name_or_path.ends_with(".json")) return load(name_or_path, "room", 0);
  std::ifstream file(name_or_path);
  std::stringstream text;
  if (file) text << file.rdbuf();
  if (!file) {
    throw hal::InputError(name_or_path, "no readable file", "a room file in JSON", "check the path");
  }
  const auto slash = name_or_path.find_last_of('/');
  const std::string leaf = slash == std::string::npos ? name_or_path : name_or_path.substr(slash + 1);
  return parse_room(text.str(), name_or_path, leaf.substr(0, leaf.size() - 5));
}

RcRoom parse_room(const std::string& json_text, const std::string& place, const std::string& name) {
  return parse(json_text, place, name, 0);
}

}  // namespace airside::sim
