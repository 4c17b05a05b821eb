#pragma once
// An object of an effect file, read key by key; what nobody asked for is an error.

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "hal/text/input_error.hpp"

namespace airside::sim {

template <class Map>
std::string keys_of(const Map& map) {
  std::string text;
  for (const auto& [key, value] : map) text += (text.empty() ? "" : ", ") + key;
  return text;
}

/// `place` names it in complaints. Errors: hal::InputError.
class EffectSection {
 public:
  EffectSection(const nlohmann::json& json, std::string place) : json_(json), place_(std::move(place)) {
    if (!json.is_object()) refuse("", json.dump(), "an object");
  }
  bool has(const char* key) {
    asked_.push_back(key);
    return json_.contains(key) && !json_[key].is_null();
  }
  bool is_null(const char* key) { return json_.contains(key) && json_[key].is_null(); }
  std::string text(const char* key, const std::string& otherwise) {
    if (!has(key)) return otherwise;
    if (!json_[key].is_string()) refuse(key, json_[key].dump(), "a text");
    return json_[key].get<std::string>();
  }
  std::string text(const char* key) {
    if (!has(key)) refuse(key, "nothing", "a text");
    return text(key, "");
  }
  double number(const char* key, double otherwise) {
    if (!has(key)) return otherwise;
    if (!json_[key].is_number()) refuse(key, json_[key].dump(), "a number");
    return json_[key].get<double>();
  }
  double number(const char* key) {
    if (!has(key)) refuse(key, "nothing", "a number");
    return number(key, 0);
  }
  bool flag(const char* key, bool otherwise) {
    if (!has(key)) return otherwise;
    if (!json_[key].is_boolean()) refuse(key, json_[key].dump(), "true or false");
    return json_[key].get<bool>();
  }
  template <class Map>
  typename Map::mapped_type choice(const char* key, const Map& map, typename Map::mapped_type otherwise) {
    if (!has(key)) return otherwise;
    const auto found = map.find(text(key));
    if (found == map.end()) refuse(key, json_[key].dump(), "one of " + keys_of(map));
    return found->second;
  }
  const nlohmann::json& at(const char* key) const { return json_[key]; }
  const std::string& place() const { return place_; }
  void nothing_else() const {
    for (const auto& [key, value] : json_.items()) {
      if (std::find(asked_.begin(), asked_.end(), key) == asked_.end()) {
        std::string known;
        for (const auto& one : asked_) known += (known.empty() ? "" : ", ") + one;
        refuse(key, "an unknown key", "one of " + known);
      }
    }
  }
  [[noreturn]] void refuse(const std::string& key, const std::string& found, const std::string& expected) const {
    throw hal::InputError(place_ + (key.empty() ? "" : ": " + key), found, expected, "correct the effect's file");
  }

 private:
  const nlohmann::json& json_;
  std::string place_;
  std::vector<std::string> asked_;
};

}  // namespace airside::sim
