// airside simulate: the box's code on a simulated room, with a report beside what else could have been done.

#include <fmt/format.h>

#include <optional>

#include "hal/log/log_csv.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/shell_word.hpp"
#include "sim/rc/modulating_room.hpp"
#include "sim/weather/epw.hpp"
#include "tools/cli/command.hpp"
#include "tools/report/report.hpp"
#include "tools/report/run_record.hpp"
#include "tools/run/log_weather.hpp"
#include "tools/run/run_facts.hpp"
#include "tools/study/control_methods.hpp"

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

struct SimulateCommand {
  SiteOptions site;
  PlantChoice plant;
  int expert_days = 5, days = 14, steps = 3000;
  std::string method = "ours", weights, history, log, history_log, report, faults;
  std::vector<std::string> compare;
  bool transfer = false, json = false;

  std::string again(const Site& s) const {
    std::string text = fmt::format("airside simulate {} --expert-days {} --days {} --method {}{}",
                                   command_text(plant, s), expert_days, days, method, command_text(site));
    if (!history.empty()) text += " --history " + hal::shell_word(history);
    if (!weights.empty()) text += " --weights " + hal::shell_word(weights);
    if (transfer) text += fmt::format(" --transfer --steps {}", steps);
    if (!faults.empty()) text += " --faults " + hal::shell_word(faults);
    if (!compare.empty()) text += fmt::format(" --compare {}", fmt::join(compare, ","));
    return text;
  }

  /// What the first of the compared methods also leaves.
  struct Before {
    std::vector<hal::LogRow> history;
    std::string plant;  ///< its description: making a plant for that would start another engine
  };

  ControlRun run_one(const Trial& trial, const std::string& name, const BlobBytes& blob, Before* before) const {
    Progress bar(fmt::format("{} on room {}", name, plant.room), progress_steps);
    Prepared prepared = prepare(trial);
    if (!history.empty()) prepared.history = hal::read_log(history, trial.site.counts).rows;
    if (before != nullptr) *before = {prepared.history, prepared.model->description()};
    ControlRun run = name == "ours" ? run_ours(trial, prepared, {blob, transfer, steps}, show_progress(bar))
                                    : run_method(trial, prepared, name, show_progress(bar));
    bar.finish();
    return run;
  }

  /// The made-up year of a simulated log is in no file: it goes beside the log, for what reads weather and log.
  std::string weather_to_write(const Site& s) const {
    if (log.empty() || !plant.weather.empty() || !plant.environment.empty() || is_energyplus(plant, s)) return "";
    const std::string path = weather_beside(log);
    return path == log ? "" : path;
  }

  /// What ours starts from: weights, but nothing for the objective band, which learns on the box from what boxes show.
  void check_start(Objective objective, bool engine) const {
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

  void run(const CLI::App& command) {
    const Site chosen = make_site(site);
    take_site_twin(command, plant, chosen, TwinUse::when_asked);
    take_scenario_start(command, plant);
    Trial trial{chosen, plant, expert_days, days};
    trial.site.file.seed = plant.seed;
    if (!faults.empty()) trial.faults = sim::read_fault_script(faults, trial.site.counts);
    if (site.path.empty()) trial.site.file.name = "Room " + plant.room;  // "built-in" says nothing in a report
    const bool engine = is_energyplus(plant, trial.site);
    bool ours = method == "ours";
    if (!ours) check_method("--method", method, engine);
    for (const std::string& name : compare) {
      if (name != "ours") check_method("--compare", name, engine);
      ours = ours || name == "ours";
    }
    check_room(plant, trial.site);
    const RunFacts facts = run_facts(plant, trial.site);
    BlobBytes blob;
    if (ours) {
      check_start(trial.site.settings.objective, engine);
      if (!weights.empty()) blob = read_blob(weights, trial.site);
    }
    AskedLog rows_out(log, trial.site), past_out(history_log, trial.site);
    const std::string weather_log = weather_to_write(trial.site);
    say_fallback(facts);
    Before before;
    const ControlRun run = run_one(trial, method, blob, &before);
    rows_out.write(run.rows);
    past_out.write(before.history);
    if (!weather_log.empty()) {
      sim::write_epw(weather_log, *made_up_weather(plant), weather_year);
      fmt::print(stderr, "the weather of the log: {}\n", weather_log);
    }
    const Metrics metrics = metrics_of(trial.site, run);
    std::vector<MethodResult> results{{method, MethodResult::Kind::ours, {metrics}}};
    for (const std::string& name : compare) {
      const auto kind = name == "expert"             ? MethodResult::Kind::schedule
                        : name.starts_with("floor-") ? MethodResult::Kind::floor
                                                     : MethodResult::Kind::peer;
      results.push_back({name, kind, {metrics_of(trial.site, run_one(trial, name, blob, nullptr))}});
    }
    const std::string& description = before.plant;
    if (!report.empty()) {
      RunRecord record = make_run_record(trial.site, run);
      record.plant = description;
      record.weather = facts.weather;
      record.versions = program_text() + ", " + facts.engine;
      record.seeds = fmt::format("{}", plant.seed);
      record.weights_digest = blob.empty() ? "none" : digest_text(blob);
      record.command = again(trial.site);
      record.methods = results;
      const auto files = write_report(std::filesystem::path(report) / "index.html", make_run_report(record));
      fmt::print(stderr, "report: {}\n", files.front().string());
    }
    if (json) {
      nlohmann::json j = json_of(metrics);
      j["plant"] = description;
      add_to(j, facts);
      j["method"] = method;
      j["hold"] = text_of(trial.site.settings.held.rule);
      j["room"] = plant.room;
      j["seeds"] = {plant.seed};
      j["days"] = days;
      j["digest"] = blob.empty() ? "" : digest_text(blob);
      j["rejected_updates"] = run.rejected_updates;
      std::vector<double> setpoints;
      for (const CycleSample& c : run.cycles) setpoints.push_back(c.setpoint_degc);
      j["setpoint_degc"] = setpoints;
      for (std::size_t i = 1; i < results.size(); ++i)
        j["compared"][results[i].name] = json_of(results[i].runs.front());
      fmt::print("{}\n", j.dump());
      return;
    }
    print_figures_header();
    for (const MethodResult& r : results) print_figures(r.name, r.runs.front());
    fmt::print("on {}\nby {}\n", description, text_of(facts));
  }
};

}  // namespace

void add_simulate(CLI::App& app) {
  auto self = std::make_shared<SimulateCommand>();
  CLI::App* c = app.add_subcommand("simulate",
                                   "control a simulated room with the box's own code, and report how it went.\n"
                                   "The schedule runs --expert-days first; then --days are controlled and scored.\n"
                                   "The room stands for the built one: the site's [twin], a model to train on, is "
                                   "taken\nwhere --twin says so.");
  add_site_options(*c, self->site);
  add_plant_options(*c, self->plant, "2021-08-01");
  c->add_option("--expert-days", self->expert_days, "days under the schedule before")
      ->check(CLI::Range(0, 60))
      ->capture_default_str();
  c->add_option("--days", self->days, "controlled days")->check(CLI::Range(1, 300))->capture_default_str();
  c->add_option("--method", self->method,
                "ours, expert, pid-tuned, integral-tuned, arx-rls, floor-full, ... (a wrong name lists all)")
      ->capture_default_str();
  c->add_option("--weights", self->weights, "blob to start from");
  c->add_flag("--transfer", self->transfer, "fine-tune on the schedule's days first, as airside transfer does");
  c->add_option("--steps", self->steps, "optimiser steps of --transfer")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  c->add_option("--history", self->history, "log whose rows are remembered instead of the simulated schedule days");
  c->add_option(
      "--faults", self->faults,
      "CSV of faults of sensors and AHU in the controlled days (docs/formats.md, \"Faults of a simulated room\")");
  c->add_option("--compare", self->compare, "further methods on the same days, comma-separated")->delimiter(',');
  c->add_option("--log", self->log,
                "CSV of the controlled rows; on rc without --weather the made-up weather goes into NAME.epw beside it");
  c->add_option("--history-log", self->history_log, "CSV of the schedule days' rows");
  c->add_option("--report", self->report, "folder for an HTML report with charts");
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->callback([self, c] { self->run(*c); });
}

}  // namespace airside::tools
