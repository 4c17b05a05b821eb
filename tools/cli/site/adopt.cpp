// airside adopt: a site from an EnergyPlus model that somebody else wrote.

#include <fmt/format.h>

#include <chrono>
#include <filesystem>
#include <optional>

#include "tools/adopt/adoption.hpp"
#include "tools/adopt/advice.hpp"
#include "tools/adopt/site_text.hpp"
#include "tools/cli/command.hpp"

namespace airside::tools {

namespace {

struct AdoptCommand {
  std::string model, air_loop, weather, folder, transitions;
  bool force = false, as_json = false;

  void run() const {
    AdoptRequest request{model, air_loop, weather, folder, force, {}, transitions};
    std::optional<Progress> bar;
    const auto start = std::chrono::steady_clock::now();
    request.progress = [&](int done, int planned, const std::string& what) {
      if (!bar) bar.emplace(fmt::format("adopting with {} runs of the engine", planned), planned);
      const double taken_s = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
      bar->report(static_cast<std::uint64_t>(done), done > 0 ? taken_s * (planned - done) / done : 0, what);
    };
    const Adoption a = adopt(request);
    if (bar) bar->finish();
    if (as_json) {
      fmt::print("{}\n", nlohmann::json{{"site", folder + "/site.toml"},
                                        {"topology", a.topology()},
                                        {"air_loop", a.loop.name},
                                        {"terminals", text_of(a.loop.kind())},
                                        {"objective", a.serves_band() ? "band" : "mean"},
                                        {"target_degc", a.choices.target_degc},
                                        {"setpoint_min_degc", a.choices.min_degc},
                                        {"setpoint_max_degc", a.choices.max_degc},
                                        {"weather", a.weather_name},
                                        {"upgraded_from", a.upgrade.from},
                                        {"summer", json_of(a.seasons[0])},
                                        {"winter", json_of(a.seasons[1])},
                                        {"autumn", json_of(a.seasons[2])},
                                        {"advice", json_of(advice_on(a))},
                                        {"sizes_written", a.sizes.written},
                                        {"sizes_open", a.sizes.open}}
                             .dump());
      return;
    }
    fmt::print("adopted the air loop {} of {}: {}, terminals {}\n", a.loop.name, a.model_name, a.topology(),
               text_of(a.loop.kind()));
    if (!a.upgrade.from.empty()) fmt::print("{}\n", text_of(a.upgrade));
    fmt::print("target {:.2f} degC, setpoint {:.1f} to {:.1f} degC, weather {}\n", a.choices.target_degc,
               a.choices.min_degc, a.choices.max_degc, a.weather_name);
    for (const Comparison& c : a.seasons) {
      if (c.response.known)
        fmt::print("{}: supply {:+.2f}, rooms {:+.3f} K per K of setpoint\n", text_of(c.season), c.response.supply_gain,
                   c.response.room_gain);
    }
    fmt::print("{}", advice_lines(a));
    const std::string inside = (std::filesystem::path(folder) / "").string();
    fmt::print("Read {}adopt.md, then:\n{}", inside, next_steps(a, inside));
  }
};

}  // namespace

void add_adopt(CLI::App& app) {
  auto self = std::make_shared<AdoptCommand>();
  CLI::App* c = app.add_subcommand(
      "adopt",
      "make a site from an EnergyPlus model that somebody else wrote: site file, points, the model with a patch that\n"
      "frees its supply-air setpoint, and adopt.md, which says what was found, chosen and not found.\n"
      "Runs the model for some days; takes 10 to 60 s.");
  c->add_option("model", self->model, "an .idf or .epJSON file of EnergyPlus 8.9 up to the installed engine's version")
      ->required();
  c->add_option("--air-loop", self->air_loop, "which AirLoopHVAC, where the model has several");
  c->add_option("--weather", self->weather, "an EPW file (default: the nearest station at hand)");
  c->add_option("--transitions", self->transitions,
                "upgrade an older IDF with EnergyPlus's own Transition programs in this folder, or in this EnergyPlus\n"
                "install (default: AIRSIDE_TRANSITIONS, else the engine's, else the tables of this program)");
  c->add_option("-o,--output", self->folder, "the site's folder; it must not have files yet")->required();
  c->add_flag("--force", self->force, "replace files of the same names in a folder that has some");
  c->add_flag("--json", self->as_json, "print one JSON object and nothing else on standard output");
  c->callback([self] { self->run(); });
}

}  // namespace airside::tools
