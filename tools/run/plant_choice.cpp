#include "tools/run/plant_choice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <span>

#include "airside/crc32c.hpp"
#include "hal/text/civil_text.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/shell_word.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/energyplus/options.hpp"
#include "sim/energyplus/plant.hpp"
#include "sim/energyplus/rooms.hpp"
#include "sim/json/json_file.hpp"
#include "sim/learned/learned_plant.hpp"
#include "sim/rc/modulating_plant.hpp"
#include "sim/rc/rc_plant.hpp"
#include "sim/rc/rc_room_file.hpp"
#include "sim/scenarios/scenario.hpp"
#include "sim/stateless_draw.hpp"
#include "sim/weather/epw.hpp"
#include "sim/weather/synthetic_weather.hpp"
#include "tools/baselines/baseline.hpp"
#include "tools/run/options/option_checks.hpp"
#include "tools/run/twin_options.hpp"

namespace airside::tools {

namespace {

/// The room's own weather where no file is given: the same name always has the same year.
std::uint64_t weather_seed(const std::string& room, std::uint64_t seed) {
  return sim::seed_of_name(room) % 100000 + seed * 100000;
}

/// "study-7" or "tuning-3": a member of one of the two generated sets.
sim::RcRoom generated_room(const std::string& name) {
  constexpr int most = 200;
  int number = -1;
  const char* digits = name.c_str() + name.find('-') + 1;
  const auto [end, error] = std::from_chars(digits, name.c_str() + name.size(), number);
  if (error != std::errc{} || *end != '\0' || number < 0 || number >= most) {
    throw hal::InputError("--room " + name, "no such room",
                          fmt::format("study-0 .. study-{0} or tuning-0 .. tuning-{0}", most - 1),
                          "correct the number");
  }
  const sim::RcRoom base = sim::make_room();
  sim::RcRoom room =
      (name.starts_with("study-") ? sim::study_rooms(base, number + 1) : sim::tuning_rooms(base, number + 1)).back();
  room.name = name;
  return room;
}

bool is_standard(const Site& site) { return site.counts.vavs == 5 && site.counts.fcus == 5 && site.counts.powers == 2; }

bool same_shape(const sim::RcRoom& room, const Site& site) {
  return room.vavs == site.counts.vavs && room.fcus == site.counts.fcus && room.powers == site.counts.powers;
}

/// A room whose boxes modulate, of the site's shape; nothing for a name of another room.
std::optional<sim::ModulatingRoom> modulating_rc_room(const PlantChoice& choice, const Site& site) {
  const auto name = sim::modulating_name(choice.room);
  if (!name) return std::nullopt;
  if (site.counts.fcus > 0) {
    throw hal::InputError(
        "--room " + choice.room, "topology " + site.counts.name + ", which has fan coil units",
        fmt::format("{}vav-0fcu-{}power: rooms whose boxes modulate have none", site.counts.vavs, site.counts.powers),
        "give such a --topology or --site; airside init --objective band writes one");
  }
  if (!choice.changes.empty()) {
    throw hal::InputError("--room " + choice.room, "an effect to change in it", "a room with fixed dampers",
                          "choose another room");
  }
  return sim::modulating_room(name->scenario, name->seed, site.counts.vavs, site.counts.powers);
}

sim::RcRoom rc_room(const PlantChoice& choice, const Site& site) {
  sim::RcRoom room;
  if (is_standard(site) && (choice.room.starts_with("study-") || choice.room.starts_with("tuning-"))) {
    room = generated_room(choice.room);
  } else {
    room = sim::load_room(choice.room);
  }
  if (!is_standard(site) && !same_shape(room, site) && !choice.room.ends_with(".json")) {
    // The known rooms have the method's shape: another site gets a room of its own shape under that name.
    room = sim::make_room(site.counts.vavs, site.counts.fcus, site.counts.powers);
    if (choice.room.ends_with("-real")) room = sim::perturbed_room(room, weather_seed(choice.room, 0));
    room.name = choice.room;
  }
  if (!same_shape(room, site)) {
    throw hal::InputError(
        "--room " + choice.room, fmt::format("{} VAV, {} FCU, {} powers", room.vavs, room.fcus, room.powers),
        fmt::format("the site's {} VAV, {} FCU, {} powers", site.counts.vavs, site.counts.fcus, site.counts.powers),
        "choose a room of the site's shape, or another topology in the site file");
  }
  return room;
}

/// What the choice's scenario changes; nothing without one.
sim::Scenario scenario_of(const PlantChoice& choice, PlantKind plant) {
  if (choice.scenario.empty()) return {};
  const sim::Scenario& found = sim::scenario("--scenario", choice.scenario);
  const bool known = plant == PlantKind::rc ? found.on_rc : found.on_energyplus;
  if (known && !sim::modulating_name(choice.room) && !choice.twin) return found;
  throw hal::InputError("--scenario " + choice.scenario, "a plant that it does not change",
                        found.on_rc && found.on_energyplus ? "a room with fixed dampers and the built-in twin"
                        : found.on_rc                      ? "a room of --plant rc with fixed dampers"
                                                           : "--plant energyplus with its built-in rooms",
                        "choose another room or scenario");
}

std::unique_ptr<sim::PlantModel> make_rc(const PlantChoice& choice, const Site& site, CivilTime start) {
  if (auto modulating = modulating_rc_room(choice, site)) {
    (void)scenario_of(choice, PlantKind::rc);
    if (choice.weekends) modulating->building.occupancy_weekend_factor = 0.1;
    auto weather = choice.weather.empty() ? made_up_weather(choice) : sim::read_epw(choice.weather);
    return std::make_unique<sim::ModulatingPlant>(std::move(*modulating), std::move(weather), start, choice.seed,
                                                  site.settings.expert_off_degc);
  }
  sim::RcRoom room = rc_room(choice, site);
  const sim::Scenario under = scenario_of(choice, PlantKind::rc);
  if (choice.weekends || under.weekends) room.occupancy_weekend_factor = 0.1;
  const bool rests = choice.fan_start_h != choice.fan_stop_h;
  const double start_h = rests ? choice.fan_start_h : under.fan_start_h,
               stop_h = rests ? choice.fan_stop_h : under.fan_stop_h;
  if (start_h != stop_h) {
    room.ahu_stop_from_h = stop_h;
    room.ahu_stop_to_h = start_h;
  }
  if (under.change_room != nullptr) under.change_room(room);
  room = sim::changed_room(std::move(room), choice.changes);
  auto weather = choice.weather.empty() ? made_up_weather(choice) : sim::read_epw(choice.weather);
  return std::make_unique<sim::RcPlant>(std::move(room), std::move(weather), start, choice.seed,
                                        site.settings.expert_off_degc);
}

/// The known room, or the user's own model with the habits of that room: its people, dampers and fan coils.
sim::EnergyPlusOptions engine_room(const PlantChoice& choice, const Site& site) {
  if (!shape_fits(choice.twin, site.counts)) {
    throw hal::InputError("--plant energyplus", "topology " + site.counts.name, "5vav-5fcu-2power",
                          "use --plant rc for other shapes, or a model whose [twin.names] have this one");
  }
  if (choice.twin) {
    hal::TwinSection twin = *choice.twin;
    twin.patches.clear();  // those of the choice are added
    sim::EnergyPlusOptions options = twin_options(twin);
    options.name = twin.control == hal::TwinControl::own ? site.file.name : "twin";
    return options;
  }
  std::string name = choice.room;
  std::replace(name.begin(), name.end(), '-', '_');
  sim::EnergyPlusOptions options = sim::energyplus_room(name);
  options.name = choice.room;
  if (choice.model.empty()) return options;
  options.model = choice.model;
  options.patches.clear();  // they change objects of the built-in twin
  const bool usual = choice.room == PlantChoice{}.room || choice.room == "twin";
  options.name = usual ? "twin" : "twin with the habits of room " + choice.room;
  return options;
}

std::unique_ptr<sim::PlantModel> make_energyplus(const PlantChoice& choice, const Site& site, CivilTime start,
                                                 int days) {
  sim::EnergyPlusOptions options = engine_room(choice, site);
  for (const std::string& path : choice.patches) options.patches.push_back({path, sim::read_json(path)});
  if (!choice.weather.empty()) options.weather = choice.weather;
  const hal::CivilDate date = hal::civil_date(start);
  options.start_month = date.month;
  options.start_day = date.day;
  options.days = days;
  options.seed = choice.seed;
  options.initial_setpoint_degc = site.settings.expert_off_degc;
  const sim::Scenario under = scenario_of(choice, PlantKind::energyplus);
  if (choice.weekends || under.weekends) options.rooms.weekends = true;
  if (under.change_engine != nullptr) under.change_engine(options);
  options.rooms = sim::changed_loops(options.rooms, choice.changes);
  if (!choice.changes.empty() && !choice.changes_in_model) {
    const auto composed = sim::compose_model(options, sim::find_energyplus().schema);
    options.patches.push_back({"effects", sim::model_patch(composed, options.names, choice.changes)});
  }
  return std::make_unique<sim::EnergyPlusPlant>(options);
}

std::unique_ptr<sim::PlantModel> make_learned(const PlantChoice& choice, const Site& site, CivilTime start) {
  auto environment =
      std::make_shared<const sim::LearnedEnvironment>(sim::read_environment(choice.environment, site.counts));
  return std::make_unique<sim::LearnedPlant>(std::move(environment), site.counts, start, site.settings.expert_off_degc);
}

/// A learned environment has the physics and the weather of its log.
void refuse_beside_environment(const PlantChoice& choice) {
  const char* const beside = choice.kind == "energyplus" ? "--plant energyplus"
                             : !choice.model.empty()     ? "--twin"
                             : !choice.patches.empty()   ? "--patch"
                             : !choice.weather.empty()   ? "--weather"
                             : !choice.scenario.empty()  ? "--scenario"
                             : choice.weekends           ? "--weekends"
                                                         : nullptr;
  if (beside == nullptr) return;
  throw hal::InputError("--environment " + choice.environment, std::string(beside) + " beside it",
                        "a learned environment alone: it is no plant with physics", "leave one of them out");
}

/// The rc plant knows no epJSON: a model that it would leave out must not look as if it had been used.
void refuse_model_on_rc(const PlantChoice& choice, const Site& site) {
  if (choice.model.empty() && choice.patches.empty()) return;
  const bool by_site = !choice.site_twin.empty();
  const std::string place = by_site                 ? choice.site_twin + ": [twin]"
                            : !choice.model.empty() ? "--twin " + choice.model
                                                    : "--patch " + choice.patches.front();
  const std::string without = by_site ? "name a room of the rc plant with --room" : "leave it out";
  const std::string expected = "EnergyPlus 25.2, which alone runs epJSON models and their patches";
  if (choice.kind == "rc")
    throw hal::InputError(place, "--plant rc beside it", expected, "leave --plant rc out, or " + without);
  if (!shape_fits(choice.twin, site.counts))
    throw hal::InputError(place, "topology " + site.counts.name + ", which only the rc plant has", expected,
                          without + "; the EnergyPlus twin is the method's room, 5vav-5fcu-2power");
  throw hal::InputError(place, "no EnergyPlus on this machine", expected,
                        "run tools/setup, which installs it, or " + without);
}

}  // namespace

void add_plant_options(CLI::App& command, PlantChoice& choice, const std::string& default_start) {
  choice.start = default_start;
  command.add_option("--plant", choice.kind, "rc, energyplus, or auto: EnergyPlus where it is installed")
      ->check(CLI::IsMember({"auto", "rc", "energyplus"}))
      ->capture_default_str();
  command
      .add_option("--room", choice.room,
                  "301, 401, 402, 701, 702, each also as NAME-real; rc: also study-0 .. study-199, modulating-humid, "
                  "-mild, -reheat or -duct (boxes modulate), or a .json file")
      ->capture_default_str();
  command
      .add_option("--twin", choice.model,
                  "an epJSON model of your own instead of the built-in twin (EnergyPlus); no patch of a built-in "
                  "room goes onto it, --room then says only whose people, dampers and fan coils it has. Without a "
                  "file: the site's [twin]")
      ->expected(0, 1);
  command.add_option("--environment", choice.environment,
                     "a learned environment (tools/learn_environment) instead of a room with physics; it begins with "
                     "the days of its log that did not teach it");
  command.add_option("--patch", choice.patches, "merge patches on the model, in order (EnergyPlus)");
  command.add_option("--weather", choice.weather, "EPW file (default: Tampa for EnergyPlus, synthetic for rc)");
  command.add_option("--start", choice.start, "first day of all, midnight")->capture_default_str();
  command.add_option("--seed", choice.seed, "of all that is drawn")->check(seed_check())->capture_default_str();
  command.add_flag("--weekends", choice.weekends, "Saturday and Sunday nearly empty");
  command.add_option("--scenario", choice.scenario,
                     "a condition that is harder to control, with its own start day: january, irregular, outages, ... "
                     "(a wrong name lists all)");
}

void take_scenario_start(const CLI::App& command, PlantChoice& choice) {
  if (!choice.environment.empty() && command.count("--start") == 0)
    choice.start = sim::environment_start(choice.environment);
  if (choice.scenario.empty()) return;
  const sim::Scenario& under = sim::scenario("--scenario", choice.scenario);
  if (command.count("--start") == 0) choice.start = under.start;
  if (choice.start != under.start)
    fmt::print(stderr, "airside: note: --start {} replaces {}, the first day of scenario {}\n", choice.start,
               under.start, choice.scenario);
}

void take_site_twin(const CLI::App& command, PlantChoice& choice, const Site& site, TwinUse use) {
  if (!choice.environment.empty())
    refuse_given(command, {"--room"}, "--environment", "a learned environment alone: its log is of one room");
  const bool asked = command.count("--twin") > 0 && choice.model.empty();
  if (asked && !site.file.twin) {
    throw hal::InputError("--twin", "no file, and no [twin] in " + site.file.path, "a model",
                          "name an epJSON file after it, or give --site with a [twin]");
  }
  if (!site.file.twin || (use == TwinUse::when_asked && !asked)) return;
  const hal::TwinSection& twin = *site.file.twin;
  if (choice.weather.empty()) choice.weather = twin.weather;
  if (!choice.model.empty() || (!asked && command.count("--room") > 0)) return;
  const bool rc = twin.model == "rc";
  if (rc && choice.kind == "energyplus") {
    if (asked)
      refuse_given(command, {"--twin"}, "--plant energyplus", "another model than the site's [twin], which is \"rc\"");
    return;
  }
  if (rc && !twin.patches.empty()) {
    throw hal::InputError(site.file.path + ": twin.patches", "patches on model = \"rc\"", "an epJSON model to patch",
                          "leave the patches out, or name the model");
  }
  if (rc) {
    choice.kind = "rc";
    return;
  }
  if (twin.control == hal::TwinControl::own)
    refuse_given(command, {"--room", "--weekends"}, site.file.path + ": [twin]",
                 "a model whose people and boxes it can change",
                 "leave it out: with control = \"own\" the model's own schedules and thermostats run");
  choice.site_twin = site.file.path;
  choice.room = "twin";  // no patches of a built-in room on a model of the site's own
  choice.model = twin.model;
  choice.twin = twin;
  if (choice.patches.empty()) choice.patches = twin.patches;
}

CivilTime start_of(const PlantChoice& choice) {
  const auto t = hal::parse_civil_text(choice.start + "T00:00:00");
  if (!t) throw hal::InputError("--start", "'" + choice.start + "'", "a date such as 2021-07-01", "correct it");
  return *t;
}

bool is_energyplus(const PlantChoice& choice, const Site& site) {
  if (!choice.environment.empty()) return false;
  return choice.kind == "energyplus" ||
         (choice.kind == "auto" && shape_fits(choice.twin, site.counts) && sim::have_energyplus());
}

namespace {

/// Runs `make`; what it says of an unknown room is said of --room.
template <class Make>
auto with_room_option(Make&& make) {
  try {
    return make();
  } catch (const hal::InputError& e) {
    if (e.place() != "room") throw;
    std::string names = e.expected();  // the engine's rooms are files, named with underscores
    std::replace(names.begin(), names.end(), '_', '-');
    throw hal::InputError("--room", e.found(), names, e.remedy());
  }
}

}  // namespace

void check_room(const PlantChoice& choice, const Site& site) {
  if (!choice.environment.empty()) return static_cast<void>(make_plant(choice, site, 1));
  const bool energyplus = is_energyplus(choice, site);
  if (!energyplus) refuse_model_on_rc(choice, site);
  with_room_option([&] {
    if (energyplus) {
      (void)engine_room(choice, site);
    } else if (!modulating_rc_room(choice, site)) {
      (void)rc_room(choice, site);
    }
  });
}

std::string weather_file_text(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string text{std::istreambuf_iterator<char>(in), {}};
  if (!in && text.empty()) return "";
  return fmt::format("{} (CRC-32C {:08x})", file.filename().string(), crc32c(std::as_bytes(std::span(text))));
}

std::string weather_text(const PlantChoice& choice, const Site& site) {
  if (!choice.environment.empty()) return "of its log";
  if (!choice.weather.empty()) return weather_file_text(choice.weather);
  if (!is_energyplus(choice, site)) return made_up_weather(choice)->description();
  if (!sim::have_energyplus()) return "";
  return weather_file_text(sim::default_weather(sim::find_energyplus()));
}

std::shared_ptr<const sim::Weather> made_up_weather(const PlantChoice& choice) {
  const std::string& of = choice.weather_of.empty() ? choice.room : choice.weather_of;
  const auto modulating = sim::modulating_name(of);
  const sim::Climate climate = modulating ? sim::modulating_room(modulating->scenario, 0).climate : sim::Climate{};
  return sim::synthetic_weather(weather_seed(of, choice.seed), climate,
                                fmt::format("of room {}, seed {}", of, choice.seed));
}

std::unique_ptr<sim::PlantModel> make_plant(const PlantChoice& choice, const Site& site, int days) {
  const CivilTime start = start_of(choice);
  if (!choice.environment.empty()) {
    refuse_beside_environment(choice);
    return make_learned(choice, site, start);
  }
  const bool energyplus = is_energyplus(choice, site);
  if (!energyplus) refuse_model_on_rc(choice, site);
  return with_room_option([&]() -> std::unique_ptr<sim::PlantModel> {
    if (energyplus) return make_energyplus(choice, site, start, days);
    return make_rc(choice, site, start);
  });
}

std::string command_text(const PlantChoice& choice, const Site& site) {
  const std::string when = fmt::format(" --start {} --seed {}", choice.start, choice.seed);
  if (!choice.environment.empty()) return "--environment " + hal::shell_word(choice.environment) + when;
  std::string text = fmt::format("--plant {} --room {}{}", is_energyplus(choice, site) ? "energyplus" : "rc",
                                 hal::shell_word(choice.room), when);
  const bool of_site = choice.twin && choice.patches == choice.twin->patches;
  if (!choice.model.empty()) text += of_site ? " --twin" : " --twin " + hal::shell_word(choice.model);
  for (const std::string& patch : choice.patches) text += of_site ? "" : " --patch " + hal::shell_word(patch);
  if (!choice.weather.empty()) text += " --weather " + hal::shell_word(choice.weather);
  if (choice.weekends) text += " --weekends";
  if (!choice.scenario.empty()) text += " --scenario " + hal::shell_word(choice.scenario);
  return text;
}

}  // namespace airside::tools
