#include "tools/adopt/adoption.hpp"
#include "tools/adopt/loop/loop_meters.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>

#include "hal/text/input_error.hpp"
#include "hal/text/staged_folder.hpp"
#include "sim/energyplus/epjson_lint.hpp"
#include "sim/energyplus/process.hpp"
#include "sim/json/merge_patch.hpp"
#include "tools/adopt/model/foreign_file.hpp"
#include "tools/adopt/model/weather_choice.hpp"
#include "tools/adopt/season_runs.hpp"
#include "tools/adopt/site_text.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

constexpr const char* own_control = "the model's own control";
constexpr std::array compared_seasons = {Season::summer, Season::winter, Season::autumn};
/// The model's own control, then four setpoints and the schedule, in each season.
constexpr int planned_runs = 3 + 5 * static_cast<int>(compared_seasons.size());

std::string held_text(double degc) { return fmt::format("held at {:.1f} degC", degc); }

/// The range's ends and two between.
std::vector<double> held_setpoints(const SiteChoices& c) {
  std::vector<double> all;
  for (int n = 0; n < 4; ++n) {
    const double degc = n == 0 ? c.min_degc : n == 3 ? c.max_degc : c.min_degc + n * (c.max_degc - c.min_degc) / 3;
    all.push_back(n == 0 || n == 3 ? degc : std::round(2 * degc) / 2);
  }
  return all;
}

/// Schedules may name limits that are not there: the engine only warns, so the name is dropped.
json without_lost_limits(const ModelView& model, std::vector<std::string>& notes) {
  constexpr const char* field = "schedule_type_limits_name";
  json patch = json::object();
  int count = 0;
  for (const ModelObject& schedule : model.all_of("Schedule:")) {
    const std::string limits = schedule.text(field);
    if (limits.empty() || model.find("ScheduleTypeLimits", limits)) continue;
    patch[schedule.type][schedule.name][field] = nullptr;
    ++count;
  }
  if (count > 0) notes.push_back(fmt::format("{} schedules named type limits that are not there: dropped", count));
  return patch;
}

void refuse_full_folder(const AdoptRequest& request) {
  std::error_code failed;
  if (!fs::exists(request.folder, failed)) return;
  if (!fs::is_directory(request.folder, failed)) {
    throw hal::InputError(request.folder.string(), "a file", "a folder, or a name that is free",
                          "choose another output folder");
  }
  if (request.force || fs::is_empty(request.folder, failed)) return;
  throw hal::InputError(request.folder.string(), "a folder that has files already", "a folder that is not there",
                        "choose another output folder, or give --force to replace files of the same names");
}

json patch_of(const Adoption& a, const json& repairs) {
  json patch = repairs;
  patch.merge_patch(json::object());
  const auto add = [&patch](const json& part) {
    // Not merge_patch: a null of a part must stay in the whole.
    for (const auto& [type, objects] : part.items()) {
      if (!objects.is_object() || !patch.contains(type) || !patch[type].is_object()) {
        patch[type] = objects;
        continue;
      }
      for (const auto& [name, fields] : objects.items()) {
        json& target = patch[type][name];
        if (target.is_object() && fields.is_object()) {
          target.update(fields);
        } else if (!target.is_object() || !fields.is_null()) {
          target = fields;
        }
      }
    }
  };
  add(a.sizes.patch);
  add(a.setpoint.patch);
  return patch;
}

/// The range's ends where the plant reaches them in some season; else what it reaches.
void fit_range(Adoption& a) {
  SiteChoices& c = a.choices;
  double low = 1e9, high = -1e9;
  for (const Response& r : {a.response(Season::summer), a.response(Season::winter)}) {
    if (!r.known || !r.has_authority()) continue;
    low = std::min(low, r.supply_low_degc);
    high = std::max(high, r.supply_high_degc);
  }
  if (low > high) return;
  if (low > c.min_degc + 1) c.min_degc = std::min(std::floor(2 * low - 1) / 2, c.max_degc - 2);
  if (high < c.max_degc - 1) c.max_degc = std::max(std::ceil(2 * high + 1) / 2, c.min_degc + 2);
  c.work_degc = std::clamp(c.work_degc, c.min_degc, c.max_degc);
  c.off_degc = std::clamp(c.off_degc, c.min_degc, c.max_degc);
}

/// What the week shows of each zone; a terminal whose damper the engine does not report has none.
void note_zones(Adoption& a, const Observation& week) {
  for (std::size_t z = 0; z < a.loop.terminals.size(); ++z) {
    LoopTerminal& t = a.loop.terminals[z];
    t.people = std::any_of(week.people[z].begin(), week.people[z].end(), [](double n) { return n > 0; });
    t.damper = t.damper && !week.damper[z].empty();
    t.thermostat = t.thermostat && !(week.cooling_sp[z].empty() && week.heating_sp[z].empty());
  }
}

void note_powers(Adoption& a, const Observation& summer, const Observation& winter) {
  for (const std::string& meter : a.choices.powers) {
    double most = 0;
    for (const Observation* week : {&summer, &winter}) {
      const auto series = week->meter_kw.find(meter);
      if (series != week->meter_kw.end())
        most = std::max(most, *std::max_element(series->second.begin(), series->second.end()));
    }
    a.most_kw.push_back(most);
  }
}

/// The engine's first Severe or Fatal line of a complaint.
std::string first_grave_line(const std::string& words) {
  const auto begin = words.find("** ");
  return begin == std::string::npos ? words : words.substr(begin, words.find('\n', begin) - begin);
}

constexpr int trial_days = 2;

/// The same days of a season with the setpoint at the ends of the probed range.
struct SeasonProbe {
  Observation low, high;
};

struct Probes {
  json patched;  ///< the model as runs take it
  std::vector<SeasonProbe> seasons;
};

/// Runs the patched model at both ends of the range; a model that does not run with hard sizes goes without.
Probes probe(Adoption& a, const json& model, const json& repairs, SeasonRuns& runs) {
  a.probed_min_degc = a.choices.min_degc;
  a.probed_max_degc = a.choices.max_degc;
  Probes out;
  out.patched = sim::merge_patched(model, patch_of(a, repairs), "twin.patch.json");
  const auto at = [&](double degc, Season season) {
    return runs.run(held_at(out.patched, a.setpoint.schedule, degc), a.loop, season, trial_days, held_text(degc));
  };
  for (const Season season : compared_seasons) {
    SeasonProbe ends;
    try {
      ends.low = at(a.probed_min_degc, season);
    } catch (const hal::InputError& error) {
      if (a.sizes.written == 0) throw;
      a.notes.push_back("with the sizes written hard the engine does not run it, so they stay autosized: " +
                        first_grave_line(error.found()));
      a.sizes = {json::object(), 0, a.sizes.open + a.sizes.written};
      out.patched = sim::merge_patched(model, patch_of(a, repairs), "twin.patch.json");
      ends.low = at(a.probed_min_degc, season);
    }
    ends.high = at(a.probed_max_degc, season);
    Comparison found;
    found.season = season;
    found.response = response_of(ends.low, ends.high, a.choices);
    a.seasons.push_back(std::move(found));
    out.seasons.push_back(std::move(ends));
  }
  return out;
}

/// The model's own control, the site's schedule and constants over its range, on the same days of each season.
void compare(Adoption& a, Probes probes, const std::vector<Observation>& own, SeasonRuns& runs) {
  for (std::size_t s = 0; s < compared_seasons.size(); ++s) {
    const Season season = compared_seasons[s];
    std::vector<HeldObservation> constants;
    for (const double degc : held_setpoints(a.choices)) {
      HeldObservation held{degc, {}};
      if (degc == a.probed_min_degc) {
        held.days = std::move(probes.seasons[s].low);
      } else if (degc == a.probed_max_degc) {
        held.days = std::move(probes.seasons[s].high);
      } else {
        held.days =
            runs.run(held_at(probes.patched, a.setpoint.schedule, degc), a.loop, season, trial_days, held_text(degc));
      }
      constants.push_back(std::move(held));
    }
    const Observation schedule = runs.run(scheduled(probes.patched, a.setpoint.schedule, a.choices), a.loop, season,
                                          trial_days, "the site's schedule");
    Comparison compared = comparison_of(own[s], schedule, constants, a.choices);
    compared.season = season;
    compared.response = a.seasons[s].response;
    a.seasons[s] = std::move(compared);
  }
}

void write_text(const fs::path& file, const std::string& text) {
  std::ofstream out(file, std::ios::binary);
  if (!(out << text) || !out.flush()) {
    throw hal::InputError(file.parent_path().string(), "a folder that cannot be written", "a writable place with space",
                          "choose another output folder");
  }
}

void write_site(const Adoption& a, const json& model, const json& patch, const fs::path& weather,
                const fs::path& folder) {
  hal::StagedFolder staged(folder);
  write_text(staged.path() / "model.epJSON", model.dump(1) + "\n");
  write_text(staged.path() / "twin.patch.json", patch.dump(1) + "\n");
  write_text(staged.path() / "points.csv", adopted_points_text(a));
  write_text(staged.path() / "map.toml", adopted_map_text(a));
  write_text(staged.path() / "adopt.md", adoption_page(a));
  std::error_code failed;
  fs::copy_file(weather, staged.path() / a.weather_name, fs::copy_options::overwrite_existing, failed);
  if (failed) {
    throw hal::InputError(folder.string(), "a folder that cannot be written: " + failed.message(),
                          "a writable place with space", "choose another output folder");
  }
  write_text(staged.path() / "site.toml", adopted_site_text(a));
  staged.commit("site.toml");
}

}  // namespace

std::string Adoption::topology() const {
  return fmt::format("{}vav-{}fcu-{}power", loop.terminals.size(), loop.fcu_zones.size(), choices.powers.size());
}

bool Adoption::serves_band() const {
  return std::ranges::all_of(loop.terminals, [](const LoopTerminal& t) { return t.damper && t.thermostat; });
}

Adoption examine(const json& model, const std::string& place, const std::string& air_loop) {
  const ModelView view(model, place);
  Adoption a;
  a.loop = walk_air_loop(view, chosen_air_loop(view, air_loop));
  a.setpoint = setpoint_patch(view, a.loop, 14);
  return a;
}

namespace {

/// What is known before the engine runs.
struct Prepared {
  ForeignModel model;
  Adoption adoption;
  json repairs;
  LoopMeters meters;
  WeatherChoice weather;
};

Prepared prepare(const AdoptRequest& request, const sim::EnergyPlusInstall& install) {
  Prepared out;
  out.model = read_foreign_model(request.model, install, request.transitions);
  const std::string place = request.model.string();
  out.adoption = examine(out.model.content, place, request.air_loop);
  Adoption& a = out.adoption;
  const ModelView view(out.model.content, place);
  a.notes = out.model.notes;
  a.upgrade = out.model.upgrade;
  a.model_name = request.model.filename().string();
  a.engine = sim::version_of(install);
  out.repairs = without_lost_limits(view, a.notes);
  out.meters = loop_meters(view, a.loop);
  json& repairs = out.repairs;
  repairs.update(out.meters.patch);
  if (!view.all("RunPeriodControl:DaylightSavingTime").empty()) {
    repairs["RunPeriodControl:DaylightSavingTime"] = nullptr;
    a.notes.emplace_back("daylight saving dropped: logs and schedules keep standard time");
  }
  sim::lint_epjson(sim::merge_patched(out.model.content, patch_of(a, repairs), place), install.schema, {place});
  out.weather = choose_weather(view, request.model, request.weather, install);
  a.weather_name = out.weather.file.filename().string();
  a.weather_note = out.weather.note;
  return out;
}

}  // namespace

Adoption check_adoptable(const AdoptRequest& request) { return prepare(request, sim::find_energyplus()).adoption; }

Adoption adopt(const AdoptRequest& request) {
  refuse_full_folder(request);
  const sim::EnergyPlusInstall install = sim::find_energyplus();
  Prepared prepared = prepare(request, install);
  const ForeignModel& model = prepared.model;
  Adoption& a = prepared.adoption;
  const json& repairs = prepared.repairs;
  const LoopMeters& meters = prepared.meters;
  const WeatherChoice& weather = prepared.weather;
  const std::string place = request.model.string();
  const ModelView view(model.content, place);

  SeasonRuns runs(install, weather, place, planned_runs, request.progress);
  const json repaired = sim::merge_patched(model.content, repairs, place);
  std::vector<Observation> own;
  own.push_back(runs.run(repaired, a.loop, Season::summer, 7, own_control));
  a.sizes = sizes_of_run(view, runs.folder() / "eplusout.eio", install.schema);
  own.push_back(runs.run(repaired, a.loop, Season::winter, 7, own_control));
  a.choices = site_choices(own[0], own[1], a.loop.kind(), meters);
  a.choices.outdoor_share = least_outdoor_share(view, a.loop, a.sizes.patch);
  note_zones(a, own[0]);
  note_powers(a, own[0], own[1]);
  a.setpoint = setpoint_patch(view, a.loop, a.choices.work_degc);
  Probes probes = probe(a, model.content, repairs, runs);
  fit_range(a);
  own.push_back(runs.run(repaired, a.loop, Season::autumn, trial_days, own_control));
  compare(a, std::move(probes), own, runs);
  const json patch = patch_of(a, repairs);
  sim::lint_epjson(patch, install.schema, {"twin.patch.json", sim::LintScope::patch});
  write_site(a, model.content, patch, weather.file, request.folder);
  return std::move(a);
}

}  // namespace airside::tools
