// airside study nights: rooms whose AHU rests at night, and how each method gets them back in the morning.

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "hal/text/input_error.hpp"
#include "hal/text/staged_file.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/study/study.hpp"
#include "tools/run/child_jobs.hpp"
#include "tools/run/options/option_checks.hpp"
#include "tools/run/run_facts.hpp"
#include "tools/study/control_methods.hpp"
#include "tools/study/night_run.hpp"

namespace airside::tools {

namespace {

constexpr const char* ours = "ours-product";
constexpr std::array<const char*, 4> figure_names = {"first_hour_degc", "first_three_hours_degc", "working_degc",
                                                     "first_day_degc"};

struct NightsCommand : StudyOptions {
  std::string out;
  std::vector<std::string> rooms, methods = {"integral-tuned", "pid-tuned", "expert"};
  double fan_start_h = 6, fan_stop_h = 20;
  int first_seed = 1, pretrain_days = 31, steps = 3000;

  NightsCommand() {
    kind = "rc";
    seeds = 3;
    days = 14;
  }

  struct Job {
    std::size_t method;
    std::string room;
    std::uint64_t seed;
  };

  nlohmann::json run_job(const Job& job) const {
    const std::string twin = job.room.ends_with("-real") ? job.room.substr(0, job.room.size() - 5) : "rc";
    NightRun run;
    run.room = choice(job.room, job.seed, "2021-08-01");
    run.twin = choice(twin, job.seed, "2021-07-01");
    run.fan_start_h = fan_start_h;
    run.fan_stop_h = fan_stop_h;
    run.pretrain_days = pretrain_days;
    run.expert_days = expert_days;
    run.days = days;
    run.steps = steps;
    const NightFigures f = run_nights(run, methods[job.method]);
    return {{figure_names[0], f.first_hour_degc},
            {figure_names[1], f.first_three_hours_degc},
            {figure_names[2], f.working_degc},
            {figure_names[3], f.first_day_degc}};
  }

  /// Mean and sd of each figure, and of ours less it on the same room and seed.
  static nlohmann::json figures_of(const std::vector<nlohmann::json>& runs,
                                   const std::vector<nlohmann::json>& of_ours) {
    nlohmann::json row;
    for (const char* name : figure_names) {
      std::vector<double> values, ahead;
      for (std::size_t i = 0; i < runs.size(); ++i) {
        values.push_back(runs[i].at(name).get<double>());
        ahead.push_back(of_ours[i].at(name).get<double>() - values.back());
      }
      const Spread value = spread_of(values), less = spread_of(ahead);
      row[name] = {{"mean", value.mean},
                   {"sd", value.sd},
                   {"ours_less", less.mean},
                   {"ours_less_sd", less.sd},
                   {"ours_worst", *std::ranges::max_element(ahead)}};
    }
    return row;
  }

  void check() {
    if (kind == "energyplus")
      throw hal::InputError("--plant energyplus", "a plant whose fan keeps the hours of its model", "rc",
                            "leave it out");
    kind = "rc";
    if (fan_start_h >= fan_stop_h)
      throw hal::InputError("--fan-start", fmt::format("{:g} h", fan_start_h), "an hour before --fan-stop",
                            "exchange the two");
    if (rooms.empty())
      rooms = {"301-real", "401-real", "402-real", "701-real", "702-real", "study-5", "study-6", "study-7"};
    for (const std::string& name : methods) check_method("--methods", name, false);
    for (const std::string& room : rooms) check_room(choice(room, 1, "2021-08-01"), built_in_site());
    if (!out.empty()) hal::StagedFile{out};  // can it be written at all?
    methods.insert(methods.begin(), ours);
  }

  void run() {
    check();
    RunFacts facts = run_facts(choice(rooms.front(), 1, "2021-08-01"), built_in_site());
    facts.weather = "another made-up year for each room and seed";
    std::vector<Job> list;
    for (std::size_t m = 0; m < methods.size(); ++m) {
      for (const std::string& room : rooms) {
        for (int s = 0; s < seeds; ++s) list.push_back({m, room, static_cast<std::uint64_t>(first_seed + s)});
      }
    }
    Progress bar(fmt::format("{} methods x {} rooms x {} seeds", methods.size(), rooms.size(), seeds), list.size());
    const auto texts = run_children(
        list.size(), jobs, [&](std::size_t i) { return run_job(list[i]).dump(); },
        [&](std::size_t i) {
          return fmt::format("{}, room {} seed {}", methods[list[i].method], list[i].room, list[i].seed);
        },
        [&bar] { bar.advance(); });
    bar.finish();
    std::vector<std::vector<nlohmann::json>> runs(methods.size());
    for (std::size_t i = 0; i < list.size(); ++i) runs[list[i].method].push_back(nlohmann::json::parse(texts[i]));
    nlohmann::json j;
    tools::add_to(j, facts);
    j["rooms"] = rooms;
    for (int s = 0; s < seeds; ++s) j["seeds"].push_back(first_seed + s);
    j["days"] = days;
    j["fan_start_h"] = fan_start_h;
    j["fan_stop_h"] = fan_stop_h;
    for (std::size_t m = 0; m < methods.size(); ++m) {
      nlohmann::json row = figures_of(runs[m], runs[0]);
      row["method"] = methods[m];
      row["runs"] = runs[m];
      j["methods"].push_back(row);
    }
    print(j, facts);
  }

  void print(const nlohmann::json& j, const RunFacts& facts) const {
    if (give_json(j, out, json)) return;
    fmt::print("| method | first hour °C | first 3 hours °C | working hours °C | day 1, first 3 hours °C |\n");
    fmt::print("|---|---|---|---|---|\n");
    for (const nlohmann::json& row : j["methods"]) {
      fmt::print("| {} |", row["method"].get<std::string>());
      for (const char* name : figure_names)
        fmt::print(" {:.3f} ± {:.3f} |", row[name]["mean"].get<double>(), row[name]["sd"].get<double>());
      fmt::print("\n");
    }
    fmt::print("\nOurs less the others, room by room and seed by seed: mean ± sd (worst).\n\n");
    fmt::print("| beside | first hour °C | first 3 hours °C | working hours °C | day 1, first 3 hours °C |\n");
    fmt::print("|---|---|---|---|---|\n");
    for (std::size_t m = 1; m < methods.size(); ++m) {
      fmt::print("| {} |", methods[m]);
      for (const char* name : figure_names) {
        const nlohmann::json& f = j["methods"][m][name];
        fmt::print(" {:+.3f} ± {:.3f} ({:+.3f}) |", f["ours_less"].get<double>(), f["ours_less_sd"].get<double>(),
                   f["ours_worst"].get<double>());
      }
      fmt::print("\n");
    }
    fmt::print("\nBy {}.\n", text_of(facts));
  }
};

}  // namespace

void add_study_nights(CLI::App& study) {
  auto self = std::make_shared<NightsCommand>();
  CLI::App* c = study.add_subcommand(
      "nights",
      "rooms of the RC plant whose AHU rests at night: mean distance from the target in the first hours after the\n"
      "fan's start, ours beside tuned peers and the schedule. Twin, schedule days and controlled days rest alike.\n"
      "Each row: mean ± sd over rooms and seeds; then ours less each other on the same room and seed.");
  self->add_to(*c, "controlled days");
  c->add_option("--rooms", self->rooms, "rooms, comma-separated (default: the five counterparts and three more)")
      ->delimiter(',');
  c->add_option("--first-seed", self->first_seed, "the others follow it")->check(seed_check())->capture_default_str();
  c->add_option("--methods", self->methods, "peers, comma-separated")->delimiter(',')->capture_default_str();
  c->add_option("--fan-start", self->fan_start_h, "hour of the day at which the fan starts; 6.17: between two cycles")
      ->check(CLI::Range(0.0, 12.0))
      ->capture_default_str();
  c->add_option("--fan-stop", self->fan_stop_h, "hour at which it stops")
      ->check(CLI::Range(12.0, 24.0))
      ->capture_default_str();
  c->add_option("--pretrain-days", self->pretrain_days, "days of pretraining")
      ->check(CLI::Range(2, 364))
      ->capture_default_str();
  c->add_option("--steps", self->steps, "optimiser steps of the transfer")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  c->add_option("-o,--out", self->out, "JSON file with every run");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
