// airside gap run: one site's log against its model, from clean-up to patched twin and report.

#include "tools/cli/gap/gap.hpp"
#include "tools/cli/gap/site_gap.hpp"

namespace airside::tools {

namespace {

namespace fs = std::filesystem;

/// The workflow on one site, with report.
struct SiteCommand : SiteGap {
  /// All options, so that a subcommand can refuse them.
  std::vector<CLI::Option*> add_to(CLI::App& c) {
    add_effects(c);
    add_jobs(c);
    add_json(c);
    c.add_option("--site", site_path, "site file: topology, and [twin] with model, patches and weather");
    CLI::Option* mapped = c.add_option(
        "--map", map,
        "mapping file: any EnergyPlus model and any log, by columns, units, outputs, meters and schedules");
    c.add_option("--measured", measured, "log to judge: a CSV file, or a folder of daily ones");
    c.add_option("--reference", reference, "log of days on which plant and room were as the twin describes");
    c.add_option("--reference-days", reference_days, "the first days of --measured are the reference")
        ->check(CLI::Range(2, 366));
    c.add_flag("--no-reference", no_reference,
               "there are no such days: parameters are what their priors have, and answers are wider");
    c.add_option("--twin", twin, "epJSON model of the room (default: the site's)");
    c.add_option("--patch", patches, "merge patches on the twin, in order (default: the site's)");
    c.add_option("--plant", plant, "rc or energyplus: the kind of model where no --twin is given")
        ->check(CLI::IsMember({"rc", "energyplus"}));
    c.add_option("--room", room, "built-in room or, for rc, a room file; without --twin");
    c.add_option("--weather", weather, "EPW of the site or its station (default: the site's)");
    c.add_option("-o,--out", out, "folder for the report, gap.json and the patch")->capture_default_str();
    c.add_option("--apply", apply, "write the patched twin to this file");
    c.add_flag("--best-guess", best_guess, "patch the twin with an ambiguous verdict too");
    c.add_flag("--findings-only", findings_only, "the twin keeps its own parameters: add only what was found");
    c.add_flag("--no-duties", no_duties, "leave the fan coils' duties out, which need a second run each on EnergyPlus");
    c.add_flag("--sun-on-site", sun_on_site, "the weather file's sun was measured on the site: it is not in doubt");
    c.add_option("--try", tries,
                 "a suspicion of your own, EFFECT=SIZE or EFFECT@PLACE=SIZE such as vav_flow@2=0.5: does the log speak "
                 "for it?");
    add_gap_buildings(c, buildings);
    CLI::Option* priced =
        c.add_option("--price", price, "of a kWh of any meter: what a finding costs is said in money too")
            ->check(CLI::PositiveNumber);
    c.add_option("--currency", currency, "with --price: its name")->capture_default_str()->needs(priced);
    c.add_option("--keep-run", keep_run, "folder for the patched twin's run, which plain energyplus repeats");
    CLI::Option* retrains = c.add_flag("--retrain", retrain,
                                       "pretrain on the twin and on the patched twin, and run both sets of weights on "
                                       "the measured room: what the patch is worth to the controller");
    c.add_option("--measured-room", measured_room,
                 "with --retrain: the simulated room that plays the measured one, since a log cannot answer to other "
                 "setpoints: a name, a file, or 301+patch.json (default: the patched twin, and labelled so)")
        ->needs(retrains);
    c.add_option("--seeds", seeds, "with --retrain: how many")
        ->check(CLI::Range(1, 100))
        ->capture_default_str()
        ->needs(retrains);
    c.add_option("--pretrain-days", pretrain_days, "with --retrain: on each twin")
        ->check(CLI::Range(2, 364))
        ->capture_default_str()
        ->needs(retrains);
    c.add_option("--control-days", control_days, "with --retrain: days controlled in the measured room")
        ->check(CLI::Range(1, 60))
        ->capture_default_str()
        ->needs(retrains);
    for (CLI::Option* other : c.get_options()) {
      for (const char* name : {"--site", "--twin", "--plant", "--room", "--weather", "--retrain"}) {
        if (other->check_name(name)) mapped->excludes(other);
      }
    }
    c.add_option("--cache", cache, "folder of finished EnergyPlus runs (default: OUT/runs)");
    std::vector<CLI::Option*> options;
    for (CLI::Option* o : c.get_options()) {
      if (o != c.get_help_ptr()) options.push_back(o);
    }
    return options;
  }

  void run() const {
    if (measured.empty()) throw CLI::RequiredError("--measured (or a subcommand)");
    const gap::GapRequest asked = request();
    check_places(asked);
    const auto list = searched();
    try {
      StagedProgress progress(stderr);
      const Finished done = finish(gap::run_gap(asked, list, progress));
      print_gap(done.run, done.json, done.facts, json);
      check_patched(done.run);
    } catch (const gap::RefusedLog& e) {
      print_clean_up(stderr, e.logs().reference);
      print_clean_up(stderr, e.logs().measured);
      throw;
    }
  }
};

}  // namespace

void add_gap_buildings(CLI::App& command, std::optional<int>& buildings) {
  command
      .add_option(
          "--buildings", buildings,
          "buildings drawn for how far a right model may be off in the measured days; 0: the reference period alone "
          "says it (default: 96, 0 of a model with controls of its own)")
      ->check(CLI::Range(0, 1000));
}

void GapOptions::add_effects(CLI::App& c) {
  c.add_option("--effects", effects_dir, "folder of effect files (default: sim/effects/library)");
}

void GapOptions::add_jobs(CLI::App& c) {
  c.add_option("--jobs", jobs, "simulations at a time")->check(CLI::Range(1, 256))->capture_default_str();
}

void GapOptions::add_json(CLI::App& c) {
  c.add_flag("--json", json, "print one JSON object and nothing else on standard output");
}

void add_gap_run(CLI::App& gap) {
  auto whole = std::make_shared<SiteCommand>();
  const std::vector<CLI::Option*> alone = whole->add_to(gap);
  for (CLI::App* part : gap.get_subcommands([](CLI::App*) { return true; })) {
    for (CLI::Option* option : alone) part->excludes(option);
  }
  gap.callback([&gap, whole] {
    if (gap.get_subcommands().empty()) whole->run();
  });
  auto same = std::make_shared<SiteCommand>();
  CLI::App* c = gap.add_subcommand("run", "the same as airside gap with these options and no subcommand");
  same->add_to(*c);
  for (CLI::Option* option : alone) c->excludes(option);
  c->callback([same] { same->run(); });
}

}  // namespace airside::tools
