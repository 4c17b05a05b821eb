// airside pretrain: weights from a simulated room, before anything is installed.

#include <fmt/format.h>

#include <map>
#include <optional>
#include <set>
#include <string>

#include "hal/log/log_csv.hpp"
#include "hal/text/civil_text.hpp"
#include "sim/plant_model.hpp"
#include "tools/cli/command.hpp"
#include "tools/run/plant_choice.hpp"
#include "tools/run/run_facts.hpp"
#include "tools/run/training/blob_place.hpp"
#include "tools/run/training/pretraining.hpp"

namespace airside::tools {

namespace {

const std::map<std::string, Pretrainer> static_schedules = {{"drawn", Pretrainer::drawn_schedules},
                                                            {"expert", Pretrainer::expert_schedule}};

struct PretrainCommand {
  SiteOptions site;
  PlantChoice plant;
  int days = 31;
  int updates = 0;
  Pretrainer pretrainer = Pretrainer::agent;
  bool json = false, no_residual = false;
  std::string out = "weights.blob", log;

  void run(const CLI::App& command) {
    const Site s = make_site(site);
    if (s.file.objective == Objective::band) {
      say_not_needed(s);
      return;
    }
    take_site_twin(command, plant, s, TwinUse::unless_named);
    take_scenario_start(command, plant);
    const RunFacts facts = run_facts(plant, s);
    check_room(plant, s);
    BlobPlace place(out, most_blob_bytes(s));
    std::optional<hal::LogWriter> writer;
    if (!log.empty()) writer.emplace(log, s.counts, true);
    const auto model = make_plant(plant, s, days);
    const CivilTime until{start_of(plant).seconds + days * std::int64_t{86400}};
    say_fallback(facts);
    Progress bar("pretraining on " + model->description(), progress_steps);
    PretrainOptions options;
    options.seed = plant.seed;
    options.updates_per_cycle = updates;
    options.pretrainer = pretrainer;
    options.with_residual = !no_residual;
    options.provenance = fmt::format("airside pretrain {}{} --days {}{}{}{} ({})", command_text(plant, s),
                                     command_text(site), days, updates > 0 ? fmt::format(" --updates {}", updates) : "",
                                     static_text(), no_residual ? " --no-residual" : "", model->description());
    const Pretraining trained = pretrain(s, *model, until, options, show_progress(bar));
    bar.finish();
    place.write(trained.blob);
    if (writer) {
      for (const hal::LogRow& row : trained.run.rows) writer->append(row);
      writer->close();
    }
    const Metrics m = metrics_of(s, trained.run);
    if (json) {
      nlohmann::json j = json_of(m);
      j["blob"] = out;
      j["blob_bytes"] = trained.blob.size();
      j["digest"] = digest_text(trained.blob);
      j["days"] = days;
      j["seeds"] = {plant.seed};
      j["transitions"] = trained.transitions;
      j["optimiser_steps"] = trained.run.optimiser_steps;
      j["rejected_updates"] = trained.run.rejected_updates;
      j["plant"] = model->description();
      add_to(j, facts);
      fmt::print("{}\n", j.dump());
      return;
    }
    fmt::print("daily DAE while it learned, degC:");
    const int last = static_cast<int>(m.days.size());
    for (const int day : std::set<int>{1, 2, 3, 6, 7, 14, 31, last}) {
      if (day <= last) fmt::print("  day {} {:.3f}", day, m.days[static_cast<std::size_t>(day - 1)].dae_degc);
    }
    fmt::print("\n({})\n{} transitions, {} optimiser steps\nweights: {} ({} bytes, digest {})\nby {}\n",
               pretrainer == Pretrainer::agent ? "day 1 is the schedule's; the agent acts from day 2"
                                               : "schedules act on all days, training follows",
               trained.transitions, trained.run.optimiser_steps, out, trained.blob.size(), digest_text(trained.blob),
               text_of(facts));
  }

  /// For a site with the objective "band", so that a recipe may pretrain every site.
  void say_not_needed(const Site& s) const {
    if (json) {
      fmt::print("{}\n", nlohmann::json{{"needed", false}, {"objective", "band"}, {"blob", nullptr}}.dump());
    } else {
      fmt::print("not needed: {} has objective = \"band\", which learns on the box; no weights were written\n",
                 s.file.path);
    }
  }

  /// As the command had it.
  std::string static_text() const {
    for (const auto& [name, which] : static_schedules) {
      if (which == pretrainer) return " --static " + name;
    }
    return "";
  }
};

}  // namespace

void add_pretrain(CLI::App& app) {
  auto self = std::make_shared<PretrainCommand>();
  CLI::App* c =
      app.add_subcommand("pretrain",
                         "train weights in the loop with a simulated room.\n"
                         "Model, patches and weather are those of the site's [twin] where no option names "
                         "others; without\neither, the built-in twin of --room. A site with objective = \"band\" needs "
                         "no weights: none are written.");
  add_site_options(*c, self->site);
  add_plant_options(*c, self->plant);
  c->add_option("--days", self->days, "length; day 1 runs the schedule and fits the scaler")
      ->check(CLI::Range(2, 364))
      ->capture_default_str();
  c->add_option("--updates", self->updates, "optimiser steps a cycle (default: the preset's)")
      ->check(CLI::Range(1, 100));
  c->add_option_function<std::string>(
       "--static", [self](const std::string& name) { self->pretrainer = static_schedules.at(name); },
       "fixed schedules instead of the agent, as a plain data set of as many transitions and optimiser steps: each "
       "day's working setpoint drawn (default), or the expert's")
      ->expected(0, 1)
      ->default_str("drawn")
      ->check(CLI::IsMember({"drawn", "expert"}));
  c->add_flag("--no-residual", self->no_residual,
              "without the built-in network that predicts what the room head gets wrong (airside residual makes one "
              "for your own rooms)");
  c->add_option("-o,--out", self->out, "blob to write")->capture_default_str();
  c->add_option("--log", self->log, "CSV of all rows");
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->callback([self, c] { self->run(*c); });
}

}  // namespace airside::tools
