// airside gap retrain: what the patched twin is worth to the controller.

#include <fmt/format.h>

#include "hal/text/input_error.hpp"
#include "tools/cli/command.hpp"
#include "tools/cli/gap/gap.hpp"
#include "tools/gap/retrain/retrain.hpp"
#include "tools/run/options/option_checks.hpp"

namespace airside::tools {

namespace {

struct RetrainCommand : GapOptions {
  gap::RetrainPlan plan;
  std::string twin, patched, measured, site_path, preset;
  std::vector<std::string> changes;

  void run() const {
    const auto list = changes.empty() ? std::vector<sim::Effect>{} : effects();
    const gap::RetrainPlan planned = whole_plan(list);
    gap::check_retrain_rooms(planned);
    Progress bar(fmt::format("2 twins x {} seeds", planned.seeds), gap::retrain_steps(planned));
    const gap::Retraining retraining = gap::retrain(planned, [&bar] { bar.advance(); });
    bar.finish();
    if (json)
      fmt::print("{}\n", gap::json_of(retraining).dump());
    else
      fmt::print("{}{}\n", gap::text_of(retraining), gap::sentence_of(retraining));
  }

  gap::RetrainPlan whole_plan(const std::vector<sim::Effect>& list) const {
    gap::RetrainPlan p = plan;
    p.jobs = jobs;
    p.twin = gap::parse_retrain_room(twin);
    p.patched = gap::parse_retrain_room(patched);
    p.measured = gap::parse_retrain_room(measured);
    p.site = site_path.empty() ? built_in_site() : load_site(site_path);
    if (!preset.empty()) {
      p.site = with_preset(p.site, hal::preset_named(preset));
    }
    if (patched.empty() == changes.empty()) {
      throw hal::InputError("--patched", changes.empty() ? "no patched twin" : "--effect beside it",
                            "one of the two: a room, or effects to add to the twin",
                            "give --patched ROOM, or --effect ID=MAGNITUDE as often as needed");
    }
    if (changes.empty()) return p;
    const sim::Channels channels{p.site.counts.vavs, p.site.counts.fcus, p.site.counts.powers};
    p.patched = p.twin;
    for (const std::string& text : changes) {
      p.patched.changes.push_back(gap::parse_change(text, list, channels, p.plant));
    }
    p.measured.changes = p.patched.changes;
    return p;
  }
};

}  // namespace

void add_gap_retrain(CLI::App& gap) {
  auto self = std::make_shared<RetrainCommand>();
  gap::RetrainPlan& plan = self->plan;
  CLI::App* c = gap.add_subcommand(
      "retrain",
      "pretrain on the twin and on the patched twin, and run both sets of weights on a simulated measured room.\n"
      "A room is a name (301), a file (room.json, twin.epJSON), or 301+patch.json with merge patches (EnergyPlus).");
  c->add_option("--plant", plan.plant, "rc or energyplus")
      ->check(CLI::IsMember({"rc", "energyplus"}))
      ->capture_default_str();
  c->add_option("--twin", self->twin, "the room as it was modelled")->required();
  c->add_option("--patched", self->patched, "the room with what the workflow added");
  c->add_option("--effect", self->changes,
                "instead of --patched: ID=MAGNITUDE, added to the twin and true in the measured room");
  c->add_option("--measured", self->measured, "the room in which the effect is real")->required();
  c->add_option("--weather", plan.weather, "EPW of a year (default: made up for rc, Tampa for EnergyPlus)");
  c->add_option("--site", self->site_path, "site file: topology, target, hours, settings");
  c->add_option("--preset", self->preset, "product, paper or paper-repaired (default: the site's, else product)")
      ->check(CLI::IsMember(hal::preset_names()));
  c->add_option("--seeds", plan.seeds, "how many")->check(CLI::Range(1, 100))->capture_default_str();
  c->add_option("--first-seed", plan.first_seed, "the others follow it")->check(seed_check())->capture_default_str();
  c->add_option("--pretrain-days", plan.pretrain_days, "on each twin")
      ->check(CLI::Range(2, 364))
      ->capture_default_str();
  c->add_option("--expert-days", plan.expert_days, "days under the schedule before; not trained on")
      ->check(CLI::Range(0, 60))
      ->capture_default_str();
  c->add_option("--days", plan.days, "controlled days")->check(CLI::Range(1, 60))->capture_default_str();
  self->add_effects(*c);
  self->add_jobs(*c);
  self->add_json(*c);
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
