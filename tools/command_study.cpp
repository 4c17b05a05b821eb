// airside study rooms: every method on several rooms and seeds, the table that README shows.

#include <fmt/format.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <map>

#include "hal/input_error.hpp"
#include "tools/command.hpp"
#include "tools/methods.hpp"
#include "tools/report/report.hpp"
#include "tools/report/run_report.hpp"

namespace airside::tools {

namespace {

/// One room and one seed: figures of every method, by name.
using Outcome = std::map<std::string, nlohmann::json>;

/// The figures of a table row that have a mean and a spread.
constexpr const char* figures[] = {"dae_degc", "me_degc", "day1_dae_degc", "darv_degc", "degree_hours_per_day_degch",
                                   "hvac_kwh_per_day", "cdh_degch", "hdh_degch"};

struct StudyCommand {
  std::string kind = "auto", out, twin_room;
  std::vector<std::string> rooms, methods;
  int room_count = 12, seeds = 5, first_seed = 1, pretrain_days = 31, expert_days = 5, days = 14, updates = 0, steps = 3000, jobs = 2;
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

  Outcome run_job(const Job& job) const {
    Outcome outcome;
    std::vector<std::string> presets{"product"};
    if (!no_paper) presets.emplace_back("paper");
    for (const std::string& preset : presets) {
      const Site site = built_in_site("5vav-5fcu-2power",
                                      preset == "paper" ? hal::ControllerPreset::paper : hal::ControllerPreset::product);
      const auto twin = make_plant(choice(twin_of(job.room), job.seed, "2021-07-01"), site, pretrain_days);
      PretrainOptions options;
      options.seed = job.seed;
      options.updates_per_cycle = updates;
      const CivilTime until{twin->time().seconds + pretrain_days * std::int64_t{86400}};
      const Pretraining trained = pretrain(site, *twin, until, options);
      Trial trial{site, choice(job.room, job.seed, "2021-08-01"), expert_days, days};
      trial.site.file.seed = job.seed;
      Prepared prepared = prepare(trial);
      outcome["ours-" + preset] = json_of(metrics_of(site, run_ours(trial, prepared, {trained.blob, true, steps})));
      if (preset == "product") {
        Prepared again = prepare(trial);
        outcome["ours-scratch"] = json_of(metrics_of(site, run_ours(trial, again, {{}, true, steps})));
        for (const std::string& name : methods) {
          Prepared fresh = prepare(trial);
          outcome[name] = json_of(metrics_of(site, run_method(trial, fresh, name)));
        }
      }
    }
    return outcome;
  }

  /// Runs all jobs in child processes, `jobs` at a time: co-simulations in one process would not be repeatable.
  std::vector<Outcome> run_all(const std::vector<Job>& list) const {
    std::vector<Outcome> outcomes(list.size());
    Progress bar(fmt::format("{} rooms x {} seeds", rooms.size(), seeds), list.size());
    struct Child {
      pid_t pid;
      int pipe;
      std::size_t job;
      std::string text;
    };
    std::vector<Child> running;
    std::size_t next = 0;
    while (next < list.size() || !running.empty()) {
      while (next < list.size() && std::ssize(running) < jobs) {
        int ends[2];
        if (::pipe(ends) != 0) throw std::runtime_error("no pipe for a child process");
        std::fflush(nullptr);
        const pid_t pid = ::fork();
        if (pid < 0) throw std::runtime_error("no child process could be started");
        if (pid == 0) {
          ::close(ends[0]);
          std::string text;
          try {
            text = nlohmann::json(run_job(list[next])).dump();
          } catch (const std::exception& e) {
            text = nlohmann::json{{"error", e.what()}}.dump();
          }
          for (std::size_t sent = 0; sent < text.size();) {
            const ssize_t n = ::write(ends[1], text.data() + sent, text.size() - sent);
            if (n <= 0) ::_exit(1);
            sent += static_cast<std::size_t>(n);
          }
          ::_exit(0);
        }
        ::close(ends[1]);
        running.push_back({pid, ends[0], next++, {}});
      }
      // The oldest child is drained first; the others' answers wait in their pipes.
      Child child = running.front();
      running.erase(running.begin());
      char buffer[65536];
      for (ssize_t n = 0; (n = ::read(child.pipe, buffer, sizeof buffer)) > 0;) child.text.append(buffer, static_cast<std::size_t>(n));
      ::close(child.pipe);
      int status = 0;
      ::waitpid(child.pid, &status, 0);
      const auto answer = nlohmann::json::parse(child.text, nullptr, false);
      const std::string who = fmt::format("room {} seed {}", list[child.job].room, list[child.job].seed);
      if (answer.is_discarded()) throw std::runtime_error(who + ": its process ended without an answer");
      if (answer.contains("error")) throw std::runtime_error(who + ": " + answer["error"].get<std::string>());
      outcomes[child.job] = answer.get<Outcome>();
      bar.advance();
    }
    bar.finish();
    return outcomes;
  }

  void run() {
    const bool energyplus = is_energyplus(choice("301", 1, "2021-07-01"));
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
      fmt::print("{:<16} {:>15} {:>15} {:>15} {:>15} {:>15} {:>15} {:>9} {:>9}\n", "method", "DAE", "ME", "day 1", "DARV",
                 "deg-h/day", "kWh/day", "DAE/floor", "DARV/fl.");
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
      fmt::print("{:<16} {:>15} {:>15} {:>15} {:>15} {:>15} {:>15} {:>9} {:>9}\n", name, cell("dae_degc"), cell("me_degc"),
                 cell("day1_dae_degc"), cell("darv_degc"), cell("degree_hours_per_day_degch"), cell("hvac_kwh_per_day"), ratio("dae"),
                 ratio("darv"));
    }
    for (std::size_t i = 0; i < outcomes.size(); ++i) j["runs"].push_back(outcomes[i]);
    if (!out.empty()) {
      std::FILE* f = std::fopen(out.c_str(), "w");
      if (f == nullptr) throw hal::InputError("--out " + out, "a file that cannot be written", "a writable path", "choose another");
      fmt::print(f, "{}\n", j.dump(1));
      std::fclose(f);
    }
    if (json) fmt::print("{}\n", j.dump());
  }
};

}  // namespace

void add_study(CLI::App& app) {
  CLI::App* study = app.add_subcommand("study", "tables over several rooms and seeds");
  study->require_subcommand(1);
  auto self = std::make_shared<StudyCommand>();
  CLI::App* c = study->add_subcommand(
      "rooms",
      "pretrain on the twin, fine-tune on schedule days of each room, control it, beside every other method.\n"
      "Each row: mean +- sd over rooms and seeds; ratios are per room to its floor.");
  c->add_option("--plant", self->kind, "rc, energyplus, or auto")->check(CLI::IsMember({"auto", "rc", "energyplus"}))->capture_default_str();
  c->add_option("--rooms", self->rooms, "rooms, comma-separated (default: the five counterparts; rc: and study rooms up to --count)")
      ->delimiter(',');
  c->add_option("--count", self->room_count, "how many rc rooms")->check(CLI::Range(1, 200))->capture_default_str();
  c->add_option("--seeds", self->seeds, "seeds a room")->check(CLI::Range(1, 100))->capture_default_str();
  c->add_option("--first-seed", self->first_seed, "")->capture_default_str();
  c->add_option("--twin-room", self->twin_room, "room to pretrain on (default: the twin of each)");
  c->add_option("--pretrain-days", self->pretrain_days, "")->check(CLI::Range(2, 364))->capture_default_str();
  c->add_option("--updates", self->updates, "optimiser steps a cycle in pretraining (default: the preset's)");
  c->add_option("--steps", self->steps, "optimiser steps of the transfer")->capture_default_str();
  c->add_option("--expert-days", self->expert_days, "")->capture_default_str();
  c->add_option("--days", self->days, "")->capture_default_str();
  c->add_option("--methods", self->methods, "peers and floors, comma-separated")->delimiter(',');
  c->add_option("--jobs", self->jobs, "child processes at a time")->check(CLI::Range(1, 256))->capture_default_str();
  c->add_option("-o,--out", self->out, "JSON file with every run");
  c->add_flag("--no-paper", self->no_paper, "leave the preset `paper` out; it takes most of the time");
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
