// airside gap retrain: what the patched twin is worth to the controller.

#include <fmt/format.h>

#include "tools/command.hpp"
#include "tools/command_gap.hpp"
#include "tools/gap/retrain.hpp"

namespace airside::tools {

namespace {

struct RetrainCommand {
  gap::RetrainPlan plan;
  bool json = false;

  void run() const {
    Progress bar(fmt::format("2 twins x {} seeds", plan.seeds), gap::retrain_steps(plan));
    const auto runs = gap::retrain(plan, [&bar] { bar.advance(); });
    bar.finish();
    nlohmann::json j = {
        {"plant", plan.plant},   {"twin", plan.twin}, {"patched", plan.patched},        {"measured", plan.measured},
        {"preset", plan.preset}, {"days", plan.days}, {"runs", nlohmann::json::array()}};
    int lower = 0;
    for (const gap::RetrainRun& run : runs) {
      j["seeds"].push_back(run.seed);
      j["runs"].push_back({{"seed", run.seed}, {"before", facts(run.before)}, {"after", facts(run.after)}});
      if (run.after.dae_degc < run.before.dae_degc) ++lower;
    }
    j["seeds_with_lower_dae"] = lower;
    if (!json) fmt::print("{:<10} {:>21} {:>21}\n", "first days", "weights of the twin", "of the patched twin");
    const auto row = [&](const char* name, const char* key, double Metrics::*figure) {
      std::vector<double> before, after;
      for (const gap::RetrainRun& run : runs) {
        before.push_back(run.before.*figure);
        after.push_back(run.after.*figure);
      }
      const Spread b = spread_of(before), a = spread_of(after);
      j["before"][key] = {{"mean", b.mean}, {"sd", b.sd}};
      j["after"][key] = {{"mean", a.mean}, {"sd", a.sd}};
      if (!json) fmt::print("{:<10} {:>12.3f} +- {:.3f} {:>13.3f} +- {:.3f}\n", name, b.mean, b.sd, a.mean, a.sd);
    };
    row("DAE, K", "dae_degc", &Metrics::dae_degc);
    row("ME, K", "me_degc", &Metrics::me_degc);
    row("DARV, K", "darv_degc", &Metrics::darv_degc);
    row("day 1, K", "day1_dae_degc", &Metrics::day1_dae_degc);
    if (json) {
      fmt::print("{}\n", j.dump());
    } else {
      fmt::print("DAE is lower with the patched twin's weights on {} of {} seeds\n", lower, runs.size());
    }
  }

  static nlohmann::json facts(const Metrics& m) {
    nlohmann::json daily = nlohmann::json::array();
    for (const DayMetrics& d : m.days) daily.push_back(d.dae_degc);
    return {{"dae_degc", m.dae_degc}, {"me_degc", m.me_degc}, {"darv_degc", m.darv_degc}, {"daily_dae_degc", daily}};
  }
};

}  // namespace

void add_gap_retrain(CLI::App& gap) {
  auto self = std::make_shared<RetrainCommand>();
  gap::RetrainPlan& plan = self->plan;
  CLI::App* c = gap.add_subcommand(
      "retrain",
      "pretrain on the twin and on the patched twin, and run both sets of weights on a simulated measured room.\n"
      "A room is a name (301), a file (room.json), or 301+patch.json with merge patches (EnergyPlus).");
  c->add_option("--plant", plan.plant, "rc or energyplus")
      ->check(CLI::IsMember({"rc", "energyplus"}))
      ->capture_default_str();
  c->add_option("--twin", plan.twin, "the room as it was modelled")->required();
  c->add_option("--patched", plan.patched, "the room with what the workflow added")->required();
  c->add_option("--measured", plan.measured, "the room in which the effect is real")->required();
  c->add_option("--preset", plan.preset, "product or paper")
      ->check(CLI::IsMember({"product", "paper"}))
      ->capture_default_str();
  c->add_option("--seeds", plan.seeds, "how many")->check(CLI::Range(1, 100))->capture_default_str();
  c->add_option("--first-seed", plan.first_seed, "the others follow it")->capture_default_str();
  c->add_option("--pretrain-days", plan.pretrain_days, "on each twin")
      ->check(CLI::Range(2, 364))
      ->capture_default_str();
  c->add_option("--expert-days", plan.expert_days, "days under the schedule before; not trained on")
      ->check(CLI::Range(0, 60))
      ->capture_default_str();
  c->add_option("--days", plan.days, "controlled days")->check(CLI::Range(1, 60))->capture_default_str();
  c->add_option("--jobs", plan.jobs, "child processes at a time")->check(CLI::Range(1, 256))->capture_default_str();
  c->add_flag("--json", self->json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
