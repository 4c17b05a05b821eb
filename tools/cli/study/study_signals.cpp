// airside study signals: what each signal that a site lacks costs in the rooms.

#include <fmt/format.h>

#include "hal/text/staged_file.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/study/study.hpp"
#include "tools/run/child_jobs.hpp"
#include "tools/run/options/option_checks.hpp"
#include "tools/run/plant_choice.hpp"
#include "tools/run/run_facts.hpp"
#include "tools/run/training/pretraining.hpp"
#include "tools/study/control_methods.hpp"
#include "tools/study/missing_signals.hpp"

namespace airside::tools {

namespace {

using nlohmann::json;

/// What uses room temperatures alone, for comparison.
constexpr const char* rooms_only_peer = "integral-tuned";

struct SignalsCommand {
  std::string kind = "auto", out;
  std::vector<std::string> rooms;
  int seeds = 3, first_seed = 1, pretrain_days = 31, expert_days = 5, days = 14, steps = 3000, jobs = 2;
  bool as_json = false;
  RunFacts facts;

  struct Job {
    std::size_t lacking;  ///< of the cases; one beyond them is the peer
    std::string room;
    std::uint64_t seed;
  };

  PlantChoice choice(const std::string& room, std::uint64_t seed, const char* start) const {
    PlantChoice c;
    c.kind = kind;
    c.room = room;
    c.seed = seed;
    c.start = start;
    return c;
  }

  std::string twin_of(const std::string& room) const {
    if (room.ends_with("-real")) return room.substr(0, room.size() - 5);
    return kind == "rc" ? "rc" : "301";
  }

  /// Pretraining on the twin, transfer by the schedule's days, control: each without the same signals.
  json run_job(const Job& job, const std::vector<MissingSignals>& cases) const {
    const bool is_peer = job.lacking == cases.size();
    const hal::StandIns stand_ins = is_peer ? hal::StandIns{} : cases[job.lacking].stand_ins;
    Trial trial{with_stand_ins(built_in_site(), stand_ins), choice(job.room, job.seed, "2021-08-01"), expert_days,
                days};
    trial.site.file.seed = job.seed;
    Prepared prepared = prepare(trial);
    if (is_peer) return json_of(metrics_of(trial.site, run_method(trial, prepared, rooms_only_peer)));
    const auto twin = make_plant(choice(twin_of(job.room), job.seed, "2021-07-01"), trial.site, pretrain_days);
    PretrainOptions options;
    options.seed = job.seed;
    const CivilTime until{twin->time().seconds + pretrain_days * std::int64_t{86400}};
    const BlobBytes blob = pretrain(trial.site, *twin, until, options).blob;
    return json_of(metrics_of(trial.site, run_ours(trial, prepared, {blob, true, steps})));
  }

  /// Mean and sd of a figure over rooms and seeds, and of its difference from the run that lacks nothing.
  static json figures(const std::vector<json>& runs, const std::vector<json>& whole) {
    json of;
    for (const char* name : {"dae_degc", "day1_dae_degc", "me_degc", "darv_degc"}) {
      std::vector<double> values, costs;
      for (std::size_t i = 0; i < runs.size(); ++i) {
        values.push_back(runs[i].at(name).get<double>());
        costs.push_back(values.back() - whole[i].at(name).get<double>());
      }
      const Spread value = spread_of(values), cost = spread_of(costs);
      of[name] = {{"mean", value.mean}, {"sd", value.sd}, {"cost", cost.mean}, {"cost_sd", cost.sd}};
    }
    return of;
  }

  void run() {
    facts = run_facts(choice("301", 1, "2021-07-01"), built_in_site());
    kind = facts.plant;
    if (kind == "rc") facts.weather = "another made-up year for each room and seed";
    if (rooms.empty()) rooms = {"301-real", "401-real", "402-real", "701-real", "702-real"};
    for (const std::string& room : rooms) (void)make_plant(choice(room, 1, "2021-08-01"), built_in_site(), 1);
    if (!out.empty()) hal::StagedFile{out};  // can it be written at all?
    say_fallback(facts);
    const hal::TopologyCounts& counts = built_in_site().counts;
    const std::vector<MissingSignals> cases = missing_signal_cases({counts.vavs, counts.fcus, counts.powers});
    std::vector<Job> list;
    for (std::size_t c = 0; c <= cases.size(); ++c) {
      for (const std::string& room : rooms) {
        for (int s = 0; s < seeds; ++s) list.push_back({c, room, static_cast<std::uint64_t>(first_seed + s)});
      }
    }
    const auto name_of = [&](std::size_t c) {
      return c == cases.size() ? std::string(rooms_only_peer) : "without " + cases[c].name;
    };
    Progress bar(fmt::format("{} sites x {} rooms x {} seeds", cases.size(), rooms.size(), seeds), list.size());
    const auto texts = run_children(
        list.size(), jobs, [&](std::size_t i) { return run_job(list[i], cases).dump(); },
        [&](std::size_t i) {
          return fmt::format("{}, room {} seed {}", name_of(list[i].lacking), list[i].room, list[i].seed);
        },
        [&bar] { bar.advance(); });
    bar.finish();
    std::vector<std::vector<json>> runs(cases.size() + 1);
    for (std::size_t i = 0; i < list.size(); ++i) runs[list[i].lacking].push_back(json::parse(texts[i]));
    json j;
    add_to(j, facts);
    j["rooms"] = rooms;
    for (int s = 0; s < seeds; ++s) j["seeds"].push_back(first_seed + s);
    j["days"] = days;
    for (std::size_t c = 0; c < runs.size(); ++c) {
      json row = figures(runs[c], runs[0]);
      row["missing"] = c < cases.size() ? cases[c].name : "";
      row["method"] = c < cases.size() ? "ours-product" : rooms_only_peer;
      j["sites"].push_back(row);
    }
    print(j);
  }

  void print(const json& j) const {
    if (give_json(j, out, as_json)) return;
    fmt::print("| missing | DAE °C | its cost °C | day 1 °C | its cost °C | ME °C |\n|---|---|---|---|---|---|\n");
    for (const json& row : j["sites"]) {
      const std::string name =
          row["method"] == rooms_only_peer ? fmt::format("({})", rooms_only_peer) : row["missing"].get<std::string>();
      const auto value = [&row](const char* figure, const char* of) { return row[figure][of].get<double>(); };
      fmt::print("| {} | {:.3f} ± {:.3f} | {:+.3f} ± {:.3f} | {:.3f} ± {:.3f} | {:+.3f} | {:.3f} |\n", name,
                 value("dae_degc", "mean"), value("dae_degc", "sd"), value("dae_degc", "cost"),
                 value("dae_degc", "cost_sd"), value("day1_dae_degc", "mean"), value("day1_dae_degc", "sd"),
                 value("day1_dae_degc", "cost"), value("me_degc", "mean"));
    }
    fmt::print("\nBy {}.\n", text_of(facts));
  }
};

}  // namespace

void add_study_signals(CLI::App& study) {
  auto self = std::make_shared<SignalsCommand>();
  CLI::App* c = study.add_subcommand(
      "signals",
      "what each signal that a site lacks costs in the rooms: pretrain on the twin, fine-tune on schedule days and\n"
      "control, each without it and with the usual number in its place. Each row: mean ± sd over rooms and seeds;\n"
      "the cost is the difference from the same room and seed with all signals. `airside check` says these figures.");
  c->add_option("--plant", self->kind, "rc, energyplus, or auto")
      ->check(CLI::IsMember({"auto", "rc", "energyplus"}))
      ->capture_default_str();
  c->add_option("--rooms", self->rooms, "rooms, comma-separated (default: the five counterparts)")->delimiter(',');
  c->add_option("--seeds", self->seeds, "seeds a room")->check(CLI::Range(1, 100))->capture_default_str();
  c->add_option("--first-seed", self->first_seed, "the others follow it")->check(seed_check())->capture_default_str();
  c->add_option("--pretrain-days", self->pretrain_days, "days of pretraining")
      ->check(CLI::Range(2, 364))
      ->capture_default_str();
  c->add_option("--steps", self->steps, "optimiser steps of the transfer")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  c->add_option("--expert-days", self->expert_days, "days under the schedule before")
      ->check(CLI::Range(1, 60))
      ->capture_default_str();
  c->add_option("--days", self->days, "controlled days")->check(CLI::Range(1, 300))->capture_default_str();
  c->add_option("--jobs", self->jobs, "child processes at a time")->check(CLI::Range(1, 256))->capture_default_str();
  c->add_option("-o,--out", self->out, "JSON file with every figure");
  c->add_flag("--json", self->as_json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
