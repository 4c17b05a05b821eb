// airside residual: gives weights a network that predicts what their room head will get wrong.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <vector>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/shell_word.hpp"
#include "sim/scenarios/scenario.hpp"
#include "tools/cli/command.hpp"
#include "tools/run/child_jobs.hpp"
#include "tools/run/options/option_checks.hpp"
#include "tools/run/plant_choice.hpp"
#include "tools/run/run_facts.hpp"
#include "tools/run/training/blob_place.hpp"
#include "tools/run/training/residual_cycles.hpp"
#include "tools/run/training/residual_training.hpp"
#include "tools/study/control_methods.hpp"

namespace airside::tools {

namespace {

/// What is tried lies this much later and has other seeds: else the day would be recognised, not the room.
constexpr int tried_days_later = 40;
constexpr std::uint64_t tried_seeds_later = 100000;
constexpr std::uint64_t seeds_of_a_room = 1000;  ///< on EnergyPlus people and outages follow the seed, not the room
constexpr double least_gain = 0.01;              ///< of the mean distance; with less the blob stays as it is

std::vector<std::string> numbered(const char* set, int first, int end) {
  std::vector<std::string> names;
  for (int i = first; i < end; ++i) names.push_back(fmt::format("{}-{}", set, i));
  return names;
}

struct ResidualCommand {
  SiteOptions site;
  std::string kind = "auto", blob, out, keep, text;
  std::vector<std::string> rooms, tried_rooms, scenarios, kept;
  int seeds = 2, first_seed = 1, days = 28, expert_days = 5, jobs = 2, epochs = 30;
  bool json = false;

  struct Job {
    std::string room, scenario;
    std::uint64_t seed = 1;
    bool is_tried = false;
    std::string name() const { return fmt::format("room {}, {}, seed {}", room, scenario, seed); }
  };

  PlantChoice choice(const Job& job) const {
    PlantChoice plant;
    plant.kind = kind;
    plant.room = job.room;
    plant.seed = job.seed;
    plant.scenario = job.scenario;
    plant.start = std::string(sim::scenario("--scenarios", job.scenario).start);
    if (job.is_tried) {
      plant.start = hal::civil_text({start_of(plant).seconds + tried_days_later * seconds_per_day}).substr(0, 10);
    }
    return plant;
  }

  /// One run of the product, whose head learns on schedule days. `under`: weights with a network, which acts; without
  /// any the head controls alone.
  std::string run_job(const Site& s, const BlobBytes& under, const Job& job) const {
    constexpr int steps = 300;  // the head is what is looked at, not the method's network
    Trial trial{s, choice(job), expert_days, days};
    trial.site.file.seed = job.seed;
    Prepared prepared = prepare(trial);
    return bytes_of(residual_samples(s, run_ours(trial, prepared, {under, true, steps})));
  }

  void choose_rooms(bool energyplus) {
    if (rooms.empty()) rooms = numbered("tuning", 0, 8);
    if (tried_rooms.empty()) tried_rooms = numbered("tuning", 8, 10);
    if (!scenarios.empty()) return;
    for (const sim::Scenario& s : sim::scenarios()) {
      if (energyplus ? s.on_energyplus : s.on_rc) scenarios.emplace_back(s.name);
    }
  }

  std::vector<Job> make_jobs() const {
    std::vector<Job> list;
    for (const bool is_tried : {false, true}) {
      const std::vector<std::string>& of = is_tried ? tried_rooms : rooms;
      for (const std::string& scenario : scenarios) {
        for (std::size_t r = 0; r < of.size(); ++r) {
          for (int i = 0; i < seeds; ++i) {
            const std::uint64_t own = seeds_of_a_room * r + static_cast<std::uint64_t>(first_seed + i);
            list.push_back({of[r], scenario, own + (is_tried ? tried_seeds_later : 0), is_tried});
          }
        }
      }
    }
    return list;
  }

  /// Runs all jobs. Weights that have a network already control with it: what it leads to is learned from, too.
  ResidualCycles simulate(const Site& s, const BlobBytes& source, const std::vector<Job>& list) const {
    const BlobBytes under = has_residual(source) ? source : BlobBytes();
    Progress bar(fmt::format("simulating {} runs of {} days", list.size(), days), list.size());
    const auto texts = run_children(
        list.size(), jobs, [&](std::size_t i) { return run_job(s, under, list[i]); },
        [&](std::size_t i) { return list[i].name(); }, [&bar] { bar.advance(); });
    bar.finish();
    ResidualCycles all;
    all.cycle_min = s.settings.cycle_min;
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::vector<ResidualSample> more = samples_from(texts[i]);
      std::vector<ResidualSample>& part = list[i].is_tried ? all.tried : all.learned;
      part.insert(part.end(), more.begin(), more.end());
    }
    return all;
  }

  ResidualCycles simulated(const Site& s, const BlobBytes& source, RunFacts& facts) {
    for (const std::string& name : scenarios) (void)sim::scenario("--scenarios", name);
    PlantChoice plant;
    plant.kind = kind;
    choose_rooms(is_energyplus(plant, s));
    const std::vector<Job> list = make_jobs();
    for (const Job& job : list) check_room(choice(job), s);
    facts = run_facts(choice(list.front()), s);
    say_fallback(facts);
    return simulate(s, source, list);
  }

  static ResidualCycles cycles_of(const Site& s, const std::string& path) {
    ResidualCycles found = read_cycles(path);
    if (found.cycle_min == s.settings.cycle_min) return found;
    throw hal::InputError(path, fmt::format("cycles of {} min", found.cycle_min),
                          fmt::format("those of the site, {} min", s.settings.cycle_min),
                          "give the --site that they were made with, or make them anew");
  }

  /// A file of kept cycles, or what was simulated, and how well its tried cycles are predicted.
  struct Tried {
    std::string what;
    ResidualScore score;
  };

  void run() {
    const Site s = make_site(site);
    const BlobBytes source = read_blob(blob, s);
    if (out.empty()) out = blob;
    std::vector<ResidualCycles> parts;
    for (const std::string& path : kept) parts.push_back(cycles_of(s, path));
    BlobPlace place(out, most_blob_bytes(s));
    RunFacts facts;
    if (parts.empty()) parts.push_back(simulated(s, source, facts));
    ResidualCycles cycles;
    for (const ResidualCycles& part : parts) cycles.add(part);
    if (!keep.empty()) write_cycles(keep, cycles);
    ResidualTraining training;
    training.seed = static_cast<std::uint64_t>(first_seed);
    training.epochs = epochs;
    Progress learning(fmt::format("learning from {} cycles", cycles.learned.size()), progress_steps);
    const ResidualNetwork network = train_residual(cycles.learned, training, show_progress(learning));
    learning.finish();
    std::vector<Tried> tried;
    for (std::size_t i = 0; i < parts.size() && kept.size() > 1; ++i) {
      tried.push_back({kept[i], score_of(network, parts[i].tried)});
    }
    tried.push_back({"all", score_of(network, cycles.tried)});
    const bool is_worth_it = tried.back().score.ratio <= 1 - least_gain;
    if (is_worth_it) {
      place.write(with_residual(s, source, network, provenance(cycles.learned.size(), tried.back().score)));
      if (!text.empty()) write_residual_text(text, network);
    }
    say(facts, cycles.learned.size(), tried, is_worth_it);
  }

  /// Where the cycles are of, for people.
  std::string learned_of() const { return fmt::format("{}", fmt::join(kept.empty() ? rooms : kept, ", ")); }
  std::string tried_of() const { return fmt::format("{}", fmt::join(kept.empty() ? tried_rooms : kept, ", ")); }

  std::string provenance(std::size_t learned, const ResidualScore& score) const {
    const std::string how = kept.empty() ? fmt::format("--seeds {} --days {}", seeds, days) : "--cycles";
    return fmt::format("airside residual {}{} {}: {} cycles of {}; left on {}: {:.3f}", hal::shell_word(blob),
                       command_text(site), how, learned, learned_of(), tried_of(), score.ratio);
  }

  void say(const RunFacts& facts, std::size_t learned, const std::vector<Tried>& tried, bool is_worth_it) const {
    const ResidualScore& all = tried.back().score;
    if (json) {
      nlohmann::json j{{"learned_cycles", learned},
                       {"tried_cycles", all.samples},
                       {"r2", all.r2},
                       {"error_ratio", all.ratio},
                       {"written", is_worth_it},
                       {"blob", is_worth_it ? nlohmann::json(out) : nlohmann::json()},
                       {"rooms", rooms},
                       {"tried_rooms", tried_rooms},
                       {"scenarios", scenarios},
                       {"cycles", kept},
                       {"tried", nlohmann::json::array()}};
      for (const Tried& t : tried) {
        j["tried"].push_back(
            {{"what", t.what}, {"cycles", t.score.samples}, {"r2", t.score.r2}, {"error_ratio", t.score.ratio}});
      }
      if (kept.empty()) {
        add_to(j, facts);
      } else {
        add_program_to(j);
      }
      fmt::print("{}\n", j.dump());
      return;
    }
    fmt::print("learned from {} cycles of {}; tried on {} cycles of {}, other days and seeds:\n", learned, learned_of(),
               all.samples, tried_of());
    for (const Tried& t : tried) {
      fmt::print("{}: R2 {:.2f}; {:.3f} of the head's mean error is left\n", t.what, t.score.r2, t.score.ratio);
    }
    if (is_worth_it) {
      fmt::print("weights with this network: {}\n", out);
      if (kept.empty()) fmt::print("by {}\n", text_of(facts));
    } else {
      fmt::print("not worth it: {} was left as it is. More rooms or seeds may help; the head alone controls.\n", blob);
    }
  }
};

}  // namespace

void add_residual(CLI::App& app) {
  auto self = std::make_shared<ResidualCommand>();
  CLI::App* c = app.add_subcommand(
      "residual",
      "add to weights a small network that predicts what their room head will get wrong in the next control cycle.\n"
      "Simulates the product in many rooms and conditions, learns from its head's errors, and tries the network on "
      "rooms,\ndays and seeds that it has not seen. Where less than 1 % could be predicted nothing is written.");
  add_site_options(*c, self->site);
  c->add_option("blob", self->blob, "weights of airside pretrain or transfer")->required();
  c->add_option("--plant", self->kind, "rc, energyplus, or auto")
      ->check(CLI::IsMember({"auto", "rc", "energyplus"}))
      ->capture_default_str();
  c->add_option("--rooms", self->rooms,
                "rooms to learn from, comma-separated (default: eight made-up rooms of the plant)")
      ->delimiter(',');
  c->add_option("--try-rooms", self->tried_rooms, "rooms to try it on (default: two others)")->delimiter(',');
  c->add_option("--scenarios", self->scenarios, "conditions, comma-separated (default: all that the plant knows)")
      ->delimiter(',');
  c->add_option("--seeds", self->seeds, "runs of each room and condition")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  c->add_option("--first-seed", self->first_seed, "the others follow it")->check(seed_check())->capture_default_str();
  c->add_option("--days", self->days, "controlled days a run")->check(CLI::Range(1, 180))->capture_default_str();
  c->add_option("--epochs", self->epochs, "passes over the cycles while it learns")
      ->check(CLI::Range(1, 1000))
      ->capture_default_str();
  c->add_option("--jobs", self->jobs, "runs at a time")->check(CLI::Range(1, 256))->capture_default_str();
  c->add_option("--keep", self->keep, "keep the simulated cycles in this file, for --cycles");
  c->add_option("--cycles", self->kept,
                "files of --keep, comma-separated: learn from these instead of simulating, of several plants together")
      ->delimiter(',')
      ->excludes("--rooms")
      ->excludes("--try-rooms")
      ->excludes("--scenarios");
  c->add_option("--text", self->text, "write the network's numbers as text, too (how the built-in network was made)");
  c->add_option("-o,--out", self->out, "blob to write (default: in the place of the blob)");
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
