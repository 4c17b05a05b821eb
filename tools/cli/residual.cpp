// airside residual: gives weights a network that predicts what their room head will get wrong.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <string>
#include <vector>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "sim/scenarios/scenario.hpp"
#include "tools/cli/command.hpp"
#include "tools/run/child_jobs.hpp"
#include "tools/run/plant_choice.hpp"
#include "tools/run/run_facts.hpp"
#include "tools/run/training/blob_place.hpp"
#include "tools/run/training/residual_training.hpp"
#include "tools/study/control_methods.hpp"

namespace airside::tools {

namespace {

/// What is tried lies this much later and has other seeds: else the day would be recognised, not the room.
constexpr int tried_days_later = 40;
constexpr std::uint64_t tried_seeds_later = 1000;
constexpr double least_gain = 0.01;  ///< of the mean distance; with less the blob stays as it is

std::vector<std::string> numbered(const char* set, int first, int end) {
  std::vector<std::string> names;
  for (int i = first; i < end; ++i) names.push_back(fmt::format("{}-{}", set, i));
  return names;
}

struct ResidualCommand {
  SiteOptions site;
  std::string kind = "auto", blob, out;
  std::vector<std::string> rooms, tried_rooms, scenarios;
  int seeds = 2, first_seed = 1, days = 28, expert_days = 5, jobs = 2, epochs = 12;
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

  /// One run of the product, whose head learns on schedule days; the blob's weights are not asked.
  std::string run_job(const Site& s, const Job& job) const {
    constexpr int steps = 300;  // the head is what is looked at, not the network
    Trial trial{s, choice(job), expert_days, days};
    trial.site.file.seed = job.seed;
    Prepared prepared = prepare(trial);
    return bytes_of(residual_samples(s, run_ours(trial, prepared, {{}, true, steps})));
  }

  void choose_rooms(bool energyplus) {
    if (rooms.empty()) rooms = energyplus ? std::vector<std::string>{"301", "401", "402"} : numbered("tuning", 0, 8);
    if (tried_rooms.empty()) {
      tried_rooms = energyplus ? std::vector<std::string>{"701", "702"} : numbered("tuning", 8, 10);
    }
    if (!scenarios.empty()) return;
    for (const sim::Scenario& s : sim::scenarios()) {
      if (energyplus ? s.on_energyplus : s.on_rc) scenarios.emplace_back(s.name);
    }
  }

  std::vector<Job> make_jobs() const {
    std::vector<Job> list;
    for (const bool is_tried : {false, true}) {
      for (const std::string& scenario : scenarios) {
        for (const std::string& room : is_tried ? tried_rooms : rooms) {
          for (int i = 0; i < seeds; ++i) {
            const auto seed = static_cast<std::uint64_t>(first_seed + i) + (is_tried ? tried_seeds_later : 0);
            list.push_back({room, scenario, seed, is_tried});
          }
        }
      }
    }
    return list;
  }

  void run() {
    const Site s = make_site(site);
    const BlobBytes source = read_blob(blob, s);
    for (const std::string& name : scenarios) (void)sim::scenario("--scenarios", name);
    PlantChoice plant;
    plant.kind = kind;
    const bool energyplus = is_energyplus(plant, s);
    choose_rooms(energyplus);
    const std::vector<Job> list = make_jobs();
    for (const Job& job : list) check_room(choice(job), s);
    if (out.empty()) out = blob;
    BlobPlace place(out, most_blob_bytes(s));
    const RunFacts facts = run_facts(choice(list.front()), s);
    say_fallback(facts);

    Progress bar(fmt::format("simulating {} runs of {} days", list.size(), days), list.size());
    const auto texts = run_children(
        list.size(), jobs, [&](std::size_t i) { return run_job(s, list[i]); },
        [&](std::size_t i) { return list[i].name(); }, [&bar] { bar.advance(); });
    bar.finish();
    std::vector<ResidualSample> learned, tried;
    for (std::size_t i = 0; i < list.size(); ++i) {
      const std::vector<ResidualSample> more = samples_from(texts[i]);
      std::vector<ResidualSample>& all = list[i].is_tried ? tried : learned;
      all.insert(all.end(), more.begin(), more.end());
    }
    ResidualTraining training;
    training.seed = static_cast<std::uint64_t>(first_seed);
    training.epochs = epochs;
    Progress learning(fmt::format("learning from {} cycles", learned.size()), progress_steps);
    const ResidualNetwork network = train_residual(learned, training, show_progress(learning));
    learning.finish();
    const ResidualScore score = score_of(network, tried);
    const bool is_worth_it = score.ratio <= 1 - least_gain;
    if (is_worth_it) place.write(with_residual(s, source, network, provenance(learned.size(), score)));
    say(facts, learned.size(), score, is_worth_it);
  }

  std::string provenance(std::size_t learned, const ResidualScore& score) const {
    return fmt::format("airside residual {}{} --seeds {} --days {}: {} cycles of {}; left on {}: {:.3f}", blob,
                       command_text(site), seeds, days, learned, fmt::join(rooms, ","), fmt::join(tried_rooms, ","),
                       score.ratio);
  }

  void say(const RunFacts& facts, std::size_t learned, const ResidualScore& score, bool is_worth_it) const {
    if (json) {
      nlohmann::json j{{"learned_cycles", learned},
                       {"tried_cycles", score.samples},
                       {"r2", score.r2},
                       {"error_ratio", score.ratio},
                       {"written", is_worth_it},
                       {"blob", is_worth_it ? nlohmann::json(out) : nlohmann::json()},
                       {"rooms", rooms},
                       {"tried_rooms", tried_rooms},
                       {"scenarios", scenarios}};
      add_to(j, facts);
      fmt::print("{}\n", j.dump());
      return;
    }
    fmt::print(
        "learned from {} cycles of {}; tried on {} cycles of {}, other days and seeds:\n"
        "R2 {:.2f}; {:.3f} of the head's mean error is left\n",
        learned, fmt::join(rooms, ", "), score.samples, fmt::join(tried_rooms, ", "), score.r2, score.ratio);
    if (is_worth_it) {
      fmt::print("weights with this network: {}\nby {}\n", out, text_of(facts));
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
                "rooms to learn from, comma-separated (default: 8 made-up rooms of rc, or three twins of EnergyPlus)")
      ->delimiter(',');
  c->add_option("--try-rooms", self->tried_rooms, "rooms to try it on (default: two others)")->delimiter(',');
  c->add_option("--scenarios", self->scenarios, "conditions, comma-separated (default: all that the plant knows)")
      ->delimiter(',');
  c->add_option("--seeds", self->seeds, "runs of each room and condition")
      ->check(CLI::Range(1, 100))
      ->capture_default_str();
  c->add_option("--first-seed", self->first_seed, "the others follow it")->capture_default_str();
  c->add_option("--days", self->days, "controlled days a run")->check(CLI::Range(1, 180))->capture_default_str();
  c->add_option("--jobs", self->jobs, "runs at a time")->check(CLI::Range(1, 256))->capture_default_str();
  c->add_option("-o,--out", self->out, "blob to write (default: in the place of the blob)");
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
