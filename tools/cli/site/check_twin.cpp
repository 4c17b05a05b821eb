#include "tools/cli/site/check_twin.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <limits>
#include <nlohmann/json.hpp>

#include "airside/supervision/schedule.hpp"
#include "sim/energyplus/epjson_lint.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/energyplus/options.hpp"
#include "sim/energyplus/weather.hpp"
#include "sim/json/json_file.hpp"
#include "sim/json/merge_patch.hpp"
#include "sim/weather/epw.hpp"
#include "tools/adopt/adoption.hpp"
#include "tools/adopt/advice.hpp"
#include "tools/run/plant_choice.hpp"
#include "tools/run/twin_options.hpp"

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
std::string names_facts(Findings& out, const std::string& path, const json& model, const hal::TwinSection& twin) {
  if (twin.control == hal::TwinControl::external) {
    refuse_all(out, "twin", path, sim::missing_names(model, external_names(twin), path));
    return "all zones, schedules and nodes are there";
  }
  refuse_all(out, "twin", path, sim::missing_own_names(model, own_names(*twin.names), path));
  return fmt::format("its own controls; setpoint, nodes and {} zones are there (meters are known once it runs)",
                     twin.names->zones.size());
}

/// Whether the plant takes the site's shape.
void check_shape(Findings& out, const hal::TwinSection& twin, const hal::TopologyCounts& counts) {
  if (shape_fits(twin, counts)) return;
  out.refuse("twin", twin.model,
             {twin.model, "an epJSON twin of a site of topology " + counts.name, "5vav-5fcu-2power",
              "use model = \"rc\" for other shapes, or give the model's names in [twin.names]"});
}

}  // namespace

void check_twin(Findings& out, const hal::TwinSection& twin, const hal::TopologyCounts& counts) {
  json model;
  const std::size_t failed_before = out.failed();
  if (!twin.model.empty()) {
    check_shape(out, twin, counts);
    out.check("twin", twin.model, [&] {
      model = sim::read_model(twin.model);
      const std::string result = lint(out, "twin", twin.model, model, sim::LintScope::whole);
      return fmt::format("{} objects of {} types; {}", objects_in(model), model.size(), result);
    });
  }
  for (const std::string& path : twin.patches) {
    out.check("patch", path, [&] {
      const json patch = sim::read_json(path);
      json base = model.is_object() ? model : json::object();
      base = sim::merge_patched(std::move(base), patch, path);
      const std::string result = lint(out, "patch", path, patch, sim::LintScope::patch);
      if (model.is_object()) model = std::move(base);
      return fmt::format("{} objects of {} types changed; {}", objects_in(patch), patch.size(), result);
    });
  }
  if (twin.model.empty() || out.failed() != failed_before) return;
  const std::string whole = twin.patches.empty() ? twin.model : twin.model + " with its patches";
  if (!twin.patches.empty()) {
    out.check("twin", whole, [&] {
      const std::string result = lint(out, "twin", whole, model, sim::LintScope::whole);
      return fmt::format("{} objects; {}", objects_in(model), result);
    });
  }
  out.check("twin", whole + ": names", [&] { return names_facts(out, whole, model, twin); });
  if (!sim::have_energyplus()) {
    out.warn("twin", twin.model, "it cannot run on this machine: EnergyPlus is not installed; run tools/setup");
  }
}

bool is_foreign(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  try {
    if (ending == ".idf") return sim::have_energyplus() && std::filesystem::exists(path);
    const json model = sim::read_model(path);
    const sim::ModelNames own = external_names(hal::TwinSection{});
    // One of the project's own that lacks some names is broken, not somebody else's.
    return sim::have_energyplus() &&
           2 * sim::missing_names(model, own, path).size() > sim::missing_names(json::object(), own, path).size() &&
           sim::epjson_complaints(model, sim::find_energyplus().schema, {path, sim::LintScope::whole}).empty();
  } catch (const hal::InputError&) {
    return false;
  }
}

void check_foreign(Findings& out, const std::string& path, const std::string& air_loop, const std::string& weather) {
  out.check("adopt", path, [&] {
    const Adoption a = check_adoptable({path, air_loop, weather, {}, false, {}});
    std::string text = fmt::format("air loop \"{}\", {} zones, {} fan coils, terminals {}, objective {}, weather {}",
                                   a.loop.name, a.loop.terminals.size(), a.loop.fcu_zones.size(),
                                   text_of(a.loop.kind()), a.serves_band() ? "band" : "mean", a.weather_name);
    if (!a.upgrade.from.empty()) text += "\n       " + text_of(a.upgrade);
    for (const std::vector<std::string>* notes : {&a.notes, &a.loop.notes, &a.setpoint.notes}) {
      for (const std::string& note : *notes) text += "\n       " + note;
    }
    return text + "\n       It can be adopted, as far as is known before the engine runs: `airside adopt`";
  });
}

namespace {

/// The least and the most of what was seen.
struct Span {
  double low = std::numeric_limits<double>::infinity(), high = -std::numeric_limits<double>::infinity();
  void see(double value) {
    if (!std::isfinite(value)) return;
    low = std::min(low, value);
    high = std::max(high, value);
  }
  std::string text(const char* unit) const {
    return low > high ? std::string("none") : fmt::format("{:.1f} to {:.1f}{}", low, high, unit);
  }
};

}  // namespace

void try_twin(Findings& out, const Site& site) {
  PlantChoice choice;
  choice.twin = site.file.twin;
  choice.site_twin = site.file.path;
  choice.room = "twin";
  choice.kind = "energyplus";
  choice.model = site.file.twin->model;
  choice.patches = site.file.twin->patches;
  choice.weather = site.file.twin->weather;
  out.check("twin", choice.model + ": a day", [&] {
    const auto plant = make_plant(choice, site, 1);
    Span rooms, dampers, powers, flow, off;
    int hours_on = 0;
    const CivilTime from = plant->time();
    for (int hour = 1; hour <= 24; ++hour) {
      plant->set_setpoint(expert_setpoint_degc(site.settings, plant->time()));
      plant->advance_to({from.seconds + hour * std::int64_t{3600}});
      const sim::Sensors& s = plant->sensors();
      for (const double room : s.room_temp_degc) rooms.see(room);
      for (const double damper : s.damper) dampers.see(damper);
      for (const double power : s.power_kw) powers.see(power);
      flow.see(s.supply_flow_m3s);
      const bool runs = std::isnan(s.ahu_on) || s.ahu_on > 0.5;
      hours_on += runs ? 1 : 0;
      if (runs) off.see(std::abs(s.supply_temp_degc - s.setpoint_degc));
    }
    return fmt::format("rooms {}, supply {} off its setpoint, flow {}, dampers {}, meters {}, fan on in {} of 24 h",
                       rooms.text(" degC"), off.text(" K"), flow.text(" m3/s"), dampers.text(""), powers.text(" kW"),
                       hours_on);
  });
  // An adopted site's page knows more than a day shows; who deletes the page does not want it.
  const std::filesystem::path page = std::filesystem::path(site.file.path).parent_path() / "adopt.md";
  const std::string advice = advice_of_page(page);
  if (!advice.empty()) out.check("advice", page.string(), [&advice]() -> const std::string& { return advice; });
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
