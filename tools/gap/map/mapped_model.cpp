#include "tools/gap/map/mapped_model.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <optional>

#include "hal/storage/digest64.hpp"
#include "hal/text/input_error.hpp"
#include "hal/text/text_file.hpp"
#include "hal/text/toml_section.hpp"
#include "sim/energyplus/adopted/model_index.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/energyplus/rooms.hpp"
#include "sim/json/json_file.hpp"
#include "sim/json/merge_patch.hpp"
#include "tools/adopt/loop/air_loop.hpp"
#include "tools/adopt/model/foreign_file.hpp"
#include "tools/gap/map/engine_outputs.hpp"
#include "tools/gap/model/patched_model.hpp"

namespace airside::tools::gap {

namespace {

namespace fs = std::filesystem;
using nlohmann::json;

/// Names of a model, looked for by a mapping.
class NameFinder {
 public:
  NameFinder(const Mapping& mapping, const json& model) : mapping_(mapping), index_(model), model_(model) {}

  /// As the model spells it.
  std::string object(const char* type, const std::string& name, const std::string& place, const char* what) const {
    const sim::ModelObject found = index_.find(type, name);
    if (found.fields == nullptr) refuse(place, name, index_.names_of(type), what);
    return found.name;
  }

  std::string node(const std::string& name, const std::string& place) const {
    if (!index_.text(name)) refuse(place, name, index_.nodes(), "a node of the model, whose temperature is read");
    return name;
  }

  std::string schedule(const MappedCommand& command) const {
    const sim::ModelObject found = sim::find_command_schedule(model_, command.schedule);
    if (found.fields != nullptr) return found.name;
    std::vector<std::string> known;
    for (const char* type : sim::command_schedule_types) {
      const auto names = index_.names_of(type);
      known.insert(known.end(), names.begin(), names.end());
    }
    refuse(command.place + ".schedule", command.schedule, known,
           "a Schedule:Constant, Compact, Year or File, which the record's commands take the place of");
  }

 private:
  [[noreturn]] void refuse(const std::string& place, const std::string& name, const std::vector<std::string>& known,
                           const char* what) const {
    constexpr std::size_t most_near = 5;
    auto near = hal::near_names(name, known, most_near);
    if (near.empty()) near.assign(known.begin(), known.begin() + std::min<std::ptrdiff_t>(5, std::ssize(known)));
    throw hal::InputError(place,
                          "no \"" + name + "\" in " + mapping_.model +
                              (near.empty() ? "" : fmt::format("; it has \"{}\"", fmt::join(near, "\", \""))),
                          what, "correct the mapping; names are compared without case");
  }

  const Mapping& mapping_;
  sim::ModelIndex index_;
  const json& model_;
};

/// The outlet of the one loop that was named.
std::string outlet_of(const Mapping& m, const json& model, const std::string& loop) {
  const ModelView view(model, m.model);
  return walk_air_loop(view, loop).supply_outlet;
}

/// Meters of the model's own that sum others up.
void add_sums(const Mapping& m, json& model, const json& schema) {
  const json& known = schema.at("properties").at("Meter:Custom").at("patternProperties").begin()->at("properties");
  const char* resource = known.contains("resource_type") ? "resource_type" : "fuel_type";  // its older name
  for (const MappedChannel& c : m.channels) {
    if (c.summed.empty()) continue;
    json parts = json::array();
    for (const std::string& meter : c.summed)
      parts.push_back({{"key_name", ""}, {"output_variable_or_meter_name", meter}});
    model["Meter:Custom"][c.meter] = {{resource, "Generic"}, {"variable_details", parts}};
  }
}

void find_own_objects(const Mapping& m, const NameFinder& find, sim::OwnNames& own) {
  for (const MappedChannel& c : m.channels) {
    const std::string key_place = c.place + ".key";
    switch (c.kind) {
      case MappedKind::room_temperature: {
        sim::OwnOutput& output = own.room_outputs[m.place_of(c)];
        if (!c.output.empty()) output.key = c.key, output.variable = c.output;
        break;
      }
      case MappedKind::supply_temperature: own.supply_air_node = find.node(c.key, key_place); break;
      case MappedKind::preheated_temperature: own.mau_outlet_node = find.node(c.key, key_place); break;
      case MappedKind::outdoor_temperature: own.outdoor_measured = true; break;
      case MappedKind::power: {
        own.powers.push_back(c.meter);
        own.power_outputs.emplace_back();
        if (c.meter.empty()) own.power_outputs.back().key = c.key, own.power_outputs.back().variable = c.output;
        break;
      }
      case MappedKind::damper:
        own.terminals.resize(m.zones.size());
        own.terminals[m.place_of(c)] = find.object("AirTerminal:", c.key, key_place, "an air terminal with a damper");
        break;
    }
  }
}

/// The column of a replay that a channel is compared with; none of outdoor air.
std::optional<int> column_of(const Mapping& m, const MappedChannel& c, const sim::Channels& at) {
  const int place = static_cast<int>(m.place_of(c));
  switch (c.kind) {
    case MappedKind::room_temperature: return place;
    case MappedKind::preheated_temperature: return at.mau_temp();
    case MappedKind::supply_temperature: return at.supply_temp();
    case MappedKind::power: return at.power() + place;
    case MappedKind::damper: return at.damper() + place;
    case MappedKind::outdoor_temperature: break;
  }
  return std::nullopt;
}

std::vector<sim::ChannelGrain> grain_of(const Mapping& m, const sim::OwnNames& own) {
  constexpr int bin_min = 30;
  sim::Channels at;
  at.rooms = static_cast<int>(own.zones.size());
  at.powers = static_cast<int>(own.powers.size());
  at.dampers = static_cast<int>(own.terminals.size());
  std::vector<sim::ChannelGrain> grain(static_cast<std::size_t>(at.count()));
  for (const MappedChannel& c : m.channels) {
    const auto column = column_of(m, c, at);
    if (!column) continue;
    sim::ChannelGrain& g = grain[static_cast<std::size_t>(*column)];
    g.floor = c.noise_floor;
    if (c.kind == MappedKind::room_temperature || c.kind == MappedKind::power) g.title = c.column;
    if (m.log.step_min > bin_min) g.step_min = m.log.step_min, g.instants = !c.mean;
  }
  return grain;
}

}  // namespace

sim::OwnNames own_names_of(const Mapping& m, const json& model) {
  const NameFinder find(m, model);
  sim::OwnNames own;
  for (const std::string& zone : m.zones) {
    std::string place = m.place + ".zones";
    for (const MappedChannel& c : m.channels) {
      if (c.zone == zone) place = c.place + ".zone";
    }
    own.zones.push_back(find.object("Zone", zone, place, "a Zone of the model"));
  }
  own.room_outputs.resize(m.zones.size());
  own.outdoor_measured = false;
  own.every_air_loop = m.air_loops.empty();
  find_own_objects(m, find, own);
  own.grain = grain_of(m, own);
  for (const std::string& loop : m.air_loops)
    own.air_loops.push_back(find.object("AirLoopHVAC", loop, m.place + ".air_loops", "an air loop of the model"));
  if (own.air_loops.size() == 1 && own.supply_air_node.empty())
    own.supply_air_node = outlet_of(m, model, own.air_loops.front());
  if (const MappedCommand* setpoint = m.supply_setpoint()) own.supply_setpoint_schedule = find.schedule(*setpoint);
  for (const MappedCommand* command : m.further_commands()) own.commands.push_back(find.schedule(*command));
  return own;
}

sim::EnergyPlusOptions mapped_options(const Mapping& m, const fs::path& model) {
  sim::EnergyPlusOptions options = sim::energyplus_room("twin");
  options.name = m.model;
  options.model = model;
  options.patches.clear();
  options.weather = m.weather;
  options.step_min = m.step_min;
  options.rooms.supply_lag_s = 0;
  options.own = own_names_of(m, sim::read_model(model));
  return options;
}

fs::path prepare_mapped_model(const Mapping& m, const fs::path& cache) {
  const sim::EnergyPlusInstall install = sim::find_energyplus();
  json content = read_foreign_model(m.model, install).content;
  for (const std::string& patch : m.patches)
    content = sim::merge_patched(std::move(content), sim::read_json(patch), patch);
  const bool sums = std::any_of(m.channels.begin(), m.channels.end(), [](const auto& c) { return !c.summed.empty(); });
  if (sums) add_sums(m, content, sim::read_json(install.schema));
  const std::string all = content.dump() + hal::read_text_file(m.path, "a mapping file in TOML") +
                          hal::read_text_file(m.weather, "an EPW file") + sim::version_of(install);
  const fs::path made =
      cache / fmt::format("mapped-{:016x}.epJSON", hal::digest64(std::as_bytes(std::span(all.data(), all.size()))));
  if (fs::exists(made)) return made;
  std::error_code failed;
  fs::create_directories(cache, failed);
  const fs::path unsized = cache / fmt::format("{}.{}.part.epJSON", made.stem().string(), ::getpid());
  write_whole_file(unsized, content.dump(1) + "\n");
  FoundSizes sizes;
  try {
    sizes = check_outputs(sim::twin_of(mapped_options(m, unsized)), m, install);
  } catch (...) {
    fs::remove(unsized, failed);
    throw;
  }
  fs::remove(unsized, failed);
  write_whole_file(made, sim::merge_patched(content, sizes.patch, "sizes").dump(1) + "\n");
  return made;
}

}  // namespace airside::tools::gap
