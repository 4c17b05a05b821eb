#include "tools/gap/case/case_format.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>

#include "hal/text/input_error.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/energyplus/rooms.hpp"
#include "sim/json/json_file.hpp"
#include "sim/json/merge_patch.hpp"
#include "tools/gap/map/mapped_model.hpp"
#include "tools/run/site.hpp"
#include "tools/run/twin_options.hpp"

namespace airside::tools::gap {

namespace {

namespace fs = std::filesystem;

constexpr int case_format = 1;

/// A built-in name stays as it is; a path is seen from the case's folder.
std::string resolved(const fs::path& folder, const std::string& text) {
  const bool is_path = text.find('/') != std::string::npos || fs::path(text).has_extension();
  return text.empty() || !is_path || fs::path(text).is_absolute() ? text : (folder / text).lexically_normal().string();
}

bool is_five_zone(const hal::TopologyCounts& counts) {
  return counts.vavs == 5 && counts.fcus == 5 && counts.powers == 2;
}

}  // namespace

CaseDescription read_case(const fs::path& folder) {
  const fs::path file = folder / "case.json";
  const nlohmann::json j = sim::read_json(file);
  const auto refuse = [&file](const std::string& key, const std::string& found, const std::string& expected) {
    throw hal::InputError(file.string() + ": " + key, found, expected,
                          "see docs/formats.md, \"Cases of the gap workflow\"");
  };
  if (!j.is_object()) refuse("", j.dump().substr(0, 40), "an object");
  static const std::vector<std::string> known{"format",   "engine",   "model",  "patches", "weather", "reference",
                                              "measured", "topology", "window", "duties",  "site",    "map"};
  for (const auto& [key, value] : j.items()) {
    if (std::find(known.begin(), known.end(), key) == known.end()) {
      refuse(key, "an unknown key", fmt::format("one of {}", fmt::join(known, ", ")));
    }
  }
  const auto text = [&](const char* key, const char* otherwise) {
    if (!j.contains(key) && otherwise != nullptr) return std::string(otherwise);
    if (!j.contains(key) || !j[key].is_string()) refuse(key, j.value(key, nlohmann::json()).dump(), "a text");
    return j[key].get<std::string>();
  };
  if (j.value("format", nlohmann::json()) != case_format) {
    refuse("format", j.value("format", nlohmann::json()).dump(), std::to_string(case_format));
  }
  CaseDescription c;
  c.engine = text("engine", nullptr);
  if (c.engine != "rc" && c.engine != "energyplus") refuse("engine", c.engine, "rc or energyplus");
  c.model = resolved(folder, text("model", nullptr));
  c.weather = resolved(folder, text("weather", nullptr));
  c.reference_log = resolved(folder, text("reference", nullptr));
  c.measured_log = resolved(folder, text("measured", nullptr));
  c.topology = text("topology", "5vav-5fcu-2power");
  c.window = text("window", "");
  c.site = resolved(folder, text("site", ""));
  c.map = resolved(folder, text("map", ""));
  if (j.contains("duties")) {
    if (!j["duties"].is_boolean()) refuse("duties", j["duties"].dump(), "true or false");
    c.duties = j["duties"].get<bool>();
  }
  if (j.contains("patches")) {
    if (!j["patches"].is_array()) refuse("patches", j["patches"].dump(), "a list of file names");
    for (const auto& patch : j["patches"]) {
      if (!patch.is_string()) refuse("patches", patch.dump(), "a file name");
      c.patches.push_back(resolved(folder, patch.get<std::string>()));
    }
  }
  return c;
}

void write_case(const fs::path& folder, const CaseDescription& c) {
  nlohmann::json j = {{"format", case_format},  {"engine", c.engine},           {"model", c.model},
                      {"weather", c.weather},   {"reference", c.reference_log}, {"measured", c.measured_log},
                      {"topology", c.topology}, {"window", c.window},           {"duties", c.duties}};
  if (!c.patches.empty()) j["patches"] = c.patches;
  if (!c.site.empty()) j["site"] = c.site;
  if (!c.map.empty()) j["map"] = c.map;
  std::ofstream out(folder / "case.json");
  out << j.dump(1) << '\n';
  if (!out) {
    throw hal::InputError((folder / "case.json").string(), "a file that cannot be written", "a writable folder",
                          "choose another");
  }
}

nlohmann::json model_of(const CaseDescription& c) {
  if (c.engine == "energyplus") {
    const sim::EnergyPlusOptions options = energyplus_options_of(c);
    const fs::path file = options.model.empty() ? sim::find_models() / "twin.epJSON" : options.model;
    nlohmann::json model = sim::read_json(file);
    for (const sim::ModelPatch& patch : options.patches) {
      model = sim::merge_patched(std::move(model), patch.content, patch.name);
    }
    return model;
  }
  if (c.model.ends_with(".json")) return sim::read_json(c.model);
  const hal::TopologyCounts counts = built_in_site(c.topology).counts;
  if (c.model != "rc" || is_five_zone(counts)) return {{"base", c.model}};
  return {{"base", "rc"}, {"vavs", counts.vavs}, {"fcus", counts.fcus}, {"powers", counts.powers}};
}

sim::EnergyPlusOptions energyplus_options_of(const CaseDescription& c) {
  if (!c.map.empty()) {
    sim::EnergyPlusOptions options = mapped_options(read_mapping(c.map), c.model);
    for (const std::string& patch : c.patches) options.patches.push_back({patch, sim::read_json(patch)});
    return options;
  }
  if (!c.site.empty()) {
    hal::TwinSection twin = load_site(c.site).file.twin.value_or(hal::TwinSection{});
    if (twin.control != hal::TwinControl::own || !twin.names) {
      throw hal::InputError(c.site + ": twin.control", "no model with controls of its own", "control = \"own\"",
                            "name the site that airside adopt wrote");
    }
    twin.model = c.model;
    twin.patches = c.patches;
    return twin_options(twin);
  }
  const bool file = c.model.ends_with(".epJSON");
  sim::EnergyPlusOptions options = file ? sim::EnergyPlusOptions{} : sim::energyplus_room(c.model);
  if (file) options.model = c.model;
  for (const std::string& patch : c.patches) options.patches.push_back({patch, sim::read_json(patch)});
  return options;
}

std::vector<fs::path> case_folders(const fs::path& folder) {
  std::vector<fs::path> folders;
  std::error_code failed;
  for (const auto& entry : fs::directory_iterator(folder, failed)) {
    if (fs::exists(entry.path() / "case.json")) folders.push_back(entry.path());
  }
  if (failed || folders.empty()) {
    throw hal::InputError(folder.string(), failed ? failed.message() : "no folder with a case.json",
                          "a folder of cases", "airside gap blind --cases 10 -o DIR makes one");
  }
  std::sort(folders.begin(), folders.end());
  return folders;
}

}  // namespace airside::tools::gap
