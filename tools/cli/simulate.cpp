// airside simulate: the box's code on a simulated room, with a report beside what else could have been done.

#include <fmt/format.h>

#include <optional>

#include "hal/text/shell_word.hpp"
#include "tools/cli/simulation.hpp"
#include "tools/report/report.hpp"
#include "tools/report/run_record.hpp"

namespace airside::tools {

namespace {

struct SimulateCommand : Simulation {
  std::string report;
  std::vector<std::string> compare;
  bool json = false;

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

  std::string period_text() const {
    const Days controlled = controlled_days();
    std::string text = controlled.from + " to " + controlled.to;
    if (expert_days > 0)
      text += fmt::format(", after {} day{} under the schedule", expert_days, expert_days == 1 ? "" : "s");
    return text + (plant.scenario.empty() ? ", no scenario" : ", scenario " + plant.scenario);
  }

  void run(const CLI::App& command) {
    const Site chosen = make_site(site);
    take_site_twin(command, plant, chosen, TwinUse::when_asked);
    take_scenario_start(command, plant);
    steps_given = command.count("--steps") > 0;
    const Ready ready = make_ready(chosen, compare);
    const Trial& trial = ready.trial;
    say_fallback(ready.facts);
    std::optional<Progress> bar;
    const auto shown = [&](const std::string& name) {
      bar.emplace(fmt::format("{} on room {}", name, plant.room), progress_steps);
      return show_progress(*bar);
    };
    const auto [first, weather_log] = run_recorded(ready, [&] { return shown(method); });
    bar->finish();
    if (!weather_log.empty()) fmt::print(stderr, "the weather of the log: {}\n", weather_log);
    const Metrics& metrics = first.metrics;
    std::vector<MethodResult> results{{method, MethodResult::Kind::ours, {metrics}}};
    for (const std::string& name : compare) {
      const auto kind = name == "expert"             ? MethodResult::Kind::schedule
                        : name.starts_with("floor-") ? MethodResult::Kind::floor
                                                     : MethodResult::Kind::peer;
      const SimulatedRun other = Simulation::run(ready, name, shown(name));
      bar->finish();
      results.push_back({name, kind, {metrics_of(trial.site, other.control)}});
    }
    if (!report.empty()) {
      RunRecord record = make_run_record(trial.site, first.control);
      record.plant = first.plant;
      record.weather = ready.facts.weather;
      record.versions = program_text() + ", " + ready.facts.engine;
      record.seeds = fmt::format("{}", plant.seed);
      record.weights_digest = ready.blob.empty() ? "none" : digest_text(ready.blob);
      record.command = again(trial.site);
      record.methods = results;
      const auto files = write_report(std::filesystem::path(report) / "index.html", make_run_report(record));
      fmt::print(stderr, "report: {}\n", files.front().string());
    }
    if (json) {
      nlohmann::json j = Simulation::json_of(ready, first);
      for (std::size_t i = 1; i < results.size(); ++i)
        j["compared"][results[i].name] = tools::json_of(results[i].runs.front());
      fmt::print("{}\n", j.dump());
      return;
    }
    print_figures_header();
    for (const MethodResult& r : results) print_figures(r.name, r.runs.front());
    fmt::print("on {}\nfrom {}\nby {}\n", first.plant, period_text(), text_of(ready.facts));
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
