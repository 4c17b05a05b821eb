#pragma once
// A foreign EnergyPlus model by its objects and names, compared as the engine does: without case.

#include <map>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace airside::tools {

/// One object of a model; empty where a search found none.
struct ModelObject {
  std::string type, name;
  const nlohmann::json* fields = nullptr;

  explicit operator bool() const { return fields != nullptr; }
  /// A text field, "" where it is absent or of another kind.
  std::string text(const char* field) const;
  /// The text `key` of each element of an array field; elements without it are left out.
  std::vector<std::string> texts(const char* array, const char* key) const;
};

/// Upper case of ASCII letters alone, as the engine does it.
std::string engine_upper(std::string text);
bool same_name(const std::string& a, const std::string& b);

class ModelView {
 public:
  /// Keeps a reference to `model`. `place` names the model in complaints.
  /// Errors: hal::InputError where it is not an object of object types, each with named objects, or has two objects of
  ///   one type whose names differ in case alone.
  ModelView(const nlohmann::json& model, std::string place);

  const nlohmann::json& content() const { return model_; }
  const std::string& place() const { return place_; }
  /// "MODEL: Type / Name / field".
  std::string place_of(const ModelObject& object, const std::string& field = {}) const;

  ModelObject find(const std::string& type, const std::string& name) const;
  /// The object that a field of `by` names.
  /// Errors: hal::InputError for an empty field, or a name that no such object has.
  ModelObject need(const std::string& type, const ModelObject& by, const std::string& field,
                   const std::string& name) const;
  std::vector<ModelObject> all(const std::string& type) const;
  /// Objects of every type that begins so.
  std::vector<ModelObject> all_of(const std::string& prefix) const;
  /// The nodes behind a name that may be a NodeList; else the name itself.
  std::vector<std::string> nodes(const std::string& node_or_list) const;
  /// `base`, or with a number behind it where an object of the type has that name.
  std::string free_name(const std::string& type, const std::string& base) const;

 private:
  const nlohmann::json& model_;
  std::string place_;
  std::map<std::string, std::map<std::string, ModelObject>> objects_;  ///< type and name, both in upper case
};

}  // namespace airside::tools
