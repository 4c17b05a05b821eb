#include "tools/cli/site/check_twin.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <nlohmann/json.hpp>

#include "sim/energyplus/epjson_lint.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/energyplus/options.hpp"
#include "sim/energyplus/weather.hpp"
#include "sim/json/json_file.hpp"
#include "sim/json/merge_patch.hpp"
#include "sim/weather/epw.hpp"

namespace airside::tools {

namespace {

using nlohmann::json;

constexpr std::size_t most_complaints = 20;

std::size_t objects_in(const json& model) {
  std::size_t n = 0;
  for (const auto& type : model) n += type.is_object() ? type.size() : 0;
  return n;
}

/// Notes all complaints but the last, which it throws.
void refuse_all(Findings& out, const std::string& what, const std::string& path,
                const std::vector<hal::InputError>& complaints) {
  if (complaints.empty()) return;
  const std::size_t shown = std::min(complaints.size(), most_complaints);
  for (std::size_t i = 0; i + 1 < shown; ++i) out.refuse(what, path, complaints[i]);
  throw complaints[shown - 1];
}

/// A model or patch against the engine's schema; what it says if there is no engine.
std::string lint(Findings& out, const std::string& what, const std::string& path, const json& model,
                 sim::LintScope scope) {
  if (!sim::have_energyplus()) return "not compared with the schema: EnergyPlus is not installed";
  refuse_all(out, what, path, sim::epjson_complaints(model, sim::find_energyplus().schema, {path, scope}));
  return "fits the schema";
}

/// Whether the composed model has what a run drives and reads.
std::string names_facts(Findings& out, const std::string& path, const json& model) {
  refuse_all(out, "twin", path, sim::missing_names(model, sim::ModelNames{}, path));
  return "all zones, schedules and nodes are there";
}

/// Whether the plant takes the site's shape.
void check_shape(Findings& out, const std::string& model_path, const hal::TopologyCounts& counts) {
  const sim::ModelNames names;
  if (counts.vavs == static_cast<int>(names.interior_zones.size()) &&
      counts.fcus == static_cast<int>(names.perimeter_zones.size()) && counts.powers == 2) {
    return;
  }
  out.refuse("twin", model_path,
             {model_path, "an epJSON twin of a site of topology " + counts.name, "5vav-5fcu-2power",
              "use model = \"rc\" for other shapes; the EnergyPlus twin is the method's room"});
}

}  // namespace

void check_twin(Findings& out, const std::string& model_path, const std::vector<std::string>& patch_paths,
                const hal::TopologyCounts& counts) {
  json model;
  const std::size_t failed_before = out.failed();
  if (!model_path.empty()) {
    check_shape(out, model_path, counts);
    out.check("twin", model_path, [&] {
      model = sim::read_model(model_path);
      const std::string result = lint(out, "twin", model_path, model, sim::LintScope::whole);
      return fmt::format("{} objects of {} types; {}", objects_in(model), model.size(), result);
    });
  }
  for (const std::string& path : patch_paths) {
    out.check("patch", path, [&] {
      const json patch = sim::read_json(path);
      json base = model.is_object() ? model : json::object();
      base = sim::merge_patched(std::move(base), patch, path);
      const std::string result = lint(out, "patch", path, patch, sim::LintScope::patch);
      if (model.is_object()) model = std::move(base);
      return fmt::format("{} objects of {} types changed; {}", objects_in(patch), patch.size(), result);
    });
  }
  if (model_path.empty() || out.failed() != failed_before) return;
  const std::string whole = patch_paths.empty() ? model_path : model_path + " with its patches";
  if (!patch_paths.empty()) {
    out.check("twin", whole, [&] {
      const std::string result = lint(out, "twin", whole, model, sim::LintScope::whole);
      return fmt::format("{} objects; {}", objects_in(model), result);
    });
  }
  out.check("twin", whole + ": names", [&] { return names_facts(out, whole, model); });
  if (!sim::have_energyplus()) {
    out.warn("twin", model_path, "it cannot run on this machine: EnergyPlus is not installed; run tools/setup");
  }
}

void check_weather(Findings& out, const std::string& path, bool for_engine) {
  out.check("weather", path, [&] {
    if (for_engine) (void)sim::read_epw_file(path, {.whole_year = true, .from = {}, .to = {}});
    const auto weather = sim::read_epw(path);
    const auto hours = weather->records().size() * static_cast<std::size_t>(weather->interval_s()) / 3600;
    return fmt::format("{} hours of {}{}", hours, weather->location().name,
                       weather->covers_year() ? ", a whole year" : "");
  });
}

}  // namespace airside::tools
