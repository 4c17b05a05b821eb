#include "tools/adopt/sizes.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <map>
#include <sstream>

#include "hal/text/text_file.hpp"
#include "sim/energyplus/epjson_lint.hpp"

namespace airside::tools {

namespace {

using nlohmann::json;

std::string trimmed(const std::string& text) {
  const auto first = text.find_first_not_of(" \t\r");
  if (first == std::string::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t\r") - first + 1);
}

/// "Design Size Maximum Air Flow Rate [m3/s]" as the field maximum_air_flow_rate.
std::string field_of(std::string description) {
  description = trimmed(description.substr(0, description.find('[')));
  std::string lower;
  for (const char c : engine_upper(description))
    lower += c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c == ' ' || c == '-' ? '_' : c;
  constexpr std::string_view prefix = "design_size_";
  return lower.starts_with(prefix) ? lower.substr(prefix.size()) : lower;
}

/// "TYPE,NAME,field" to the size.
std::map<std::string, double> reported_sizes(const std::filesystem::path& eio) {
  std::istringstream lines(hal::read_text_file(eio.string(), "the engine's report of sizes"));
  std::map<std::string, double> out;
  for (std::string line; std::getline(lines, line);) {
    if (line.find("Component Sizing Information,") == std::string::npos) continue;
    std::vector<std::string> cells;
    std::istringstream parts(line);
    for (std::string cell; std::getline(parts, cell, ',');) cells.push_back(trimmed(cell));
    if (cells.size() < 5) continue;
    double value = 0;
    const std::string& number = cells.back();
    if (std::from_chars(number.data(), number.data() + number.size(), value).ec != std::errc()) continue;
    if (!std::isfinite(value) || value < 0) continue;
    out[engine_upper(cells[1]) + "," + engine_upper(cells[2]) + "," + field_of(cells[3])] = value;
  }
  return out;
}

/// Objects of rules for sizing, and heat rejection, whose rounded sizes the engine finds at odds with each other.
bool keeps_autosize(const std::string& type) {
  for (const char* kept :
       {"Sizing:", "DesignSpecification:", "FluidCooler:", "EvaporativeFluidCooler:", "CoolingTower:"}) {
    if (type.starts_with(kept)) return true;
  }
  return false;
}

/// With a UA written hard the engine takes a water coil's largest air flow for its design flow: behind a fan whose flow
/// modulates a heating coil then gave 164 kW where it has 302. Boxes tell the engine their own flow.
bool keeps_autosize(const ModelView& model, const ModelObject& object, const std::string& field) {
  if (!same_name(object.type, "Coil:Heating:Water") || field != "u_factor_times_area_value") return false;
  for (const ModelObject& box : model.all_of("AirTerminal:")) {
    if (same_name(box.text("reheat_coil_name"), object.name)) return false;
  }
  return true;
}

bool is_autosize(const json& value) { return value.is_string() && same_name(value.get<std::string>(), "Autosize"); }

}  // namespace

FoundSizes sizes_of_run(const ModelView& model, const std::filesystem::path& eio, const std::filesystem::path& schema) {
  const auto sizes = reported_sizes(eio);
  FoundSizes out;
  for (const ModelObject& object : model.all_of("")) {
    if (keeps_autosize(object.type)) continue;
    json fields = json::object();
    for (const auto& [field, value] : object.fields->items()) {
      if (!is_autosize(value)) continue;
      if (keeps_autosize(model, object, field)) {
        ++out.open;
        continue;
      }
      const auto size = sizes.find(engine_upper(object.type) + "," + engine_upper(object.name) + "," + field);
      if (size == sizes.end()) {
        ++out.open;
        continue;
      }
      json candidate = {{object.type, {{object.name, {{field, size->second}}}}}};
      if (!sim::epjson_complaints(candidate, schema, {model.place(), sim::LintScope::patch}).empty()) {
        ++out.open;  // a field that must be above zero, say, for equipment of no size
        continue;
      }
      fields[field] = size->second;
      ++out.written;
    }
    if (!fields.empty()) out.patch[object.type][object.name] = std::move(fields);
  }
  return out;
}

}  // namespace airside::tools
