#include <algorithm>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "airside/splitmix64.hpp"
#include "hal/text/input_error.hpp"
#include "sim/energyplus/install.hpp"
#include "sim/energyplus/options.hpp"
#include "sim/json/json_file.hpp"
#include "sim/stateless_draw.hpp"

namespace airside::sim {
namespace {

/// What of a room is not in its epJSON patches. The envelope, mass, gains and flows are in
/// sim/models/room_NAME.patch.json.
struct RoomHabits {
  const char* name;
  double occupancy_scale, occupancy_shift_min, damper_factor;
  std::uint64_t seed;
};

constexpr RoomHabits habits[] = {
    {"301", 1.00, 0, 1.00, 301}, {"401", 1.04, 10, 1.03, 401}, {"402", 0.97, -10, 0.97, 402},
    {"701", 1.02, 5, 1.00, 701}, {"702", 0.98, -5, 1.02, 702},
};

/// How the built room departs from its twin beyond the patch: sensor error, fan coil setting, people, weather.
struct Departures {
  const char* name;
  double supply_bias_k, fcu_offset_k, occupancy_factor, occupancy_shift_min;
  double dry_bulb_offset_k, solar_factor;
  double damper_factors[5];
};

constexpr Departures departures[] = {
    {"301", -0.9, 0.7, 1.05, 12, 0.8, 1.10, {1.06, 0.93, 0.96, 1.04, 0.92}},
    {"401", -0.8, -0.7, 0.97, -8, -0.6, 0.90, {0.95, 1.07, 1.02, 0.92, 1.05}},
    {"402", -0.8, -0.8, 1.04, 10, 0.8, 0.95, {1.08, 0.97, 0.93, 1.05, 0.95}},
    {"701", -0.7, -0.7, 1.04, -10, -1.0, 1.10, {0.94, 1.05, 0.95, 1.06, 0.97}},
    {"702", -0.9, -0.8, 0.96, 8, -1.0, 0.90, {1.03, 0.94, 1.06, 0.95, 1.04}},
};

void add_patch(EnergyPlusOptions& options, const std::string& room) {
  const std::string file = "room_" + room + ".patch.json";
  options.patches.push_back({file, read_json(find_models() / file)});
}

void make_real(EnergyPlusOptions& options, const Departures& by) {
  add_patch(options, std::string(by.name) + "_real");
  RoomLoopOptions& rooms = options.rooms;
  rooms.supply_bias_k = by.supply_bias_k;
  rooms.fcu_setpoint_degc += by.fcu_offset_k;
  rooms.occupancy_scale *= by.occupancy_factor;
  rooms.occupancy_shift_min += by.occupancy_shift_min;
  rooms.supply_lag_s *= 1.5;
  for (std::size_t i = 0; i < rooms.dampers.size(); ++i) rooms.dampers[i] *= by.damper_factors[i];
  options.weather_change = {by.dry_bulb_offset_k, by.solar_factor, 3};
  options.seed += 9000;
}

constexpr std::string_view tuning_prefix = "tuning_";
constexpr int most_tuning_rooms = 200;

std::optional<int> tuning_number(const std::string& name) {
  if (!name.starts_with(tuning_prefix)) return {};
  int number = -1;
  const char* const end = name.data() + name.size();
  const auto [stop, error] = std::from_chars(name.data() + tuning_prefix.size(), end, number);
  const bool is_known = error == std::errc{} && stop == end && number >= 0 && number < most_tuning_rooms;
  return is_known ? std::optional(number) : std::nullopt;
}

/// exp(uniform in +-ln most), the same for the same room and name.
double drawn_factor(std::uint64_t seed, std::string_view name, double most) {
  return std::exp(std::log(most) * SplitMix64(seed ^ seed_of_name(name)).symmetric());
}

/// "Mixing A From B" and "Mixing B From A" name one opening, whose flows are equal.
std::string opening_of(const std::string& object) {
  constexpr std::string_view before = "Mixing ", between = " From ";
  const auto at = object.find(between);
  if (!object.starts_with(before) || at == std::string::npos) return object;
  std::string a = object.substr(before.size(), at - before.size()), b = object.substr(at + between.size());
  if (b < a) std::swap(a, b);
  return a + " - " + b;
}

/// A room that is nobody's twin: every number of room 301's patch, people, dampers, sensor and weather are drawn.
EnergyPlusOptions tuning_room(int number) {
  constexpr double most = 1.35;
  const auto seed = static_cast<std::uint64_t>(number) + 700000;
  EnergyPlusOptions options;
  add_patch(options, "301");
  for (auto& [type, objects] : options.patches.back().content.items()) {
    for (auto& [object, fields] : objects.items()) {
      for (auto& [field, value] : fields.items()) {
        if (value.is_number()) {
          value = value.get<double>() * drawn_factor(seed, type + '/' + opening_of(object) + '/' + field, most);
        }
      }
    }
  }
  SplitMix64 draw(seed);
  RoomLoopOptions& rooms = options.rooms;
  rooms.supply_bias_k = draw.symmetric();
  rooms.fcu_setpoint_degc += 0.8 * draw.symmetric();
  rooms.occupancy_scale = 1 + 0.1 * draw.symmetric();
  rooms.occupancy_shift_min = 20 * draw.symmetric();
  rooms.supply_lag_s *= 1 + draw.uniform();
  for (double& damper : rooms.dampers) damper *= 1 + 0.1 * draw.symmetric();
  options.weather_change = {draw.symmetric(), 1 + 0.15 * draw.symmetric(), 3 * draw.uniform()};
  options.seed = seed;
  return options;
}

}  // namespace

EnergyPlusOptions energyplus_room(const std::string& name) {
  EnergyPlusOptions options;
  options.name = name;
  if (name == "twin") return options;
  if (const auto number = tuning_number(name)) {
    options = tuning_room(*number);
    options.name = "room " + name;
    return options;
  }
  const bool real = name.ends_with("_real");
  const std::string room = real ? name.substr(0, name.size() - 5) : name;
  const auto* found = std::find_if(std::begin(habits), std::end(habits),
                                   [&room](const RoomHabits& habit) { return room == habit.name; });
  if (found == std::end(habits)) {
    std::string names;
    for (const auto& known : energyplus_room_names()) names += (names.empty() ? "" : ", ") + known;
    names += ", tuning_0 .. tuning_" + std::to_string(most_tuning_rooms - 1);
    throw hal::InputError("room", "'" + name + "'", "one of " + names, "choose one, or give a model and patches");
  }
  options.name = "room " + name;
  options.rooms.occupancy_scale = found->occupancy_scale;
  options.rooms.occupancy_shift_min = found->occupancy_shift_min;
  for (double& damper : options.rooms.dampers) damper *= found->damper_factor;
  options.seed = found->seed;
  add_patch(options, room);
  if (real) make_real(options, departures[found - std::begin(habits)]);
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
