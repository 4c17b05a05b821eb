#include <algorithm>

#include "hal/input_error.hpp"
#include "sim/energyplus_install.hpp"
#include "sim/energyplus_options.hpp"
#include "sim/merge_patch.hpp"

namespace airside::sim {
namespace {

/// What of a room is not in its epJSON patches: people, dampers, weather, seed. The envelope, mass, gains and flows
/// are in sim/models/room_NAME.patch.json.
struct RoomHabits {
  const char* name;
  double occupancy_scale, occupancy_shift_min, damper_factor;
  std::uint64_t seed;
};

constexpr RoomHabits habits[] = {
    {"301", 1.00, 0, 1.00, 301}, {"401", 1.04, 10, 1.03, 401}, {"402", 0.97, -10, 0.97, 402},
    {"701", 1.02, 5, 1.00, 701}, {"702", 0.98, -5, 1.02, 702},
};

void add_patch(EnergyPlusOptions& options, const std::string& room) {
  const std::string file = "room_" + room + ".patch.json";
  options.patches.push_back({file, read_json(find_models() / file)});
}

/// How the built room departs from its twin beyond the patch: a warmer roof, other people, storms.
void make_real(EnergyPlusOptions& options, const std::string& room) {
  add_patch(options, room + "_real");
  options.weather_change.dry_bulb_offset_k = room.starts_with("7") ? -1.0 : 0.8;
  options.weather_change.solar_factor = room.ends_with("1") ? 1.1 : 0.9;
  options.weather_change.storms_per_week = 3;
  options.rooms.occupancy_scale *= room.ends_with("1") ? 1.05 : 0.96;
  options.rooms.occupancy_shift_min += room.ends_with("1") ? 12 : -8;
  options.rooms.supply_lag_s *= 1.3;
  options.seed += 9000;
}

}  // namespace

EnergyPlusOptions energyplus_room(const std::string& name) {
  EnergyPlusOptions options;
  options.name = name;
  if (name == "twin") return options;
  const bool real = name.ends_with("_real");
  const std::string room = real ? name.substr(0, name.size() - 5) : name;
  const auto* found = std::find_if(std::begin(habits), std::end(habits),
                                   [&room](const RoomHabits& habit) { return room == habit.name; });
  if (found == std::end(habits)) {
    std::string names;
    for (const auto& known : energyplus_room_names()) names += (names.empty() ? "" : ", ") + known;
    throw hal::InputError("room", "'" + name + "'", "one of " + names, "choose one, or give a model and patches");
  }
  options.name = "room " + name;
  options.rooms.occupancy_scale = found->occupancy_scale;
  options.rooms.occupancy_shift_min = found->occupancy_shift_min;
  for (double& damper : options.rooms.dampers) damper *= found->damper_factor;
  options.seed = found->seed;
  add_patch(options, room);
  if (real) make_real(options, room);
  return options;
}

std::vector<std::string> energyplus_room_names() {
  std::vector<std::string> names = {"twin"};
  for (const auto& habit : habits) {
    names.emplace_back(habit.name);
    names.push_back(std::string(habit.name) + "_real");
  }
  return names;
}

}  // namespace airside::sim
