#include "tools/adopt/model/foreign_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <regex>

#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"
#include "sim/energyplus/process.hpp"
#include "sim/json/json_file.hpp"
#include "tools/adopt/model/engine_run.hpp"
#include "tools/adopt/model/model_view.hpp"
#include "tools/adopt/model/transitions.hpp"
#include "tools/adopt/upgrade/table/idf_text.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Whether a model must be upgraded.
/// Errors: hal::InputError where it has no version, is newer than the engine, or too old for the tables and nothing
///   else can upgrade it.
bool must_be_upgraded(const std::string& place, const std::string& found, const std::string& engine, bool programs) {
  if (found == engine) return false;
  if (found.empty()) {
    throw hal::InputError(place + ": Version", "no version", "one of EnergyPlus " + engine,
                          "add the object Version with the version that the model was written for");
  }
  const std::string expected = fmt::format("one of EnergyPlus {} to {}", oldest_version(), engine);
  if (is_older(engine, found)) {
    throw hal::InputError(place + ": Version", "a model of EnergyPlus " + found + ", newer than the engine", expected,
                          "save it for " + engine + " in the program that wrote it: no program takes a model back");
  }
  if (!programs && !tables_lead(found, engine)) {
    throw hal::InputError(place + ": Version", "a model of EnergyPlus " + found, expected,
                          "name a folder of EnergyPlus's Transition programs with --transitions, as an EnergyPlus " +
                              engine + " install has it in PreProcess/IDFVersionUpdater, and give the IDF");
  }
  return true;
}

/// The text without comments, in upper case: enough to look for object types.
std::string without_comments(const std::string& idf) {
  std::string out;
  out.reserve(idf.size());
  bool comment = false;
  for (const char c : idf) {
    if (c == '!') comment = true;
    if (c == '\n') comment = false;
    if (!comment) out += c;
  }
  return engine_upper(std::move(out));
}

std::string idf_version(const std::string& bare) {
  static const std::regex version(R"((?:^|[;\s])VERSION\s*,\s*([0-9][0-9.]*)\s*;)");
  std::smatch found;
  return std::regex_search(bare, found, version) ? found[1].str() : std::string();
}

void write_whole(const fs::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  if (!(out << text) || !out.flush()) {
    throw hal::InputError(file.string(), "a file that cannot be written", "room in TMPDIR", "name another in TMPDIR");
  }
}

/// in.idf of `folder` with its HVACTemplate objects replaced by what they stand for.
void expand_templates(const fs::path& folder, const sim::EnergyPlusInstall& install, const std::string& place) {
  fs::copy_file(install.folder / "Energy+.idd", folder / "Energy+.idd");
  const EngineRun run = run_engine_program(install.folder / "ExpandObjects", {}, folder, 120);
  const fs::path expanded = folder / "expanded.idf";
  if (!run.done || !fs::is_regular_file(expanded) || fs::file_size(expanded) == 0) {
    throw hal::InputError(place + ": HVACTemplate", "objects that ExpandObjects does not take" + run.words,
                          "templates that the engine's ExpandObjects replaces", "correct them as the engine says");
  }
  fs::rename(expanded, folder / "in.idf");
}

/// Managers of EMS programs with the same calling point run in the order of the IDF, and an epJSON has its objects by
/// name: their names, which nothing refers to, get a number where the two orders differ.
void keep_calling_order(json& model, const std::string& text, const std::string& place,
                        std::vector<std::string>& notes) {
  constexpr const char* type = "EnergyManagementSystem:ProgramCallingManager";
  const auto managers = model.find(type);
  if (managers == model.end() || managers->size() < 2) return;
  upgrade::IdfText idf = upgrade::parse_idf(text, place);
  std::vector<std::string> order;
  for (const upgrade::IdfObject* manager : idf.all(type)) order.push_back(manager->name());
  if (order.size() != managers->size() || std::ranges::is_sorted(order)) return;
  json numbered = json::object();
  for (const auto& manager : managers->items()) {
    const auto at = std::ranges::find_if(order, [&](const std::string& o) { return same_name(o, manager.key()); });
    numbered[fmt::format("{:03} {}", at - order.begin() + 1, manager.key())] = manager.value();
  }
  *managers = std::move(numbered);
  notes.emplace_back("EMS calling managers have a number before their names, so that they run in the IDF's order");
}

json converted(const fs::path& file, std::string text, const sim::EnergyPlusInstall& install,
               const std::string& transitions, ForeignModel& model) {
  const std::string bare = without_comments(text);
  const std::string place = file.string();
  const std::string engine = short_version(sim::version_of(install));
  if (bare.find(',') == std::string::npos || bare.find(';') == std::string::npos) {
    throw hal::InputError(place, "text that is neither JSON nor an IDF", "an EnergyPlus model, .idf or .epJSON",
                          "see that this is the right file");
  }
  const std::string version = short_version(idf_version(bare));
  const fs::path programs = version == engine ? fs::path() : transitions_folder(transitions, install.folder);
  if (must_be_upgraded(place, version, engine, !programs.empty())) {
    text = programs.empty() ? upgraded_idf(text, place, version, engine, model.upgrade)
                            : transitioned_idf(text, place, version, engine, programs, model.upgrade);
    const std::string reached = short_version(idf_version(without_comments(text)));
    if (reached != engine) {
      throw hal::InputError(programs.string(), "Transition programs that ended with a model of \"" + reached + "\"",
                            "one of EnergyPlus " + engine, "look at the folder, or leave it out");
    }
  }
  const sim::RunFolder folder;
  write_whole(folder.path() / "in.idf", text);
  if (bare.find("HVACTEMPLATE:") != std::string::npos) {
    expand_templates(folder.path(), install, place);
    model.notes.emplace_back("its HVACTemplate objects were replaced by the engine's ExpandObjects");
  }
  const EngineRun run = run_engine_program(
      install.folder / "energyplus", {"--convert-only", "-d", folder.path().string(), "in.idf"}, folder.path(), 300);
  const fs::path made = folder.path() / "in.epJSON";
  if (!run.done || !fs::is_regular_file(made)) {
    throw hal::InputError(place, "an IDF that the engine's converter refuses: it " + run.words,
                          "an IDF of EnergyPlus " + (version.empty() ? engine : version),
                          "correct it as the engine says");
  }
  model.notes.emplace_back("converted from IDF by the engine's own `energyplus --convert-only`");
  json content = sim::read_json(made);
  keep_calling_order(content, text, place, model.notes);
  return content;
}

/// Fields that name a file beside the model.
constexpr const char* file_fields[] = {"file_name", "external_file_name", "representation_file_name"};

/// Named files by their whole path: a run has a folder of its own.
void find_files(json& model, const fs::path& file) {
  for (auto& [type, objects] : model.items()) {
    if (!objects.is_object()) continue;
    for (auto& [name, fields] : objects.items()) {
      if (!fields.is_object()) continue;
      for (const char* field : file_fields) {
        const auto at = fields.find(field);
        if (at == fields.end() || !at->is_string() || at->get<std::string>().empty()) continue;
        const fs::path named = at->get<std::string>();
        const fs::path whole =
            fs::absolute(named.is_absolute() ? named : file.parent_path() / named).lexically_normal();
        if (!fs::is_regular_file(whole)) {
          throw hal::InputError(fmt::format("{}: {} / {} / {}", file.string(), type, name, field),
                                "the file \"" + named.string() + "\", which is not there",
                                "a file beside the model, or its whole path", "copy it there, or correct the name");
        }
        *at = whole.string();
      }
    }
  }
}

}  // namespace

ForeignModel read_foreign_model(const fs::path& file, const sim::EnergyPlusInstall& install,
                                const std::string& transitions) {
  const std::string text = hal::read_text_file(file.string(), "an EnergyPlus model, .idf or .epJSON");
  const std::string place = file.string();
  const auto first = text.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
  if (first == std::string::npos) {
    throw hal::InputError(place, "an empty file", "an EnergyPlus model, .idf or .epJSON", "see that the copy is whole");
  }
  const std::string ending = engine_upper(file.extension().string());
  ForeignModel model;
  if (text[first] == '{' || text[first] == '[' || ending == ".EPJSON" || ending == ".JSON") {
    model.content = sim::parse_json(text, place);
    const ModelView view(model.content, place);
    const auto versions = view.all("Version");
    const std::string version = versions.empty() ? "" : short_version(versions.front().text("version_identifier"));
    const std::string engine = short_version(sim::version_of(install));
    const bool templates = !view.all_of("HVACTemplate:").empty();
    if (must_be_upgraded(place, version, engine, false)) {
      upgrade_epjson(model.content, place, version, engine, model.upgrade);
    }
    if (templates) {
      throw hal::InputError(place + ": HVACTemplate", "template objects in an epJSON model", "objects of equipment",
                            "give the IDF instead, which is sent through the engine's ExpandObjects");
    }
  } else {
    model.content = converted(file, text, install, transitions, model);
  }
  find_files(model.content, file);
  return model;
}

}  // namespace airside::tools
