#include <cstdio>

#include "hal/text/input_error.hpp"
#include "module.hpp"
#include "tools/cli/gap/site_gap.hpp"

namespace airside::python {

namespace {

/// The workflow, from options to what `airside gap --json` prints.
std::string run(const tools::SiteGap& options, bool progress) {
  const nb::gil_scoped_release free;
  const tools::gap::GapRequest asked = options.request();
  options.check_places(asked);
  const std::vector<sim::Effect> effects = options.searched();
  tools::StagedProgress shown(progress ? stderr : nullptr);
  const tools::SiteGap::Finished done = options.finish(tools::gap::run_gap(asked, effects, shown));
  return done.json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
}

}  // namespace

void add_gap(nb::module_& m) {
  using Text = std::optional<std::string>;
  m.def(
      "gap",
      [](const std::string& measured, const Text& site, const Text& plant, const Text& room, const Text& twin,
         const std::vector<std::string>& patches, const Text& weather, const Text& reference, int reference_days,
         bool no_reference, const Text& effects, const std::vector<std::string>& tries, std::optional<int> buildings,
         bool best_guess, bool findings_only, bool no_duties, bool sun_on_site, std::optional<int> jobs,
         const std::string& out, bool progress) {
        tools::SiteGap o;
        o.measured = measured;
        o.site_path = site.value_or("");
        o.plant = plant.value_or("");
        o.room = room.value_or("");
        o.twin = twin.value_or("");
        o.patches = patches;
        o.weather = weather.value_or("");
        o.reference = reference.value_or("");
        o.reference_days = reference_days;
        o.no_reference = no_reference;
        o.effects_dir = effects.value_or("");
        o.tries = tries;
        o.buildings = buildings;
        o.best_guess = best_guess;
        o.findings_only = findings_only;
        o.no_duties = no_duties;
        o.sun_on_site = sun_on_site;
        if (jobs) o.jobs = *jobs;
        o.out = out;
        return run(o, progress);
      },
      nb::kw_only(), nb::arg("measured"), nb::arg("site").none(), nb::arg("plant").none(), nb::arg("room").none(),
      nb::arg("twin").none(), nb::arg("patches"), nb::arg("weather").none(), nb::arg("reference").none(),
      nb::arg("reference_days"), nb::arg("no_reference"), nb::arg("effects").none(), nb::arg("tries"),
      nb::arg("buildings").none(), nb::arg("best_guess"), nb::arg("findings_only"), nb::arg("no_duties"),
      nb::arg("sun_on_site"), nb::arg("jobs").none(), nb::arg("out"), nb::arg("progress"),
      "The gap workflow on one site: what `airside gap --json` prints, and its folder.");
}

}  // namespace airside::python
