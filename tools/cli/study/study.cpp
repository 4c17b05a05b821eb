// airside study rooms: every method on several rooms and seeds, the tables of docs/results.md.

#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <map>

#include "hal/text/input_error.hpp"
#include "hal/text/staged_file.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/study/study.hpp"
#include "tools/run/child_jobs.hpp"
#include "tools/run/options/option_checks.hpp"
#include "tools/run/run_facts.hpp"
#include "tools/run/training/built_in_residual.hpp"
#include "tools/run/training/pretraining.hpp"
#include "tools/run/training/residual_training.hpp"
#include "tools/study/control_methods.hpp"
#include "tools/study/table.hpp"

namespace airside::tools {

namespace {

/// A day on which DAE is higher by more than this counts as worse. degC.
constexpr double worse_margin_degc = 0.02;
/// What `product` is compared with day by day.
constexpr const char* rival = "integral-tuned";

struct StudyCommand : StudyOptions {
  std::string out, twin_room;
  std::vector<std::string> rooms, methods;
  int room_count = 12, first_seed = 1, pretrain_days = 31, updates = 0, steps = 3000;
  bool no_paper = false;
  RunFacts facts;

  StudyCommand() {
    seeds = 5;
    days = 14;
  }

  struct Job {
    std::string room;
    std::uint64_t seed;
  };

  /// The twin's room of "401-real" is 401; a generated room's is rc's own.
  std::string twin_of(const std::string& room) const {
    if (!twin_room.empty()) return twin_room;
    if (room.ends_with("-real")) return room.substr(0, room.size() - 5);
    return kind == "rc" ? "rc" : "301";
  }

  /// A pretraining that several rooms share.
  struct Source {
    std::string twin, preset;
    std::uint64_t seed;
    auto operator<=>(const Source&) const = default;
  };

  std::vector<std::string> presets() const {
    return no_paper ? std::vector<std::string>{"product"} : hal::preset_names();
  }

  static Site site_of(const std::string& preset) {
    return built_in_site("5vav-5fcu-2power", hal::preset_named(preset));
  }

  std::string pretrain_source(const Source& source) const {
    const Site site = site_of(source.preset);
    const auto twin = make_plant(choice(source.twin, source.seed, "2021-07-01"), site, pretrain_days);
    PretrainOptions options;
    options.seed = source.seed;
    options.updates_per_cycle = updates;
    options.with_residual = false;
    const CivilTime until{twin->time().seconds + pretrain_days * std::int64_t{86400}};
    const BlobBytes blob = pretrain(site, *twin, until, options).blob;
    return {reinterpret_cast<const char*>(blob.data()), blob.size()};
  }

  Outcome run_job(const Job& job, const std::map<Source, std::string>& sources) const {
    Outcome outcome;
    const auto trial_of = [&](const std::string& preset) {
      Trial trial{site_of(preset), choice(job.room, job.seed, "2021-08-01"), expert_days, days};
      trial.site.file.seed = job.seed;
      return trial;
    };
    const auto run_weights = [&](const std::string& name, const Trial& trial, const BlobBytes& blob) {
      Prepared prepared = prepare(trial);
      outcome[name] = json_of(metrics_of(trial.site, run_ours(trial, prepared, {blob, true, steps})));
    };
    for (const std::string& preset : presets()) {
      const std::string& text = sources.at({twin_of(job.room), preset, job.seed});
      const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
      const BlobBytes plain(bytes, bytes + text.size());
      const Trial trial = trial_of(preset);
      if (preset != "product") {
        run_weights("ours-" + preset, trial, plain);
        continue;
      }
      run_weights(head_alone, trial, plain);
      run_weights("ours-product", trial, with_residual(trial.site, plain, built_in_residual(), "a study"));
    }
    const Trial trial = trial_of("product");
    Prepared again = prepare(trial);
    outcome["ours-scratch"] = json_of(metrics_of(trial.site, run_ours(trial, again, {{}, true, steps})));
    for (const std::string& name : methods) {
      Prepared fresh = prepare(trial);
      outcome[name] = json_of(metrics_of(trial.site, run_method(trial, fresh, name)));
    }
    return outcome;
  }

  std::vector<Outcome> run_all(const std::vector<Job>& list) const {
    std::map<Source, std::string> sources;
    for (const Job& job : list) {
      for (const std::string& preset : presets()) sources[{twin_of(job.room), preset, job.seed}];
    }
    std::vector<Source> order;
    for (const auto& [source, blob] : sources) order.push_back(source);
    {
      Progress bar(fmt::format("pretraining {} models", order.size()), order.size());
      const auto blobs = run_children(
          order.size(), jobs, [&](std::size_t i) { return pretrain_source(order[i]); },
          [&](std::size_t i) { return fmt::format("pretraining on {}, seed {}", order[i].twin, order[i].seed); },
          [&bar] { bar.advance(); });
      for (std::size_t i = 0; i < order.size(); ++i) sources[order[i]] = blobs[i];
      bar.finish();
    }
    Progress bar(fmt::format("{} rooms x {} seeds", rooms.size(), seeds), list.size());
    const auto texts = run_children(
        list.size(), jobs, [&](std::size_t i) { return nlohmann::json(run_job(list[i], sources)).dump(); },
        [&](std::size_t i) { return fmt::format("room {} seed {}", list[i].room, list[i].seed); },
        [&bar] { bar.advance(); });
    bar.finish();
    std::vector<Outcome> outcomes;
    for (const std::string& text : texts) outcomes.push_back(nlohmann::json::parse(text).get<Outcome>());
    return outcomes;
  }

  void check_before_the_long_part(bool energyplus) const {
    for (const std::string& name : methods) check_method("--methods", name, energyplus);
    for (const std::string& room : rooms) {
      for (const std::string& name : {room, twin_of(room)}) {
        try {
          (void)make_plant(choice(name, 1, "2021-08-01"), site_of("product"), 1);
        } catch (const hal::InputError& e) {
          if (e.place() != "--room") throw;
          throw hal::InputError(name == room ? "--rooms" : "--twin-room", e.found(), e.expected(), e.remedy());
        }
      }
    }
    if (!out.empty()) hal::StagedFile{out};  // can it be written at all?
  }

  void run() {
    const bool energyplus = is_energyplus(choice("301", 1, "2021-07-01"), site_of("product"));
    facts = run_facts(choice("301", 1, "2021-07-01"), site_of("product"));
    if (!energyplus) facts.weather = "another made-up year for each room and seed";
    kind = facts.plant;
    if (rooms.empty()) {
      rooms = {"301-real", "401-real", "402-real", "701-real", "702-real"};
      if (!energyplus) {
        for (int i = static_cast<int>(rooms.size()); i < room_count; ++i) rooms.push_back(fmt::format("study-{}", i));
      }
    }
    if (methods.empty()) methods = study_methods(energyplus);
    check_before_the_long_part(energyplus);
    say_fallback(facts);
    std::vector<Job> list;
    for (const std::string& room : rooms) {
      for (int s = 0; s < seeds; ++s) list.push_back({room, static_cast<std::uint64_t>(first_seed + s)});
    }
    const std::vector<Outcome> outcomes = run_all(list);
    print(outcomes, energyplus);
  }

  static std::string peer_name(const std::string& peer, bool energyplus) {
    if (peer == head_alone) return "the same without its residual network";
    const PlantKind plant = energyplus ? PlantKind::energyplus : PlantKind::rc;
    return make_baseline(peer, site_of("product").settings, plant)->name();
  }

  /// Of the product to a peer, over runs.
  static Spread dae_ratio(const std::vector<Outcome>& outcomes, const std::string& peer) {
    std::vector<double> ratios;
    for (const Outcome& run : outcomes) {
      ratios.push_back(run.at("ours-product").at("dae_degc").get<double>() / run.at(peer).at("dae_degc").get<double>());
    }
    return spread_of(ratios);
  }

  void print(const std::vector<Outcome>& outcomes, bool energyplus) const {
    const std::string floor = energyplus ? "floor-full" : "floor-frozen";
    nlohmann::json j;
    j["plant"] = kind;
    tools::add_to(j, facts);
    j["rooms"] = rooms;
    for (int s = 0; s < seeds; ++s) j["seeds"].push_back(first_seed + s);
    j["pretrain_days"] = pretrain_days;
    j["days"] = days;
    std::vector<std::string> order{"ours-product", head_alone, "ours-scratch"};
    if (!no_paper) order.insert(order.begin() + 2, {"ours-paper", "ours-paper-repaired"});
    order.insert(order.end(), methods.begin(), methods.end());
    for (const std::string& name : order) j["methods"][name] = study_figures(outcomes, name, floor);
    std::string text;
    for (const std::string& peer : {std::string(rival), std::string(head_alone)}) {
      const auto worse = worse_days(outcomes, "ours-product", peer, worse_margin_degc);
      if (!worse) continue;
      const std::string called = peer_name(peer, energyplus);
      const Spread ratio = dae_ratio(outcomes, peer);
      j[peer == rival ? "worse_days" : "worse_days_than_head"] = {{"method", "ours-product"},
                                                                  {"peer", peer},
                                                                  {"peer_name", called},
                                                                  {"margin_degc", worse_margin_degc},
                                                                  {"days", worse->days},
                                                                  {"worse", worse->worse},
                                                                  {"worst_degc", worse->worst_degc},
                                                                  {"dae_ratio", ratio.mean},
                                                                  {"dae_ratio_sd", ratio.sd}};
      text += fmt::format(
          "On {} of {} days ours-product was more than {:g} °C worse than {}, {}; the worst difference was {:+.3f} "
          "°C. Its DAE is {:.3f} ± {:.3f} of that one's, run by run.\n",
          worse->worse, worse->days, worse_margin_degc, peer, called, worse->worst_degc, ratio.mean, ratio.sd);
    }
    if (!json) {
      fmt::print("{}", study_markdown(j["methods"], order, floor));
      if (!text.empty()) fmt::print("\n{}", text);
      fmt::print("\nBy {}.\n", text_of(facts));
    }
    for (std::size_t i = 0; i < outcomes.size(); ++i) j["runs"].push_back(outcomes[i]);
    (void)give_json(j, out, json);
  }
};

}  // namespace

void StudyOptions::add_to(CLI::App& c, const char* days_text) {
  c.add_option("--plant", kind, "rc, energyplus, or auto")
      ->check(CLI::IsMember({"auto", "rc", "energyplus"}))
      ->capture_default_str();
  c.add_option("--seeds", seeds, "seeds a room")->check(CLI::Range(1, 100))->capture_default_str();
  c.add_option("--expert-days", expert_days, "days under the schedule before")
      ->check(CLI::Range(1, 60))
      ->capture_default_str();
  c.add_option("--days", days, days_text)->check(CLI::Range(1, 300))->capture_default_str();
  c.add_option("--jobs", jobs, "child processes at a time")->check(CLI::Range(1, 256))->capture_default_str();
  c.add_flag("--json", json, "print one JSON object and nothing else on standard output");
}

bool give_json(const nlohmann::json& found, const std::string& out, bool as_json) {
  if (!out.empty()) {
    hal::StagedFile file(out);
    file.write(found.dump(1) + "\n");
    file.commit();
  }
  if (as_json) fmt::print("{}\n", found.dump());
  return as_json;
}

PlantChoice StudyOptions::choice(const std::string& room, std::uint64_t seed, const std::string& start) const {
  PlantChoice c;
  c.kind = kind;
  c.room = room;
  c.seed = seed;
  c.start = start;
  return c;
}

void add_study(CLI::App& app) {
  CLI::App* study = app.add_subcommand("study", "tables over several rooms and seeds");
  study->require_subcommand(1);
  add_study_tune(*study);
  add_study_signals(*study);
  add_study_boxes(*study);
  add_study_adopted(*study);
  add_study_nights(*study);
  add_study_residuals(*study);
  add_study_method(*study);
  add_study_all(*study);
  add_study_scenarios(*study);
  auto self = std::make_shared<StudyCommand>();
  CLI::App* c = study->add_subcommand(
      "rooms",
      "pretrain on the twin, fine-tune on schedule days of each room, control it, beside every other method.\n"
      "Each row: mean ± sd over rooms and seeds; ratios are per room to its floor. Peers that are called tuned, and "
      "arx-*,\n"
      "have the gains that `airside study tune` found on rooms and days that are not scored here.\n"
      "The table ends with the days on which ours-product was more than 0.02 °C worse than integral-tuned.");
  self->add_to(*c, "controlled days");
  c->add_option("--rooms", self->rooms,
                "rooms, comma-separated (default: the five counterparts; rc: and study rooms up to --count)")
      ->delimiter(',');
  c->add_option("--count", self->room_count, "how many rc rooms")->check(CLI::Range(1, 200))->capture_default_str();
  c->add_option("--first-seed", self->first_seed, "the others follow it")->check(seed_check())->capture_default_str();
  c->add_option("--twin-room", self->twin_room, "room to pretrain on (default: the twin of each)");
  c->add_option("--pretrain-days", self->pretrain_days, "days of pretraining")
      ->check(CLI::Range(2, 364))
      ->capture_default_str();
  c->add_option("--updates", self->updates, "optimiser steps a cycle in pretraining (default: the preset's)")
      ->check(CLI::Range(1, 100));
  c->add_option("--steps", self->steps, "optimiser steps of the transfer")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  c->add_option("--methods", self->methods, "peers and floors, comma-separated (default: all of docs/results.md)")
      ->delimiter(',');
  c->add_option("-o,--out", self->out, "JSON file with every run");
  c->add_flag("--no-paper", self->no_paper,
              "leave the presets `paper` and `paper-repaired` out; they take most of the time");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
