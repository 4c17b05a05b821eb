#include "hal/site/site_settings.hpp"
#include "hal/text/input_error.hpp"
#include "module.hpp"
#include "tools/cli/simulation.hpp"

namespace airside::python {

namespace {

struct Options {
  std::string method, room, start, topology;
  std::uint64_t seed;
  int days, expert_days, steps;
  bool transfer, weekends;
  std::optional<std::string> weights, site, preset, weather, history, faults, log, history_log;
};

tools::Simulation simulation_of(const Options& o) {
  tools::Simulation s;
  s.site = {o.site.value_or(""), o.preset.value_or(""), o.topology};
  s.plant.kind = "rc";
  s.plant.room = o.room;
  s.plant.start = o.start;
  s.plant.seed = o.seed;
  s.plant.weekends = o.weekends;
  s.plant.weather = o.weather.value_or("");
  s.method = o.method;
  s.days = o.days;
  s.expert_days = o.expert_days;
  s.steps = o.steps;
  s.steps_given = o.steps != tools::Simulation{}.steps;
  s.transfer = o.transfer;
  s.weights = o.weights.value_or("");
  s.history = o.history.value_or("");
  s.faults = o.faults.value_or("");
  s.log = o.log.value_or("");
  s.history_log = o.history_log.value_or("");
  return s;
}

nb::dict simulate(const Options& options, const nb::object& progress) {
  const tools::Simulation simulation = simulation_of(options);
  std::optional<tools::Simulation::Ready> ready;
  tools::Simulation::Recorded done;
  std::string json;
  const tools::OnProgress on_progress = progress_of(progress);
  {
    const nb::gil_scoped_release free;
    ready = simulation.make_ready(tools::make_site(simulation.site));
    done = simulation.run_recorded(*ready, [&] { return on_progress; });
    json = simulation.json_of(*ready, done.run).dump();
  }
  const hal::TopologyCounts& counts = ready->trial.site.counts;
  nb::dict out;
  out["json"] = json;
  out["log"] = dict_of(counts, done.run.control.rows, true);
  out["history"] = dict_of(counts, done.run.history, true);
  out["weather"] = done.weather;
  return out;
}

}  // namespace

void add_simulate(nb::module_& m) {
  using Text = std::optional<std::string>;
  m.def(
      "simulate",
      [](const std::string& method, const std::string& room, std::uint64_t seed, int days, int expert_days,
         const std::string& start, const Text& weights, bool transfer, int steps, const Text& site,
         const std::string& topology, const Text& preset, const Text& weather, bool weekends, const Text& history,
         const Text& faults, const Text& log, const Text& history_log, const nb::object& progress) {
        return simulate({method, room, start, topology, seed, days, expert_days, steps, transfer, weekends, weights,
                         site, preset, weather, history, faults, log, history_log},
                        progress);
      },
      nb::kw_only(), nb::arg("method"), nb::arg("room"), nb::arg("seed"), nb::arg("days"), nb::arg("expert_days"),
      nb::arg("start"), nb::arg("weights").none(), nb::arg("transfer"), nb::arg("steps"), nb::arg("site").none(),
      nb::arg("topology"), nb::arg("preset").none(), nb::arg("weather").none(), nb::arg("weekends"),
      nb::arg("history").none(), nb::arg("faults").none(), nb::arg("log").none(), nb::arg("history_log").none(),
      nb::arg("progress").none(), "One method on one RC room: figures as JSON text, and the rows as arrays.");
  m.def("preset_names", &hal::preset_names, "The controller's presets.");
}

}  // namespace airside::python
