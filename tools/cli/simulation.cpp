#include "tools/cli/simulation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <optional>

#include "hal/log/log_csv.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "sim/rc/modulating_room.hpp"
#include "sim/weather/epw.hpp"
#include "tools/baselines/baseline.hpp"
#include "tools/run/log_weather.hpp"

namespace airside::tools {

namespace {

/// Weekdays of a written weather file are those of the simulated year.
constexpr int weather_year = 2021;

/// A log that may not have been asked for. Its place is tried before the run that is to fill it.
class AskedLog {
 public:
  AskedLog(const std::string& path, const Site& site) {
    if (!path.empty()) writer_.emplace(path, site.counts, true);
  }
  void write(const std::vector<hal::LogRow>& rows) {
    if (!writer_) return;
    for (const hal::LogRow& row : rows) writer_->append(row);
    writer_->close();
  }

 private:
  std::optional<hal::LogWriter> writer_;
};

/// Whatever the spelling: relative, through links, or by a second name of the file.
bool is_one_file(const std::string& a, const std::string& b) {
  namespace fs = std::filesystem;
  std::error_code none;
  if (fs::equivalent(a, b, none)) return true;
  const fs::path whole_a = fs::weakly_canonical(fs::absolute(a, none), none);
  return !whole_a.empty() && whole_a == fs::weakly_canonical(fs::absolute(b, none), none);
}

}  // namespace

/// The made-up year of a simulated log is in no file: it goes beside the log, for what reads weather and log.
std::string Simulation::weather_to_write(const Site& s) const {
  if (log.empty() || !plant.weather.empty() || !plant.environment.empty() || is_energyplus(plant, s)) return "";
  const std::string path = weather_beside(log);
  return path == log ? "" : path;
}

/// What ours starts from: weights, but nothing for the objective band, which learns on the box from what boxes show.
void Simulation::check_start(Objective objective, bool engine) const {
  if (objective != Objective::band) {
    if (!weights.empty() || transfer) return;
    throw hal::InputError(
        "--weights", "no weights", "a blob for the controller",
        "give --weights (airside pretrain makes one), --transfer alone to train from scratch, or another --method");
  }
  if (transfer) {
    throw hal::InputError("--transfer", "given with objective = \"band\"",
                          "no weights: band learns from dampers and meters on the box", "leave it out");
  }
  if (engine || sim::modulating_name(plant.room)) return;
  throw hal::InputError("--room " + plant.room, "a room whose boxes do not modulate, and objective = \"band\"",
                        "modulating-humid, modulating-mild, modulating-reheat or modulating-duct",
                        "choose one of these rooms, or objective = \"mean\" in the site file");
}

/// Two logs in one file would be neither.
void Simulation::check_places(const Site& s) const {
  if (!history_log.empty() && expert_days == 0 && history.empty()) {
    throw hal::InputError("--history-log " + history_log, "--expert-days 0, so no day under the schedule",
                          "1 to 60 of them, whose rows it takes", "give --expert-days, or leave --history-log out");
  }
  const std::pair<std::string, std::string> files[] = {{"--history", history},
                                                       {"--log", log},
                                                       {"--history-log", history_log},
                                                       {"the made-up weather beside --log", weather_to_write(s)}};
  for (std::size_t i = 1; i < std::size(files); ++i) {
    for (std::size_t j = 0; j < i; ++j) {
      const auto& [later, path] = files[i];
      const auto& [earlier, other] = files[j];
      if (path.empty() || other.empty() || !is_one_file(path, other)) continue;
      throw hal::InputError(later + " " + path, fmt::format("the file of {} ({})", earlier, other),
                            "a file of its own for each", "give one of them another name");
    }
  }
}

/// Each thing typed is looked at before the user is asked for one that is not there. Returns the rows of --history.
std::vector<hal::LogRow> Simulation::read_typed(const Site& s, bool engine) const {
  (void)start_of(plant);
  check_room(plant, s);
  if (!engine && plant.environment.empty()) {
    (void)make_plant(plant, s, expert_days + days);
  } else if (engine && !plant.weather.empty() && !std::ifstream(plant.weather)) {  // the engine reads it when it starts
    throw hal::InputError(plant.weather, "no readable file", "an EPW weather file", "check the path");
  }
  if (history.empty()) return {};
  return hal::read_log(history, s.counts).rows;
}

void Simulation::refuse_repeated(const std::vector<std::string>& compare) const {
  for (std::size_t i = 0; i < compare.size(); ++i) {
    const bool is_main = compare[i] == method;
    const auto before = compare.begin() + static_cast<std::ptrdiff_t>(i);
    if (!is_main && std::find(compare.begin(), before, compare[i]) == before) continue;
    throw hal::InputError("--compare " + compare[i],
                          is_main ? "the method that runs anyway, by --method" : "the same method twice",
                          "each method once", "leave it out here, or name another");
  }
}

/// What no method of the run heeds must not look as if it had been used.
void Simulation::refuse_unheeded(const std::vector<std::string>& compare, bool engine) const {
  std::vector<std::string> methods{method};
  methods.insert(methods.end(), compare.begin(), compare.end());
  const auto plant_kind = engine ? PlantKind::energyplus : PlantKind::rc;
  const auto remembers = [&](const std::string& name) {
    return name == "ours" ||
           (!name.starts_with("floor-") && make_baseline(name, built_in_site().settings, plant_kind)->heeds_history());
  };
  const bool ours = std::find(methods.begin(), methods.end(), "ours") != methods.end();
  const std::string run =
      "--method " + method + (compare.empty() ? "" : fmt::format(" and --compare {}", fmt::join(compare, ",")));
  const auto refuse = [&run](const std::string& option, const char* lack, const char* expected, const char* remedy) {
    throw hal::InputError(option, run + lack, expected, remedy);
  };
  constexpr const char* for_ours = "--method ours, or ours among --compare";
  constexpr const char* leave_out = "leave it out, or choose that method";
  if (!ours && !weights.empty()) refuse("--weights " + weights, ", which have no weights", for_ours, leave_out);
  if (!ours && transfer) refuse("--transfer", ", which have no weights", for_ours, leave_out);
  if (!ours && !site.preset.empty())
    refuse("--preset " + site.preset, ", which a preset does not change", for_ours, leave_out);
  if (steps_given && !transfer)
    refuse(fmt::format("--steps {}", steps), " without --transfer", "--transfer, whose optimiser steps they are",
           ours ? "give --transfer, or leave --steps out" : "leave it out");
  if (!history.empty() && std::none_of(methods.begin(), methods.end(), remembers))
    refuse("--history " + history, ", which remember no earlier days",
           "a method that does: ours, arx-2, arx-rls, mpc, integral-tuned, ...", leave_out);
  if (!faults.empty() && method.starts_with("floor-"))
    refuse("--faults " + faults, ", which sees the room itself and no sensor", "a method that sees sensors",
           "leave it out, or choose another method; --compare shows a floor beside it");
}

Simulation::Ready Simulation::make_ready(const Site& chosen, const std::vector<std::string>& compare) const {
  Trial trial{chosen, plant, expert_days, days};
  trial.site.file.seed = plant.seed;
  if (site.path.empty()) trial.site.file.name = "Room " + plant.room;  // "built-in" says nothing in a report
  const bool engine = is_energyplus(plant, trial.site);
  bool ours = method == "ours";
  if (!ours) check_method("--method", method, engine);
  for (const std::string& name : compare) {
    if (name != "ours") check_method("--compare", name, engine);
    ours = ours || name == "ours";
  }
  refuse_repeated(compare);
  refuse_unheeded(compare, engine);
  if (!faults.empty()) trial.faults = sim::read_fault_script(faults, trial.site.counts);
  check_places(trial.site);
  std::vector<hal::LogRow> remembered = read_typed(trial.site, engine);
  RunFacts facts = run_facts(plant, trial.site);
  BlobBytes blob;
  if (ours) {
    check_start(trial.site.settings.objective, engine);
    if (!weights.empty()) blob = read_blob(weights, trial.site);
  }
  return {std::move(trial), std::move(facts), std::move(blob), std::move(remembered)};
}

SimulatedRun Simulation::run(const Ready& ready, const std::string& name, const OnProgress& progress) const {
  const Trial& trial = ready.trial;
  Prepared prepared = prepare(trial);
  if (!history.empty()) prepared.history = ready.history;
  SimulatedRun out;
  out.history = prepared.history;
  out.plant = prepared.model->description();
  out.control = name == "ours" ? run_ours(trial, prepared, {ready.blob, transfer, steps}, progress)
                               : run_method(trial, prepared, name, progress);
  return out;
}

Simulation::Recorded Simulation::run_recorded(const Ready& ready, const std::function<OnProgress()>& begin) const {
  const Site& s = ready.trial.site;
  AskedLog rows_out(log, s), past_out(history_log, s);
  Recorded out{{}, weather_to_write(s)};
  out.run = run(ready, method, begin());
  rows_out.write(out.run.control.rows);
  past_out.write(out.run.history);
  if (!out.weather.empty()) sim::write_epw(out.weather, *made_up_weather(plant), weather_year);
  out.run.metrics = metrics_of(s, out.run.control);
  return out;
}

Simulation::Days Simulation::controlled_days() const {
  constexpr std::int64_t day_s = 86400;
  const std::int64_t begin_s = start_of(plant).seconds + expert_days * day_s;
  const auto date = [](std::int64_t s) { return hal::civil_text({s}).substr(0, hal::date_text_size); };
  return {date(begin_s), date(begin_s + (days - 1) * day_s)};
}

nlohmann::json Simulation::json_of(const Ready& ready, const SimulatedRun& run) const {
  nlohmann::json j = tools::json_of(run.metrics);
  j["plant"] = run.plant;
  add_to(j, ready.facts);
  j["method"] = method;
  j["hold"] = text_of(ready.trial.site.settings.held.rule);
  j["room"] = plant.room;
  j["seeds"] = {plant.seed};
  j["days"] = days;
  j["scenario"] = plant.scenario;
  const Days controlled = controlled_days();
  j["from"] = controlled.from;
  j["to"] = controlled.to;
  j["digest"] = ready.blob.empty() ? "" : digest_text(ready.blob);
  j["rejected_updates"] = run.control.rejected_updates;
  std::vector<double> setpoints;
  for (const CycleSample& c : run.control.cycles) setpoints.push_back(c.setpoint_degc);
  j["setpoint_degc"] = setpoints;
  return j;
}

}  // namespace airside::tools
