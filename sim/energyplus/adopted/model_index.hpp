#pragma once
// The names in a model, compared as the engine does: without case.

#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace airside::sim {

/// A name as the engine compares it.
std::string engine_case(std::string text);

/// One object of a model; the model must outlive it.
struct ModelObject {
  std::string type, name;
  const nlohmann::json* fields = nullptr;
  /// A field's text; empty where it has none.
  std::string text(const char* field) const;
};

class ModelIndex {
 public:
  /// The model must outlive the index.
  explicit ModelIndex(const nlohmann::json& model);

  bool object(const std::string& type, const std::string& name) const;
  /// Whether any field has this text.
  bool text(const std::string& value) const { return texts_.contains(engine_case(value)); }

  /// Objects of a type, or of all that begin so where it ends in a colon, as "AirTerminal:"; all objects of "".
  std::vector<ModelObject> of_type(std::string_view type) const;
  /// The object of this name among them; `fields` is null where there is none.
  ModelObject find(std::string_view type, const std::string& name) const;
  std::vector<std::string> names_of(std::string_view type) const;
  /// The zones that a name of a zone, zone list, space or space list stands for, as engine_case() has them.
  std::set<std::string> zones_behind(const std::string& name) const;
  /// Every text of a field that names a node.
  std::vector<std::string> nodes() const;

 private:
  void gather_texts(const nlohmann::json& value);

  const nlohmann::json& model_;
  std::set<std::pair<std::string, std::string>> objects_;
  std::set<std::string> texts_;
};

}  // namespace airside::sim
