// airside study residuals: what the room head does not foresee, in rooms that are harder than a summer's office.

#include <fmt/format.h>

#include <filesystem>

#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/staged_file.hpp"
#include "sim/scenarios/scenario.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/study/study.hpp"
#include "tools/run/child_jobs.hpp"
#include "tools/run/options/option_checks.hpp"
#include "tools/run/plant_choice.hpp"
#include "tools/run/run_facts.hpp"
#include "tools/study/residual_run.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

struct ResidualsCommand : StudyOptions {
  std::string out;
  std::vector<std::string> rooms, scenarios;
  int first_seed = 1, later_days = 0;

  ResidualsCommand() {
    kind = "rc";
    seeds = 2;
    days = 28;
  }

  struct Job {
    std::string scenario, room;
    std::uint64_t seed;
    std::string name() const { return fmt::format("{}_{}_{}", scenario, room, seed); }
  };

  Trial trial_of(const Job& job) const {
    PlantChoice plant = choice(job.room, job.seed, std::string(sim::scenario("--scenarios", job.scenario).start));
    plant.scenario = job.scenario;
    plant.start = hal::civil_text({start_of(plant).seconds + later_days * seconds_per_day}).substr(0, 10);
    Trial trial{built_in_site(), plant, expert_days, days};
    trial.site.file.seed = job.seed;
    return trial;
  }

  std::string run_job(const Job& job) const {
    hal::StagedFile file((fs::path(out) / (job.name() + ".csv")).string());
    file.write(residual_csv(trial_of(job)));
    file.commit();
    return "";
  }

  std::vector<Job> jobs_left() const {
    const bool energyplus = is_energyplus(choice("301", 1, "2021-08-01"), built_in_site());
    std::vector<Job> list;
    for (const sim::Scenario& s : sim::scenarios()) {
      const std::string name(s.name);
      if (!scenarios.empty() && std::ranges::find(scenarios, name) == scenarios.end()) continue;
      if (scenarios.empty() && !(energyplus ? s.on_energyplus : s.on_rc)) continue;
      for (const std::string& room : rooms) {
        for (int seed = 0; seed < seeds; ++seed) {
          const Job job{name, room, static_cast<std::uint64_t>(first_seed + seed)};
          if (!fs::exists(fs::path(out) / (job.name() + ".csv"))) list.push_back(job);
        }
      }
    }
    return list;
  }

  void run() {
    for (const std::string& name : scenarios) (void)sim::scenario("--scenarios", name);
    if (rooms.empty()) rooms = {"301-real", "401-real", "402-real", "701-real", "702-real"};
    for (const std::string& room : rooms) check_room(choice(room, 1, "2021-08-01"), built_in_site());
    fs::create_directories(out);
    const std::vector<Job> list = jobs_left();
    Progress bar(fmt::format("{} runs", list.size()), list.size());
    (void)run_children(
        list.size(), jobs, [&](std::size_t i) { return run_job(list[i]); },
        [&](std::size_t i) { return list[i].name(); }, [&bar] { bar.advance(); });
    bar.finish();
    fmt::print("{} runs in {}\n", list.size(), out);
  }
};

}  // namespace

void add_study_residuals(CLI::App& study) {
  auto self = std::make_shared<ResidualsCommand>();
  CLI::App* c = study.add_subcommand(
      "residuals",
      "a CSV a run of what the room head did not foresee, cycle by cycle, beside all that a forecaster might know: "
      "for\n"
      "tools/learn_residuals, which says how much of it can be predicted. Runs that the folder has are left out.");
  self->add_to(*c, "controlled days");
  c->add_option("--rooms", self->rooms, "rooms, comma-separated (default: the five counterparts)")->delimiter(',');
  c->add_option("--scenarios", self->scenarios, "conditions, comma-separated (default: all that the plant knows)")
      ->delimiter(',');
  c->add_option("--first-seed", self->first_seed, "the others follow it")->check(seed_check())->capture_default_str();
  c->add_option("--later", self->later_days,
                "days after the scenario's first: other weather, for rooms that what is learned is tried on")
      ->check(CLI::Range(0, 300))
      ->capture_default_str();
  c->add_option("-o,--out", self->out, "folder for the files")->required();
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
