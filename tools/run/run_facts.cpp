#include "tools/run/run_facts.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "hal/system/version.hpp"
#include "sim/energyplus/install.hpp"

namespace airside::tools {

std::string program_text() { return hal::version_line("airside"); }

RunFacts run_facts(bool energyplus, std::string weather) {
  RunFacts facts;
  facts.plant = energyplus ? "energyplus" : "rc";
  facts.engine = !energyplus              ? fmt::format("RC plant of airside {}", hal::version())
                 : sim::have_energyplus() ? "EnergyPlus " + sim::version_of(sim::find_energyplus())
                                          : "EnergyPlus, not installed here";
  facts.weather = std::move(weather);
  return facts;
}

RunFacts run_facts(const PlantChoice& choice, const Site& site) {
  if (!choice.environment.empty()) {
    return {"learned", "learned environment " + weather_file_text(choice.environment), weather_text(choice, site), ""};
  }
  RunFacts facts = run_facts(is_energyplus(choice, site), weather_text(choice, site));
  if (choice.kind != "auto" || facts.plant == "energyplus") return facts;
  facts.fallback = sim::have_energyplus() ? "EnergyPlus has no room of topology " + site.counts.name
                                          : "EnergyPlus is not installed (tools/setup installs it)";
  return facts;
}

std::string text_of(const RunFacts& facts) {
  return fmt::format("{}{}{}, {}", facts.engine, facts.weather.empty() ? "" : ", weather ", facts.weather,
                     program_text());
}

void add_to(nlohmann::json& j, const RunFacts& facts) {
  j["plant_kind"] = facts.plant;
  j["engine"] = facts.engine;
  j["weather"] = facts.weather;
  if (!facts.fallback.empty()) j["fallback"] = facts.fallback;
  add_program_to(j);
}

void add_program_to(nlohmann::json& j) {
  j["version"] = hal::version();
  j["commit"] = hal::commit();
}

void say_fallback(const RunFacts& facts) {
  if (facts.fallback.empty()) return;
  fmt::print(stderr,
             "airside: note: the RC plant runs, since {}; its figures are not EnergyPlus's. --plant rc says that this "
             "is meant\n",
             facts.fallback);
}

}  // namespace airside::tools
