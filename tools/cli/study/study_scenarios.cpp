// airside study scenarios: the product beside its peers in rooms that are harder than a summer's office.

#include <fmt/format.h>

#include <algorithm>

#include "hal/text/input_error.hpp"
#include "hal/text/staged_file.hpp"
#include "sim/scenarios/scenario.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/study/study.hpp"
#include "tools/run/child_jobs.hpp"
#include "tools/run/options/option_checks.hpp"
#include "tools/run/plant_choice.hpp"
#include "tools/run/run_facts.hpp"
#include "tools/run/training/built_in_residual.hpp"
#include "tools/run/training/pretraining.hpp"
#include "tools/run/training/residual_training.hpp"
#include "tools/study/control_methods.hpp"
#include "tools/study/table.hpp"

namespace airside::tools {

namespace {

struct ScenariosCommand : StudyOptions {
  static constexpr const char* ours = "ours-product";
  /// A day on which DAE is higher than the rival's by more than this counts as worse. degC.
  static constexpr double worse_margin_degc = 0.02;

  std::string out;
  std::vector<std::string> rooms, scenarios, methods = {head_alone, "integral-tuned", "arx-rls", "mpc"};
  int first_seed = 1, pretrain_days = 31, steps = 3000;

  ScenariosCommand() {
    seeds = 5;
    days = 14;
  }

  struct Job {
    std::string scenario, room;
    std::uint64_t seed;
    std::string name() const { return fmt::format("{}, room {} seed {}", scenario, room, seed); }
  };

  PlantChoice under(const std::string& scenario, const std::string& room, std::uint64_t seed) const {
    PlantChoice plant = choice(room, seed, std::string(sim::scenario("--scenarios", scenario).start));
    plant.scenario = scenario;
    return plant;
  }

  static std::string twin_of(const std::string& room) {
    return room.ends_with("-real") ? room.substr(0, room.size() - 5) : "rc";
  }

  /// DAE of each day, by method.
  std::string run_job(const Job& job) const {
    Trial trial{built_in_site(), under(job.scenario, job.room, job.seed), expert_days, days};
    trial.site.file.seed = job.seed;
    const auto twin = make_plant(choice(twin_of(job.room), job.seed, "2021-07-01"), trial.site, pretrain_days);
    PretrainOptions options;
    options.seed = job.seed;
    options.with_residual = false;
    const CivilTime until{twin->time().seconds + pretrain_days * seconds_per_day};
    const BlobBytes plain = pretrain(trial.site, *twin, until, options).blob;
    const BlobBytes blob = with_residual(trial.site, plain, built_in_residual(), "a study");
    nlohmann::json found;
    const auto keep = [&](const std::string& name, const ControlRun& run) {
      for (const DayMetrics& day : metrics_of(trial.site, run).days) found[name].push_back(day.dae_degc);
    };
    Prepared prepared = prepare(trial);
    keep(ours, run_ours(trial, prepared, {blob, true, steps}));
    for (const std::string& name : methods) {
      Prepared fresh = prepare(trial);
      keep(name, name == head_alone ? run_ours(trial, fresh, {plain, true, steps}) : run_method(trial, fresh, name));
    }
    return found.dump();
  }

  std::vector<Job> all_jobs() const {
    std::vector<Job> list;
    for (const std::string& scenario : scenarios) {
      for (const std::string& room : rooms) {
        for (int s = 0; s < seeds; ++s) list.push_back({scenario, room, static_cast<std::uint64_t>(first_seed + s)});
      }
    }
    return list;
  }

  void check(bool energyplus) {
    if (scenarios.empty()) {
      for (const sim::Scenario& s : sim::scenarios()) {
        if (energyplus ? s.on_energyplus : s.on_rc) scenarios.emplace_back(s.name);
      }
    }
    if (rooms.empty()) rooms = {"301-real", "401-real", "402-real", "701-real", "702-real"};
    for (const std::string& name : methods) {
      if (name != head_alone) check_method("--methods", name, energyplus);
    }
    for (const std::string& name : scenarios) {
      for (const std::string& room : rooms) (void)make_plant(under(name, room, 1), built_in_site(), 1);
    }
    if (!out.empty()) hal::StagedFile{out};  // can it be written at all?
  }

  /// Of one scenario: a method's mean DAE over runs, and the days on which ours was worse.
  nlohmann::json row_of(const std::string& scenario, const std::vector<Job>& list,
                        const std::vector<nlohmann::json>& found) const {
    nlohmann::json row = {{"scenario", scenario}};
    std::vector<std::string> all = methods;
    all.insert(all.begin(), ours);
    for (const std::string& name : all) {
      std::vector<double> values, ratios;
      int worse = 0, days_seen = 0;
      for (std::size_t i = 0; i < list.size(); ++i) {
        if (list[i].scenario != scenario) continue;
        const auto own = found[i].at(ours).get<std::vector<double>>(),
                   its = found[i].at(name).get<std::vector<double>>();
        double sum = 0, own_sum = 0;
        for (std::size_t d = 0; d < its.size(); ++d) {
          sum += its[d];
          own_sum += own[d];
          worse += own[d] > its[d] + worse_margin_degc ? 1 : 0;
          ++days_seen;
        }
        values.push_back(sum / static_cast<double>(its.size()));
        ratios.push_back(own_sum / sum);
      }
      const Spread dae = spread_of(values), ratio = spread_of(ratios);
      row["methods"][name] = {{"dae_degc", dae.mean}, {"sd", dae.sd},        {"days", days_seen},
                              {"worse_days", worse},  {"ratio", ratio.mean}, {"ratio_sd", ratio.sd}};
    }
    return row;
  }

  void run() {
    const PlantChoice usual = choice("301", 1, "2021-08-01");
    const bool energyplus = is_energyplus(usual, built_in_site());
    RunFacts facts = run_facts(usual, built_in_site());
    if (!energyplus) facts.weather = "another made-up year for each room and seed";
    kind = facts.plant;
    check(energyplus);
    say_fallback(facts);
    const std::vector<Job> list = all_jobs();
    Progress bar(fmt::format("{} scenarios x {} rooms x {} seeds", scenarios.size(), rooms.size(), seeds), list.size());
    const auto texts = run_children(
        list.size(), jobs, [&](std::size_t i) { return run_job(list[i]); },
        [&](std::size_t i) { return list[i].name(); }, [&bar] { bar.advance(); });
    bar.finish();
    std::vector<nlohmann::json> found;
    for (const std::string& text : texts) found.push_back(nlohmann::json::parse(text));
    nlohmann::json j;
    tools::add_to(j, facts);
    j["rooms"] = rooms;
    j["seeds"] = seeds;
    j["days"] = days;
    for (const std::string& name : scenarios) j["scenarios"].push_back(row_of(name, list, found));
    print(j, facts);
  }

  void print(const nlohmann::json& j, const RunFacts& facts) const {
    if (give_json(j, out, json)) return;
    fmt::print("| scenario | {} |", ours);
    for (const std::string& name : methods)
      fmt::print(" {} | ours / it | days worse than it by {:g} °C |", name, worse_margin_degc);
    fmt::print("\n|---|---|");
    for (std::size_t i = 0; i < methods.size(); ++i) fmt::print("---|---|---|");
    for (const nlohmann::json& row : j["scenarios"]) {
      const nlohmann::json& own = row["methods"][ours];
      fmt::print("\n| {} | {:.3f} ± {:.3f} |", row["scenario"].get<std::string>(), own["dae_degc"].get<double>(),
                 own["sd"].get<double>());
      for (const std::string& name : methods) {
        const nlohmann::json& its = row["methods"][name];
        fmt::print(" {:.3f} ± {:.3f} | {:.3f} ± {:.3f} | {} of {} |", its["dae_degc"].get<double>(),
                   its["sd"].get<double>(), its["ratio"].get<double>(), its["ratio_sd"].get<double>(),
                   its["worse_days"].get<int>(), its["days"].get<int>());
      }
    }
    fmt::print("\n\nDAE, °C, mean ± sd over rooms and seeds. By {}.\n", text_of(facts));
  }
};

}  // namespace

void add_study_scenarios(CLI::App& study) {
  auto self = std::make_shared<ScenariosCommand>();
  CLI::App* c = study.add_subcommand("scenarios",
                                     "rooms under conditions that are harder to control: pretrain on the twin in July, "
                                     "fine-tune on schedule days under\n"
                                     "the scenario, control, beside peers. Each row: mean DAE ± sd over rooms and "
                                     "seeds, and on how many days ours was\n"
                                     "further from the target than the peer by more than 0.02 °C.");
  self->add_to(*c, "controlled days");
  c->add_option("--rooms", self->rooms, "rooms, comma-separated (default: the five counterparts)")->delimiter(',');
  c->add_option("--scenarios", self->scenarios, "conditions, comma-separated (default: all that the plant knows)")
      ->delimiter(',');
  c->add_option("--methods", self->methods,
                "peers and floors, comma-separated; ours-head-alone: the product without its residual network")
      ->delimiter(',')
      ->capture_default_str();
  c->add_option("--first-seed", self->first_seed, "the others follow it")->check(seed_check())->capture_default_str();
  c->add_option("--pretrain-days", self->pretrain_days, "days of pretraining")
      ->check(CLI::Range(2, 364))
      ->capture_default_str();
  c->add_option("--steps", self->steps, "optimiser steps of the transfer")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  c->add_option("-o,--out", self->out, "JSON file with every figure");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
