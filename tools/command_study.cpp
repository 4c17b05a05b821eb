// airside study rooms: every method on several rooms and seeds, the table that README shows.

#include <fmt/format.h>

#include <cmath>
#include <map>

#include "hal/input_error.hpp"
#include "hal/staged_file.hpp"
#include "tools/child_jobs.hpp"
#include "tools/command.hpp"
#include "tools/command_study.hpp"
#include "tools/methods.hpp"
#include "tools/report/report.hpp"
#include "tools/report/run_report.hpp"

namespace airside::tools {

namespace {

/// One room and one seed: figures of every method, by name.
using Outcome = std::map<std::string, nlohmann::json>;

/// The figures of a table row that have a mean and a spread.
constexpr const char* figures[] = {
    "dae_degc",         "me_degc",   "day1_dae_degc", "darv_degc", "degree_hours_per_day_degch",
    "hvac_kwh_per_day", "cdh_degch", "hdh_degch"};

struct StudyCommand {
  std::string kind = "auto", out, twin_room;
  std::vector<std::string> rooms, methods;
  int room_count = 12, seeds = 5, first_seed = 1, pretrain_days = 31, expert_days = 5, days = 14, updates = 0,
      steps = 3000, jobs = 2;
  bool json = false, no_paper = false;

  struct Job {
    std::string room;
    std::uint64_t seed;
  };

  PlantChoice choice(const std::string& room, std::uint64_t seed, const std::string& start) const {
    PlantChoice c;
    c.kind = kind;
    c.room = room;
    c.seed = seed;
    c.start = start;
    return c;
  }

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
    return no_paper ? std::vector<std::string>{"product"} : std::vector<std::string>{"product", "paper"};
  }

  static Site site_of(const std::string& preset) {
    return built_in_site("5vav-5fcu-2power",
                         preset == "paper" ? hal::ControllerPreset::paper : hal::ControllerPreset::product);
  }

  std::string pretrain_source(const Source& source) const {
    const Site site = site_of(source.preset);
    const auto twin = make_plant(choice(source.twin, source.seed, "2021-07-01"), site, pretrain_days);
    PretrainOptions options;
    options.seed = source.seed;
    options.updates_per_cycle = updates;
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
    for (const std::string& preset : presets()) {
      const std::string& text = sources.at({twin_of(job.room), preset, job.seed});
      const auto* bytes = reinterpret_cast<const std::byte*>(text.data());
      const Trial trial = trial_of(preset);
      Prepared prepared = prepare(trial);
      outcome["ours-" + preset] = json_of(
          metrics_of(trial.site, run_ours(trial, prepared, {BlobBytes(bytes, bytes + text.size()), true, steps})));
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
    kind = energyplus ? "energyplus" : "rc";
    if (rooms.empty()) {
      rooms = {"301-real", "401-real", "402-real", "701-real", "702-real"};
      if (!energyplus) {
        for (int i = static_cast<int>(rooms.size()); i < room_count; ++i) rooms.push_back(fmt::format("study-{}", i));
      }
    }
    if (methods.empty()) {
      methods = {"expert", "pid-tuned", "integral-5", "integral-7", "arx-2", "arx-rls", "g36-site-i2"};
      for (const std::string& floor : floor_names(energyplus)) methods.push_back(floor);
    }
    check_before_the_long_part(energyplus);
    std::vector<Job> list;
    for (const std::string& room : rooms) {
      for (int s = 0; s < seeds; ++s) list.push_back({room, static_cast<std::uint64_t>(first_seed + s)});
    }
    const std::vector<Outcome> outcomes = run_all(list);
    print(outcomes, energyplus);
  }

  void print(const std::vector<Outcome>& outcomes, bool energyplus) const {
    const std::string floor = energyplus ? "floor-full" : "floor-frozen";
    nlohmann::json j;
    j["plant"] = kind;
    j["rooms"] = rooms;
    for (int s = 0; s < seeds; ++s) j["seeds"].push_back(first_seed + s);
    j["pretrain_days"] = pretrain_days;
    j["days"] = days;
    std::vector<std::string> order{"ours-product", "ours-scratch"};
    if (!no_paper) order.insert(order.begin() + 1, "ours-paper");
    order.insert(order.end(), methods.begin(), methods.end());
    if (!json) {
      fmt::print("{:<16} {:>15} {:>15} {:>15} {:>15} {:>15} {:>15} {:>9} {:>9}\n", "method", "DAE", "ME", "day 1",
                 "DARV", "deg-h/day", "kWh/day", "DAE/floor", "DARV/fl.");
    }
    for (const std::string& name : order) {
      nlohmann::json& m = j["methods"][name];
      for (const char* figure : figures) {
        std::vector<double> values;
        for (const Outcome& o : outcomes) {
          if (o.contains(name)) values.push_back(o.at(name).at(figure).get<double>());
        }
        const Spread s = spread_of(values);
        m[figure] = {{"mean", s.mean}, {"sd", s.sd}, {"count", s.count}};
      }
      // Ratios per room first, then their mean: a difficult room must not outvote an easy one.
      for (const char* figure : {"dae_degc", "darv_degc"}) {
        double sum = 0;
        int count = 0;
        for (const Outcome& o : outcomes) {
          if (!o.contains(name) || !o.contains(floor)) continue;
          sum += o.at(name).at(figure).get<double>() / o.at(floor).at(figure).get<double>();
          ++count;
        }
        if (count > 0) m[std::string(figure).substr(0, std::string(figure).find('_')) + "_over_" + floor] = sum / count;
      }
      if (json) continue;
      const auto cell = [&m](const char* figure) {
        return fmt::format("{:.3f} +-{:.3f}", m[figure]["mean"].get<double>(), m[figure]["sd"].get<double>());
      };
      const auto ratio = [&m, &floor](const char* figure) {
        const std::string key = std::string(figure) + "_over_" + floor;
        return m.contains(key) ? fmt::format("{:.2f}", m[key].get<double>()) : std::string("-");
      };
      fmt::print("{:<16} {:>15} {:>15} {:>15} {:>15} {:>15} {:>15} {:>9} {:>9}\n", name, cell("dae_degc"),
                 cell("me_degc"), cell("day1_dae_degc"), cell("darv_degc"), cell("degree_hours_per_day_degch"),
                 cell("hvac_kwh_per_day"), ratio("dae"), ratio("darv"));
    }
    for (std::size_t i = 0; i < outcomes.size(); ++i) j["runs"].push_back(outcomes[i]);
    if (!out.empty()) {
      hal::StagedFile file(out);
      file.write(j.dump(1) + "\n");
      file.commit();
    }
    if (json) fmt::print("{}\n", j.dump());
  }
};

}  // namespace

void add_study(CLI::App& app) {
  CLI::App* study = app.add_subcommand("study", "tables over several rooms and seeds");
  study->require_subcommand(1);
  add_study_tune(*study);
  auto self = std::make_shared<StudyCommand>();
  CLI::App* c = study->add_subcommand(
      "rooms",
      "pretrain on the twin, fine-tune on schedule days of each room, control it, beside every other method.\n"
      "Each row: mean +- sd over rooms and seeds; ratios are per room to its floor.");
  c->add_option("--plant", self->kind, "rc, energyplus, or auto")
      ->check(CLI::IsMember({"auto", "rc", "energyplus"}))
      ->capture_default_str();
  c->add_option("--rooms", self->rooms,
                "rooms, comma-separated (default: the five counterparts; rc: and study rooms up to --count)")
      ->delimiter(',');
  c->add_option("--count", self->room_count, "how many rc rooms")->check(CLI::Range(1, 200))->capture_default_str();
  c->add_option("--seeds", self->seeds, "seeds a room")->check(CLI::Range(1, 100))->capture_default_str();
  c->add_option("--first-seed", self->first_seed, "the others follow it")->capture_default_str();
  c->add_option("--twin-room", self->twin_room, "room to pretrain on (default: the twin of each)");
  c->add_option("--pretrain-days", self->pretrain_days, "days of pretraining")
      ->check(CLI::Range(2, 364))
      ->capture_default_str();
  c->add_option("--updates", self->updates, "optimiser steps a cycle in pretraining (default: the preset's)")
      ->check(CLI::Range(1, 100));
  c->add_option("--steps", self->steps, "optimiser steps of the transfer")
      ->check(CLI::Range(0, 1000000))
      ->capture_default_str();
  c->add_option("--expert-days", self->expert_days, "days under the schedule before")
      ->check(CLI::Range(1, 60))
      ->capture_default_str();
  c->add_option("--days", self->days, "controlled days")->check(CLI::Range(1, 300))->capture_default_str();
  c->add_option("--methods", self->methods, "peers and floors, comma-separated")->delimiter(',');
  c->add_option("--jobs", self->jobs, "child processes at a time")->check(CLI::Range(1, 256))->capture_default_str();
  c->add_option("-o,--out", self->out, "JSON file with every run");
  c->add_flag("--no-paper", self->no_paper, "leave the preset `paper` out; it takes most of the time");
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
