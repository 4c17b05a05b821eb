#include "tools/cli/gap/site_gap.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <thread>

#include "hal/text/input_error.hpp"
#include "hal/text/shell_word.hpp"
#include "tools/gap/map/mapped_model.hpp"
#include "tools/gap/verdict/verdict_json.hpp"
#include "tools/run/log_weather.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

/// What the mapping names; the model is made ready in the cache.
static void choose_mapped(gap::GapRequest& r, const std::string& map, const std::vector<std::string>& patches) {
  const gap::Mapping mapping = gap::read_mapping(map);
  r.site = fs::path(map).stem().string();
  r.source.map = map;
  r.source.engine = "energyplus";
  r.source.weather = mapping.weather;
  r.source.patches = patches;
  r.source.topology = gap::counts_of(mapping).name;
  r.source.model = gap::prepare_mapped_model(mapping, r.cache).string();
}

}  // namespace

GapOptions::GapOptions() : jobs(std::max(1, static_cast<int>(std::thread::hardware_concurrency()))) {}

std::vector<sim::Effect> GapOptions::effects() const { return sim::load_effects(effects_folder()); }

fs::path GapOptions::effects_folder() const {
  return effects_dir.empty() ? sim::find_effects() : fs::path(effects_dir);
}

void require_writable(const std::string& option, const fs::path& path, bool folder) {
  std::error_code ignored;
  fs::path there = fs::absolute(path).lexically_normal();
  if (!there.has_filename()) there = there.parent_path();
  const bool wrong_kind = fs::exists(there, ignored) && fs::is_directory(there, ignored) != folder;
  if (!folder) there = there.parent_path();
  while (!fs::exists(there, ignored) && there.has_relative_path()) there = there.parent_path();
  if (!wrong_kind && fs::is_directory(there, ignored) && access(there.c_str(), W_OK | X_OK) == 0) return;
  throw hal::InputError(
      option + " " + path.string(), wrong_kind ? (folder ? "a file" : "a folder") : "no writable place",
      folder ? "a folder that can be made or written" : "a file that can be written", "choose another");
}

std::string SiteGap::again() const {
  std::string text = "airside gap run";
  const auto add = [&text](const char* name, const std::string& value) {
    if (!value.empty()) text += fmt::format(" {} {}", name, hal::shell_word(value));
  };
  add("--site", site_path);
  add("--map", map);
  add("--measured", measured);
  add("--reference", reference);
  add("--reference-days", reference_days > 0 ? std::to_string(reference_days) : "");
  add("--twin", twin);
  for (const std::string& patch : patches) add("--patch", patch);
  add("--plant", plant);
  add("--room", room);
  add("--weather", weather);
  add("--effects", effects_dir);
  for (const std::string& one : tries) add("--try", one);
  add("--buildings", buildings ? std::to_string(*buildings) : "");
  if (price > 0) {
    add("--price", fmt::format("{:g}", price));
    add("--currency", currency);
  }
  if (no_reference) text += " --no-reference";
  if (findings_only) text += " --findings-only";
  if (best_guess) text += " --best-guess";
  if (no_duties) text += " --no-duties";
  if (sun_on_site) text += " --sun-on-site";
  if (retrain) {
    text += " --retrain";
    add("--measured-room", measured_room);
    add("--seeds", std::to_string(seeds));
    add("--pretrain-days", std::to_string(pretrain_days));
    add("--control-days", std::to_string(control_days));
  }
  add("--out", out);
  return text;
}

/// The model: --twin, else --plant and --room, else the site's.
void SiteGap::choose_model(gap::CaseDescription& c, const Site& site) const {
  if (!twin.empty() && (plant == "rc" || !room.empty())) {
    throw hal::InputError("--twin " + twin, room.empty() ? "--plant rc beside it" : "--room " + room + " beside it",
                          "one model", "leave one of the two out");
  }
  if (!twin.empty() && !twin.ends_with(".epJSON")) {
    throw hal::InputError("--twin " + twin, "a name that does not end in .epJSON", "an EnergyPlus model in epJSON",
                          "convert an IDF with energyplus --convert-only; for a room file use --plant rc --room FILE");
  }
  const auto& section = site.file.twin;
  c.patches = patches;
  if (!twin.empty()) {
    c.engine = "energyplus";
    c.model = twin;
  } else if (!plant.empty() || !room.empty()) {
    c.engine = plant.empty() ? "rc" : plant;
    c.model = !room.empty() ? room : c.engine == "rc" ? "rc" : "twin";
  } else if (section) {
    if (section->control == hal::TwinControl::own) c.site = site_path;
    c.engine = section->model == "rc" ? "rc" : "energyplus";
    c.model = section->model;
    if (patches.empty()) c.patches = section->patches;
  } else {
    throw hal::InputError("--twin", "no model", "a model of the room to compare the log with",
                          "give --twin FILE.epJSON, or --plant rc with --room, or [twin] in the site file");
  }
  if (c.engine == "energyplus" && twin.empty() && !c.model.ends_with(".epJSON")) {
    std::replace(c.model.begin(), c.model.end(), '-', '_');
  }
  c.weather = !weather.empty() ? weather : section ? section->weather : "";
  if (c.weather.empty()) c.weather = weather_of_logs({measured, reference});
  if (c.weather.empty()) {
    throw hal::InputError("--weather", "no weather", "an EPW file of the site or its station over the logged days",
                          "give --weather FILE.epw, or weather in [twin] of the site file: sun, humidity and wind "
                          "are not in the log");
  }
}

Site SiteGap::the_site() const { return site_path.empty() ? built_in_site() : load_site(site_path); }

gap::RetrainRequest SiteGap::retrain_request() const {
  gap::RetrainRequest r;
  r.site = the_site();
  if (!measured_room.empty()) r.measured = gap::parse_retrain_room(measured_room);
  r.seeds = seeds;
  r.pretrain_days = pretrain_days;
  r.days = control_days;
  r.jobs = jobs;
  return r;
}

/// Before an hour of simulations ends with a room that does not exist.
void SiteGap::check_rooms(const gap::GapRequest& asked) const {
  const gap::RetrainPlan plan = gap::retrain_plan(asked.source, retrain_request());
  gap::check_retrain_room(plan, plan.twin);
  if (plan.measured.room.empty()) return;
  try {
    gap::check_retrain_room(plan, plan.measured);
  } catch (const hal::InputError& e) {
    throw hal::InputError(e.place() == "--room" ? "--measured-room " + measured_room : e.place(), e.found(),
                          e.expected(), e.remedy());
  }
}

gap::GapRequest SiteGap::request() const {
  const Site site = the_site();
  gap::GapRequest r;
  r.site = site.file.name;
  r.command = again();
  r.jobs = jobs;
  r.best_guess = best_guess;
  r.findings_only = findings_only;
  r.tries = tries;
  r.effects = effects_folder();
  r.sun_on_site = sun_on_site;
  r.buildings = buildings;
  r.price = {price, currency};
  r.cache = cache.empty() ? fs::path(out) / "runs" : fs::path(cache);
  gap::CaseDescription& c = r.source;
  c.topology = site.file.topology;
  c.measured_log = measured;
  c.reference_log = reference;
  c.reference_days = reference_days;
  c.duties = !no_duties;
  if (map.empty())
    choose_model(c, site);
  else
    choose_mapped(r, map, patches);
  if (!keep_run.empty() && c.engine == "rc") {
    throw hal::InputError("--keep-run " + keep_run, "an RC room", "an EnergyPlus twin",
                          "leave the option out: plain energyplus cannot run an RC room");
  }
  const int given = (reference.empty() ? 0 : 1) + (reference_days > 0 ? 1 : 0) + (no_reference ? 1 : 0);
  if (given != 1) {
    const char* beside =
        reference.empty() || reference_days == 0 ? "--no-reference beside it" : "--reference-days beside it";
    throw hal::InputError(
        "--reference", given == 0 ? "no reference period" : beside,
        "one reference period: days on which plant and room were as the twin describes",
        "give --reference LOG, or --reference-days N if the first N days of --measured are such days; with "
        "--no-reference parameters are what their priors have, and a wrong one and a missing effect look more alike");
  }
  return r;
}

void SiteGap::check_places(const gap::GapRequest& asked) const {
  require_writable("--out", out, true);
  if (!apply.empty()) require_writable("--apply", apply, false);
  if (retrain) check_rooms(asked);
}

std::vector<sim::Effect> SiteGap::searched() const {
  return sun_on_site ? sim::with_sun_on_site(effects()) : effects();
}

SiteGap::Finished SiteGap::finish(gap::GapRun run) const {
  const RunFacts facts =
      run_facts(run.request.source.engine == "energyplus", weather_file_text(run.request.source.weather));
  if (!keep_run.empty()) gap::keep_patched_run(run, keep_run);
  const bool patched_room = retrain && run.request.source.engine == "rc" && apply.empty();
  const GapFolder folder{out, apply, patched_room};
  nlohmann::json j = write_gap_folder(run, facts, folder);
  if (run.patched && !apply.empty()) {
    gap::write_whole_file(apply, run.patched->after.dump(1) + "\n");
    gap::write_whole_file(apply + ".ledger.json", gap::ledger_of(run).dump(1) + "\n");
  }
  if (retrain && run.patched) {  // a pretraining that dies leaves the verdict
    gap::RetrainRequest r = retrain_request();
    r.patched_file = run.request.source.engine != "rc" ? fs::path(out) / "twin-patch.json"
                     : patched_room                    ? fs::path(out) / "patched-room.json"
                                                       : fs::path(apply);
    StagedProgress progress(stderr);
    gap::retrain_patched(run, r, progress);
    j = write_gap_folder(run, facts, folder);
  }
  return {std::move(run), std::move(j), facts};
}

void SiteGap::check_patched(const gap::GapRun& run) const {
  if (!apply.empty() && !run.patched) {
    throw hal::InputError("--apply " + apply, fmt::format("the verdict {}", gap::text_of(run.verdict.kind)),
                          "a named effect to patch the twin with",
                          run.verdict.findings.empty() ? "the twin was left as it is"
                                                       : "the twin was left as it is; --best-guess patches it anyway");
  }
  if (retrain && !run.patched) {
    throw hal::InputError("--retrain", fmt::format("the verdict {}", gap::text_of(run.verdict.kind)),
                          "a patched twin to pretrain on",
                          !run.verdict.findings.empty()                ? "--best-guess patches the twin anyway"
                          : run.verdict.kind == gap::VerdictKind::none ? "nothing has to be learned again"
                                                                       : "what is missing has no name yet");
  }
}

}  // namespace airside::tools
