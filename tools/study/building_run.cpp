#include "tools/study/building_run.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <functional>
#include <memory>
#include <stdexcept>
#include <utility>

#include "airside/demand/zone_guideline36.hpp"
#include "airside/supervision/envelope.hpp"
#include "airside/supervision/schedule.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "sim/energyplus/process.hpp"
#include "sim/json/json_file.hpp"
#include "tools/baselines/mpc.hpp"
#include "tools/baselines/pid.hpp"
#include "tools/baselines/tuned.hpp"
#include "tools/run/plant_choice.hpp"
#include "tools/run/training/pretraining.hpp"
#include "tools/run/training/transfer.hpp"

namespace airside::tools {

namespace {

using Kind = BuildingMethod::Kind;

constexpr std::array<std::pair<const char*, Kind>, 7> kind_names = {{{"own", Kind::own},
                                                                     {"schedule", Kind::schedule},
                                                                     {"constants", Kind::constant},
                                                                     {"integral", Kind::integral},
                                                                     {"guideline-36", Kind::guideline36},
                                                                     {"mpc", Kind::mpc},
                                                                     {"ours", Kind::ours}}};

PlantChoice choice_of(const Site& site, CivilTime from, std::uint64_t seed) {
  check_building(site);
  PlantChoice choice;
  choice.kind = "energyplus";
  choice.room = "twin";
  choice.site_twin = site.file.path;
  choice.model = site.file.twin->model;
  choice.twin = site.file.twin;
  choice.patches = site.file.twin->patches;
  choice.weather = site.file.twin->weather;
  choice.start = hal::civil_text(from).substr(0, hal::date_text_size);
  choice.seed = seed;
  return choice;
}

/// A patch that gives the model the schedule that a run acts on, which nothing in it follows; of the site's own patches
/// it has the meters and the repaired schedules.
void write_idle_schedule(const Site& site, const std::string& file) {
  nlohmann::json patch = {
      {"Schedule:Constant",
       {{site.file.twin->names->supply_setpoint_schedule, {{"hourly_value", site.settings.expert_work_degc}}}}}};
  for (const std::string& of_site : site.file.twin->patches) {
    const nlohmann::json content = sim::read_json(of_site);
    for (const auto& [type, objects] : content.items()) {
      if (type == "Meter:Custom") patch[type].update(objects);
      if (type.starts_with("Schedule:") && type != "Schedule:Constant") patch[type] = objects;
    }
  }
  std::ofstream out(file);
  if (!(out << patch.dump(1) << '\n') || !out.flush())
    throw hal::InputError(file, "a file that cannot be written", "space for temporary files",
                          "name a folder in TMPDIR");
}

/// Chooses from what the sensors show now.
using Choose = std::function<double(const sim::Sensors& now, CivilTime t, double last_degc)>;

/// Every setpoint passes the site's envelope. `period_s`: between two choices.
void run_rows(const Site& site, sim::PlantModel& plant, CivilTime until, int period_s, const Choose& choose) {
  const SafetyEnvelope envelope(site.settings);
  double last_degc = plant.sensors().setpoint_degc;
  while (plant.time() < until) {
    const CivilTime t = plant.time();
    if (t.second_of_day() % period_s == 0) {
      const double wanted = choose(plant.sensors(), t, last_degc);
      last_degc = envelope.limit(wanted, last_degc, expert_setpoint_degc(site.settings, t)).setpoint_degc();
      plant.set_setpoint(last_degc);
    }
    plant.advance_to({t.seconds + row_s});
  }
}

Choose by_guideline36(const Site& site, double warmest_degc) {
  auto reset = std::make_shared<ZoneGuideline36>();
  Guideline36Settings settings = guideline36_as_written(warmest_degc);
  settings.period_s = row_s;
  return [reset, settings, &site](const sim::Sensors& now, CivilTime t, double) {
    const bool runs = std::isfinite(now.ahu_on) ? now.ahu_on > 0.5 : true;
    const double degc = reset->setpoint_degc(settings, {now.room_temp_degc, now.zone_setpoint_degc, now.damper},
                                             now.outdoor_temp_degc, runs);
    return std::isfinite(degc) ? degc : expert_setpoint_degc(site.settings, t);
  };
}

Choose by_baseline(const Site& site, std::shared_ptr<BaselineController> baseline) {
  return [baseline = std::move(baseline), &site](const sim::Sensors& now, CivilTime t, double last_degc) {
    CycleObservation seen;
    seen.time = t;
    seen.sensors = now;
    seen.previous_setpoint_degc = last_degc;
    seen.target_degc = site.settings.target_degc;
    return baseline->decide(seen);
  };
}

std::vector<HistoryRow> history_of(const Site& site, const std::vector<hal::LogRow>& rows) {
  std::vector<HistoryRow> history;
  const auto rooms = static_cast<std::ptrdiff_t>(site.counts.vavs);
  const std::ptrdiff_t outdoor = 2 * (site.counts.vavs + site.counts.fcus) + site.counts.powers + 1;
  for (const hal::LogRow& row : rows) {
    HistoryRow past{row.time, {}, row.setpoint_degc};
    past.sensors.room_temp_degc.assign(row.value.begin(), row.value.begin() + rooms);
    past.sensors.outdoor_temp_degc = row.value[static_cast<std::size_t>(outdoor)];
    history.push_back(std::move(past));
  }
  return history;
}

void run_ours(const Site& site, const BuildingRun& run, sim::PlantModel& plant, const std::vector<hal::LogRow>& history,
              CivilTime until) {
  BlobBytes blob;
  if (site.settings.objective == Objective::mean) {
    FineTuneOptions options;
    options.seed = run.seed;
    blob = transfer(site, run.blob != nullptr ? *run.blob : BlobBytes{}, history, options).blob;
  }
  (void)run_controller(site, plant, blob, history, until, run.seed);
}

void control(const Site& site, const BuildingRun& run, const BuildingMethod& method, sim::PlantModel& plant,
             const std::vector<hal::LogRow>& history, CivilTime until) {
  switch (method.kind) {
    case Kind::own: return plant.advance_to(until);
    case Kind::schedule: return static_cast<void>(run_schedule(site, plant, until));
    case Kind::constant:
      return run_rows(site, plant, until, control_cycle(site.settings).seconds(),
                      [&method](const sim::Sensors&, CivilTime, double) { return method.value; });
    case Kind::integral:
      return run_rows(site, plant, until, control_cycle(site.settings).seconds(),
                      by_baseline(site, std::make_shared<IntegralBaseline>(site.settings, method.value)));
    case Kind::guideline36: return run_rows(site, plant, until, row_s, by_guideline36(site, method.value));
    case Kind::mpc: {
      const TunedGains& gains = tuned_gains(PlantKind::energyplus);
      MpcSettings settings;
      settings.move_weight = gains.mpc_move_weight;
      settings.disturbance_share = gains.mpc_disturbance_share;
      auto mpc = std::make_shared<MpcBaseline>(site.settings, settings);
      mpc->observe_history(history_of(site, history));
      return run_rows(site, plant, until, control_cycle(site.settings).seconds(), by_baseline(site, mpc));
    }
    case Kind::ours: return run_ours(site, run, plant, history, until);
  }
}

}  // namespace

void check_building(const Site& site) {
  if (site.file.twin && site.file.twin->control == hal::TwinControl::own && site.file.twin->names) return;
  throw hal::InputError(site.file.path + ": [twin]", "no model with a control of its own", "an adopted site",
                        "make one with `airside adopt`");
}

BuildingFigures run_building(const Site& site, const BuildingRun& run, const BuildingMethod& method) {
  const CivilTime begin{run.from.seconds - run.schedule_days * seconds_per_day};
  const CivilTime until{run.from.seconds + run.days * seconds_per_day};
  PlantChoice choice = choice_of(site, begin, run.seed);
  const sim::RunFolder folder;
  if (method.kind == Kind::own) {
    choice.patches = {(folder.path() / "own.patch.json").string()};
    write_idle_schedule(site, choice.patches.front());
  }
  const auto engine = make_plant(choice, site, run.schedule_days + run.days);
  MeteredModel plant(*engine, site, run.from);
  std::vector<hal::LogRow> history;
  if (run.schedule_days > 0) history = run_schedule(site, plant, run.from).rows;
  control(site, run, method, plant, history, until);
  if (plant.time() < until) plant.advance_to(until);
  return plant.figures();
}

BlobBytes pretrain_building(const Site& site, CivilTime until, int days, std::uint64_t seed) {
  const auto plant = make_plant(choice_of(site, {until.seconds - days * seconds_per_day}, seed), site, days);
  PretrainOptions options;
  options.seed = seed;
  return pretrain(site, *plant, until, options).blob;
}

std::vector<double> building_constants(const Site& site) {
  constexpr int steps = 5;
  const double low = site.settings.action_min_degc, range = site.settings.action_max_degc - low;
  std::vector<double> all;
  for (int i = 0; i <= steps; ++i) all.push_back(std::round(10 * (low + range * i / steps)) / 10);
  return all;
}

double most_outside_degch(Objective objective, int zones, const std::vector<BuildingFigures>& figures) {
  if (objective == Objective::mean) return HUGE_VAL;
  double fewest = HUGE_VAL;
  for (const BuildingFigures& f : figures) fewest = std::min(fewest, f.outside_degch());
  return fewest + 0.05 * zones;
}

std::size_t best_for(Objective objective, int zones, const std::vector<BuildingFigures>& figures) {
  const bool band = objective == Objective::band;
  const auto value = [band](const BuildingFigures& f) { return band ? f.total_kwh() : f.dae_degc; };
  const double most = most_outside_degch(objective, zones, figures);
  std::size_t best = figures.size();
  for (std::size_t i = 0; i < figures.size(); ++i) {
    if (figures[i].outside_degch() > most) continue;
    if (best == figures.size() || value(figures[i]) < value(figures[best])) best = i;
  }
  return best;
}

std::vector<std::string> building_kinds() {
  std::vector<std::string> names;
  for (const auto& [name, kind] : kind_names) names.emplace_back(name);
  return names;
}

std::string name_of(BuildingMethod::Kind kind) {
  for (const auto& [name, of] : kind_names) {
    if (of == kind) return name;
  }
  return {};
}

BuildingMethod::Kind kind_of(const std::string& wanted) {
  for (const auto& [name, kind] : kind_names) {
    if (name == wanted) return kind;
  }
  throw std::invalid_argument("no way of control is called " + wanted);
}

}  // namespace airside::tools
